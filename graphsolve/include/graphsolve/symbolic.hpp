#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/ordering.hpp"

namespace graphsolve {

namespace simd {
class Program;
}

/// Where one block of the matrix lies in the value array: column-major, `rows` x `columns`, entries `stride` apart.
/// Blocks of equal pivots are interleaved, lane by lane, so that eight of them are read and written as one.
struct BlockHandle {
  std::int64_t offset = -1;  ///< of entry (0, 0)
  int rows = 0;
  int columns = 0;
  int stride = 1;
  /// Of entry (row, column).
  [[nodiscard]] std::int64_t place(int row, int column) const {
    return offset + (static_cast<std::int64_t>(column) * rows + row) * stride;
  }
};

/// Whether equal pivots are eliminated up to eight at a time (SIMD, without exchanges of rows where that is sound) or
/// all of them one by one. Decides how the values are laid out.
enum class Packs { on, off };

/// The elimination of a graph in a given order, worked out once: tree, fill, offsets, counts. Immutable;
/// shared by threads.
class Symbolic {
 public:
  /// Cost O(nodes + blocks of the factor). The components of the graph become contiguous ranges of pivots,
  /// in the order of connected_components; within each the given order is kept. Throws std::invalid_argument where the
  /// order does not name every node of the graph once, std::length_error beyond 2^31 - 1 blocks of the factor. Nodes and
  /// pivots that are given to the functions below are not checked.
  Symbolic(const BlockGraph& graph, const Ordering& ordering, Packs packs = Packs::on);

  struct Counts {
    static constexpr int rows_at_once = 4;
    std::int64_t fill_blocks = 0;       ///< off-diagonal blocks (one triangle) that are not in the graph
    std::int64_t stored_blocks = 0;     ///< all blocks of the factor, both triangles and diagonal
    std::int64_t stored_scalars = 0;    ///< scalars in them
    std::int64_t matrix_scalars = 0;    ///< scalars of the matrix alone
    std::int64_t operations = 0;        ///< multiplications and divisions of one LDU factorization, 2^63 - 1 at most
    std::int64_t symmetric_operations = 0;  ///< same of one LDL^T or Cholesky factorization of definite blocks
    /// Of one LDU factorization, eight equal pivots of one level counted as one. Rows of a pivot that goes alone and has more
    /// than six of them are worked on together too: four operations of it count as one.
    std::int64_t pack_operations = 0;
    std::int64_t symmetric_pack_operations = 0;  ///< same of one LDL^T or Cholesky factorization
    std::int64_t solve_operations = 0;  ///< same of one solve
    std::int64_t memory = 0;            ///< bytes: this object and one Factorization of kind ldu
    int tree_height = 0;                ///< longest path of the elimination tree, in nodes
    int largest_front = 0;              ///< rows of the largest pivot block and what stands under it
  };

  [[nodiscard]] const Counts& counts() const { return counts_; }
  [[nodiscard]] int pivots() const { return static_cast<int>(pivots_.size()); }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int components() const { return static_cast<int>(component_begin_.size()) - 1; }
  /// Component of a node; the pivots of component c are component_begin(c) .. component_begin(c + 1) - 1.
  [[nodiscard]] int component(NodeId node) const { return component_of_[node.index]; }
  [[nodiscard]] int component_begin(int component) const { return component_begin_[component]; }
  [[nodiscard]] NodeId node(int pivot) const { return pivots_[pivot].node; }
  [[nodiscard]] int position(NodeId node) const { return position_[node.index]; }
  [[nodiscard]] int dimension(int pivot) const { return pivots_[pivot].dimension; }
  [[nodiscard]] int row(int pivot) const { return pivots_[pivot].row; }  ///< first row in the user's numbering
  /// A saddle block that the eligibility rule does not vouch for: its rows may depend on earlier ones.
  [[nodiscard]] bool may_depend(int pivot) const { return pivots_[pivot].may_depend; }
  /// Parent in the elimination tree, or -1.
  [[nodiscard]] int parent(int pivot) const { return pivots_[pivot].parent; }
  /// Later pivots coupled to this one in the factor, ascending.
  [[nodiscard]] std::span<const int> coupled(int pivot) const;
  /// Is this coupling of `pivot` with `coupled(pivot)[k]` fill?
  [[nodiscard]] bool is_fill(int pivot, int k) const { return fill_[pivots_[pivot].begin + k] != 0; }

  /// Block (a, b) of the matrix; a == b is the diagonal block. Throws std::invalid_argument where the graph has no such edge
  /// (a block of the factor alone is no place for numbers of the matrix), and for a node that is not there.
  [[nodiscard]] BlockHandle block(NodeId a, NodeId b) const;
  /// Length of the value array: stored_scalars, and what interleaving leaves unused.
  [[nodiscard]] std::int64_t values_size() const { return values_size_; }
  [[nodiscard]] Packs packs() const { return packs_; }

  // Plan for the numeric phase: for kernels and terms that read it, without a promise from one version to the next.
  struct Pivot {
    NodeId node;
    int dimension;
    int row;
    int parent;
    bool saddle;
    bool may_depend;
    bool leaf;              ///< of the elimination tree: no other pivot changes its blocks
    int begin, end;         ///< range in the coupled list
    int coupled_rows;       ///< sum of the coupled dimensions
    int stride;             ///< from a scalar of its blocks to the next
    std::int64_t diagonal;  ///< offset of the diagonal block
    std::int64_t lower;     ///< offset of the blocks below it, one after the other
    std::int64_t upper;     ///< offset of the blocks right of it, side by side; apart from the others
    std::int64_t targets;   ///< first of the offsets that its elimination updates
    int target_stride;      ///< of their rows
    /// Scalars in its diagonal block and both panels.
    [[nodiscard]] std::int64_t scalars() const { return lower_scalars() + upper_scalars(); }
    /// In its diagonal block and the panel below, which lie one after the other.
    [[nodiscard]] std::int64_t lower_scalars() const {
      return static_cast<std::int64_t>(dimension) * (dimension + coupled_rows);
    }
    [[nodiscard]] std::int64_t upper_scalars() const { return static_cast<std::int64_t>(dimension) * coupled_rows; }
  };
  [[nodiscard]] const Pivot& pivot(int k) const { return pivots_[k]; }
  /// Where the blocks of each of its couplings begin, in scalars within the lower and within the upper panel.
  [[nodiscard]] const std::int64_t* block_offsets(const Pivot& p) const { return block_offset_.data() + p.begin; }
  /// Offset of the block (coupling i, coupling j) at [i * p.target_stride + j].
  [[nodiscard]] const std::int64_t* targets(const Pivot& p) const { return targets_.data() + p.targets; }
  /// The same elimination, equal pivots of one level side by side (src/simd/program.hpp).
  [[nodiscard]] const simd::Program& program() const { return *program_; }

 private:
  void find_uncertain(const BlockGraph& graph);
  void find_structure(const BlockGraph& graph);
  void lay_out(simd::Program& program);
  void lay_out_group(simd::Program& program, int group);
  void count();
  void plan_updates();
  void count_memory();
  [[nodiscard]] int find(int pivot, int later) const;

  std::vector<Pivot> pivots_;
  std::vector<int> position_, component_of_, component_begin_;
  std::vector<int> coupled_;
  std::vector<char> fill_;
  std::vector<std::int64_t> block_offset_;  ///< per coupling, see block_offsets
  std::vector<std::int64_t> targets_;
  std::int64_t values_size_ = 0;
  int rows_ = 0;
  Packs packs_;
  Counts counts_;
  std::shared_ptr<const simd::Program> program_;
};

}  // namespace graphsolve
