#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace graphsolve {

/// A sparse matrix in compressed columns: the entries of column j are begin[j] .. begin[j + 1] - 1, rows strictly
/// ascending. What files and other libraries exchange with the block graph (block_detection.hpp).
struct SparseMatrix {
  int rows = 0;
  int columns = 0;
  std::vector<std::int64_t> begin{0};  ///< columns + 1
  std::vector<int> row;                ///< per entry, from 0
  std::vector<double> value;           ///< per entry

  [[nodiscard]] std::int64_t entries() const { return begin.back(); }
};

/// A matrix that somebody put together by hand may point anywhere: throws std::invalid_argument when columns, rows and
/// values do not fit each other.
void check_columns(const SparseMatrix& matrix);

/// One entry, for building a matrix.
struct Triplet {
  int row;
  int column;
  double value;
};

/// Entries in any order; those at the same place are added in the order given. Cost O(entries + rows + columns).
/// Throws std::invalid_argument when an entry lies outside.
SparseMatrix from_triplets(int rows, int columns, std::span<const Triplet> triplets);

/// Throws as check_columns does; so does symmetry().
SparseMatrix transpose(const SparseMatrix& matrix);

/// How the two triangles of a square matrix compare. An entry of value zero is an entry.
struct SymmetryReport {
  std::int64_t unmatched = 0;  ///< entries (i, j) without an entry (j, i)
  bool symmetric = false;      ///< pattern and values, bit for bit
};
SymmetryReport symmetry(const SparseMatrix& matrix);

/// y := A x. x has `columns` entries, y has `rows`; another length throws std::invalid_argument, here and below;
/// so do x and y that overlap.
void multiply(const SparseMatrix& matrix, std::span<const double> x, std::span<double> y);

/// Backward errors of a solution x of A x = b, with r = b - A x summed in long double; NaN when x holds one.
struct BackwardError {
  double normwise = 0;       ///< |r| / (|A| |x| + |b|), infinity norms (Rigal and Gaches)
  double componentwise = 0;  ///< max_i |r|_i / (|A| |x| + |b|)_i (Oettli and Prager); 0/0 is 0
};
BackwardError backward_error(const SparseMatrix& matrix, std::span<const double> b, std::span<const double> x);

}  // namespace graphsolve
