#pragma once

#include <Eigen/SparseCore>
#include <limits>
#include <stdexcept>

#include "graphsolve/sparse_matrix.hpp"

/// `Eigen::SparseMatrix` both ways. Only this header needs Eigen; the library itself does not see it, so that your
/// Eigen, its version and its alignment are your own affair.
namespace graphsolve::io {

/// Any sparse expression of Eigen, row- or column-major, of any index type; self-adjoint views must be expanded
/// first. Entries of value zero are kept. Throws std::invalid_argument beyond 2^31 - 1 rows or columns.
template <class Derived>
SparseMatrix from_eigen(const Eigen::SparseMatrixBase<Derived>& expression) {
  // The result of an evaluation is column-major and sorted.
  const Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t> eigen =
      expression.derived().template cast<double>();
  constexpr Eigen::Index most = std::numeric_limits<int>::max();
  if (eigen.rows() > most || eigen.cols() > most)
    throw std::invalid_argument("a matrix of more than 2147483647 rows or columns");
  SparseMatrix matrix{static_cast<int>(eigen.rows()), static_cast<int>(eigen.cols()), {0}, {}, {}};
  matrix.begin.reserve(static_cast<std::size_t>(eigen.cols()) + 1);
  matrix.row.reserve(static_cast<std::size_t>(eigen.nonZeros()));
  matrix.value.reserve(static_cast<std::size_t>(eigen.nonZeros()));
  for (Eigen::Index j = 0; j < eigen.outerSize(); ++j) {
    for (typename decltype(eigen)::InnerIterator entry(eigen, j); entry; ++entry) {
      matrix.row.push_back(static_cast<int>(entry.row()));
      matrix.value.push_back(entry.value());
    }
    matrix.begin.push_back(static_cast<std::int64_t>(matrix.row.size()));
  }
  return matrix;
}

/// A copy, compressed. `Index` is the type of Eigen's indices; throws std::invalid_argument when it is too narrow for
/// the rows, the columns or the number of entries, and as check_columns does.
template <class Index = int, int Options = Eigen::ColMajor>
Eigen::SparseMatrix<double, Options, Index> to_eigen(const SparseMatrix& matrix) {
  check_columns(matrix);
  constexpr auto most = static_cast<std::int64_t>(std::numeric_limits<Index>::max());
  if (matrix.entries() > most) throw std::invalid_argument("more entries than this type of index can count");
  if (matrix.rows > most || matrix.columns > most)
    throw std::invalid_argument("more rows or columns than this type of index can count");
  Eigen::SparseMatrix<double, Eigen::ColMajor, Index> eigen(matrix.rows, matrix.columns);
  eigen.resizeNonZeros(static_cast<Eigen::Index>(matrix.entries()));
  for (int j = 0; j <= matrix.columns; ++j) eigen.outerIndexPtr()[j] = static_cast<Index>(matrix.begin[j]);
  for (std::int64_t k = 0; k < matrix.entries(); ++k) {
    eigen.innerIndexPtr()[k] = static_cast<Index>(matrix.row[k]);
    eigen.valuePtr()[k] = matrix.value[k];
  }
  return eigen;
}

}  // namespace graphsolve::io
