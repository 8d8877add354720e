#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "graphsolve/block_detection.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/sparse_matrix.hpp"
#include "graphsolve/symbolic.hpp"

namespace graphsolve {

enum class FactorizationKind;

/// Places of the entries of a matrix in the value array of a Factorization, found once; new numbers in the same
/// pattern then take one pass.
class EntryMap {
 public:
  /// Throws std::invalid_argument when the matrix is malformed, the symbolic is of another graph, or has no block for an entry.
  EntryMap(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic);
  /// Only what a factorization of this kind reads: of the symmetric ones a triangle. The rest stays as it is.
  EntryMap(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic, FactorizationKind kind);
  /// factor_values := the matrix, zeros where it has none. `values` as in SparseMatrix::value, factor_values of
  /// Symbolic::values_size(); other lengths, and the two overlapping, throw std::invalid_argument.
  /// Allocates nothing.
  void write(std::span<const double> values, std::span<double> factor_values) const;

 private:
  /// Entries of the matrix that follow each other, and lie `stride` apart in the values of the factor.
  struct Run {
    std::int64_t place;   ///< of the first in the factor
    std::int64_t number;  ///< of the first in the matrix
    int count, stride;
  };
  /// Runs of as many entries in neighbouring lanes: each line of the factor is filled at one time.
  struct Sheaf {
    std::int64_t place;
    std::int64_t count;
    std::array<std::int64_t, simd::lanes> numbers;
  };
  struct Gap {
    std::int64_t begin, end;
  };
  void find_runs(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic, bool both_triangles);
  void find_gaps(const Symbolic& symbolic, FactorizationKind kind);
  void bind_sheaves();

  std::vector<Run> runs_;       ///< by place
  std::vector<Sheaf> sheaves_;  ///< by place
  std::vector<Gap> gaps_;       ///< zeros: places in the factor that are read, but have no entry
  std::size_t entries_;         ///< of the matrix
  std::int64_t values_size_;    ///< of the factor
};

}  // namespace graphsolve
