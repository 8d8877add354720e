#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/sparse_matrix.hpp"

namespace graphsolve {

/// A square matrix seen as blocks: the graph of its blocks, and where each row (and column) of the matrix stands in
/// it. The graph numbers rows node by node; the matrix in any way.
struct BlockStructure {
  BlockGraph graph;
  std::vector<int> row_of;         ///< matrix row i is row row_of[i] of the graph: a permutation
  std::int64_t added_entries = 0;  ///< entries that the matrix had not and that make its pattern symmetric: zeros
  bool symmetric = false;          ///< the matrix is, pattern and values

  /// graph_rows[row_of[i]] := matrix_rows[i], and back. Lengths: rows(). Throws std::invalid_argument for another
  /// one, and where the two overlap.
  void to_graph(std::span<const double> matrix_rows, std::span<double> graph_rows) const;
  void to_matrix(std::span<const double> graph_rows, std::span<double> matrix_rows) const;
  /// Rows of the matrix that make up a node, from 0, in the order of the node's rows.
  [[nodiscard]] std::vector<int> matrix_rows(NodeId node) const;
};

struct DetectionSettings {
  int largest_block = 64;  ///< longer runs of equal rows are cut into parts of equal size
};

/// Finds blocks in the pattern of a square matrix, made symmetric first:
///
///   1. rows of equal pattern, diagonal included, become one block (indistinguishable rows: eliminating one of them
///      makes no fill that the others would not make too);
///   2. rows of zero diagonal and equal pattern, not coupled with each other, become one block (the rows of one
///      constraint: whatever is eliminated first couples them all).
///
/// Blocks are numbered by their first row and named by their rows, counted from 1 as in files: "rows 4-9", "row 7".
/// Cost O(entries + rows log rows), by a hash of each pattern that is checked before it is believed.
///
/// Kinds, from the values. A block is
///   saddle or semidefinite  when its diagonal block is zero. Blocks of zero diagonal that are coupled with each other
///                           are told apart by two colours: a costless variable is coupled with constraints only
///                           (a positive semidefinite matrix with a zero on its diagonal has a zero row there), so
///                           the colour that touches other blocks is the constraints'; when both or none do, the one
///                           with more rows. Alone, or where two colours do not suffice: saddle.
///   saddle                  when the matrix is symmetric, its diagonal entries are all negative, and it has
///                           neighbours, whose diagonals are all positive: the dual of a quasi-definite system.
///   shared                  when it would be regular, is coupled with more than max(16, 10 sqrt(blocks)) blocks, more
///                           than 16 of them saddle, and all saddle rows can be matched with columns of other blocks,
///                           each entry at least a thousandth of the largest of its row: such as the final time of a
///                           control problem. Eliminated before the constraints it would couple them all. Rows that
///                           can be matched may depend all the same; then the factorization says so.
///   regular                 otherwise. It may be indefinite: then the factorization watches it.
/// The rank of a coupling between a saddle (or semidefinite) block and what it waits for is full where the smallest
/// pivot of a rank-revealing QR of the coupling, in both triangles, reaches a thousandth of the block's largest entry
/// off the diagonal.
/// Throws std::invalid_argument when the matrix is not square, has no rows, or holds a value that is not finite,
/// naming it.
BlockStructure detect_blocks(const SparseMatrix& matrix, const DetectionSettings& settings = {});

/// A block that the user names.
struct Block {
  std::string name;
  std::vector<int> rows;  ///< of the matrix, from 0
  std::optional<NodeKind> kind = std::nullopt;  ///< none: from the values
};
/// What the user knows of the coupling between two blocks, seen from the saddle one.
struct BlockCoupling {
  int a = 0, b = 0;  ///< indices of blocks
  EdgeRank rank = EdgeRank::unknown;
};

/// The same with blocks given by the user; every row must be in exactly one. Couplings that the pattern has not are
/// added to the graph: room for later entries. Throws std::invalid_argument as above, and naming the row or the
/// block that is wrong.
BlockStructure make_blocks(const SparseMatrix& matrix, std::span<const Block> blocks,
                           std::span<const BlockCoupling> couplings = {});

/// Blocks of these sizes, one after the other, named by their rows.
std::vector<Block> consecutive_blocks(std::span<const int> sizes);

}  // namespace graphsolve
