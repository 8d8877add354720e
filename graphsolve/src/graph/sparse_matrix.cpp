#include "graphsolve/sparse_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "graphsolve/largest.hpp"
#include "graphsolve/overlap.hpp"

namespace graphsolve {

namespace {

/// Entries by row, in the order given: a counting sort.
std::vector<std::int64_t> sorted_by_row(int rows, std::span<const Triplet> triplets) {
  std::vector<std::int64_t> next(static_cast<std::size_t>(rows) + 1, 0);
  for (const Triplet& t : triplets) ++next[t.row + 1];
  for (int i = 0; i < rows; ++i) next[i + 1] += next[i];
  std::vector<std::int64_t> order(triplets.size());
  for (std::size_t k = 0; k < triplets.size(); ++k) order[next[triplets[k].row]++] = static_cast<std::int64_t>(k);
  return order;
}

void check(int rows, int columns, std::span<const Triplet> triplets) {
  if (rows < 0 || columns < 0)
    throw std::invalid_argument("a matrix cannot have " + std::to_string(std::min(rows, columns)) + " rows or columns");
  for (const Triplet& t : triplets)
    if (t.row < 0 || t.row >= rows || t.column < 0 || t.column >= columns)
      throw std::invalid_argument("entry (" + std::to_string(t.row) + ", " + std::to_string(t.column) +
                                  ") lies outside of a matrix of " + std::to_string(rows) + " x " +
                                  std::to_string(columns));
}

void check_length(const char* what, std::size_t given, int needed) {
  if (given != static_cast<std::size_t>(needed))
    throw std::invalid_argument(std::string(what) + " has " + std::to_string(given) + " numbers, the matrix needs " +
                                std::to_string(needed));
}

}  // namespace

void check_columns(const SparseMatrix& matrix) {
  if (matrix.rows < 0 || matrix.columns < 0)
    throw std::invalid_argument("a matrix cannot have " + std::to_string(std::min(matrix.rows, matrix.columns)) + " rows or columns");
  const auto& begin = matrix.begin;
  const auto entries = static_cast<std::int64_t>(matrix.row.size());
  if (begin.size() != static_cast<std::size_t>(matrix.columns) + 1 || begin.front() != 0 || begin.back() != entries ||
      !std::ranges::is_sorted(begin) || matrix.value.size() != matrix.row.size())
    throw std::invalid_argument("the columns of the matrix do not fit its " + std::to_string(matrix.row.size()) +
                                " rows and " + std::to_string(matrix.value.size()) + " values");
  for (int j = 0; j < matrix.columns; ++j)
    for (std::int64_t k = begin[j]; k < begin[j + 1]; ++k)
      if (matrix.row[k] < 0 || matrix.row[k] >= matrix.rows || (k > begin[j] && matrix.row[k] <= matrix.row[k - 1]))
        throw std::invalid_argument("column " + std::to_string(j + 1) + " of the matrix: row " +
                                    std::to_string(matrix.row[k] + std::int64_t{1}) +
                                    " lies outside or is not in order");
}

SparseMatrix from_triplets(int rows, int columns, std::span<const Triplet> triplets) {
  check(rows, columns, triplets);
  const std::vector<std::int64_t> by_row = sorted_by_row(rows, triplets);
  SparseMatrix matrix{rows, columns, std::vector<std::int64_t>(static_cast<std::size_t>(columns) + 1, 0), {}, {}};
  std::vector<std::int64_t>& begin = matrix.begin;
  for (const Triplet& t : triplets) ++begin[t.column + 1];
  for (int j = 0; j < columns; ++j) begin[j + 1] += begin[j];
  matrix.row.resize(triplets.size());
  matrix.value.resize(triplets.size());
  // Rows come in ascending order into every column; a repeated one meets its like at the end of the column so far.
  std::vector<std::int64_t> end(begin.begin(), begin.end() - 1);
  for (const std::int64_t k : by_row) {
    const Triplet& t = triplets[k];
    std::int64_t& at = end[t.column];
    if (at > begin[t.column] && matrix.row[at - 1] == t.row) {
      matrix.value[at - 1] += t.value;
      continue;
    }
    matrix.row[at] = t.row;
    matrix.value[at++] = t.value;
  }
  std::int64_t size = 0;  // close the gaps that repeated entries left
  for (int j = 0; j < columns; ++j) {
    const std::int64_t first = begin[j];
    begin[j] = size;
    for (std::int64_t k = first; k < end[j]; ++k, ++size) {
      matrix.row[size] = matrix.row[k];
      matrix.value[size] = matrix.value[k];
    }
  }
  begin[columns] = size;
  matrix.row.resize(size);
  matrix.value.resize(size);
  return matrix;
}

SparseMatrix transpose(const SparseMatrix& matrix) {
  check_columns(matrix);
  SparseMatrix result{matrix.columns, matrix.rows, std::vector<std::int64_t>(static_cast<std::size_t>(matrix.rows) + 1, 0),
                      std::vector<int>(matrix.row.size()), std::vector<double>(matrix.value.size())};
  for (const int i : matrix.row) ++result.begin[i + 1];
  for (int i = 0; i < matrix.rows; ++i) result.begin[i + 1] += result.begin[i];
  std::vector<std::int64_t> next(result.begin.begin(), result.begin.end() - 1);
  for (int j = 0; j < matrix.columns; ++j) {
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      const std::int64_t at = next[matrix.row[k]]++;
      result.row[at] = j;
      result.value[at] = matrix.value[k];
    }
  }
  return result;
}

SymmetryReport symmetry(const SparseMatrix& matrix) {
  const SparseMatrix other = transpose(matrix);
  SymmetryReport report;
  if (matrix.rows != matrix.columns) {
    report.unmatched = matrix.entries();
    return report;
  }
  report.symmetric = true;
  for (int j = 0; j < matrix.columns; ++j) {
    std::int64_t t = other.begin[j];
    const std::int64_t end = other.begin[j + 1];
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      while (t < end && other.row[t] < matrix.row[k]) ++t;
      const bool matched = t < end && other.row[t] == matrix.row[k];
      if (!matched) ++report.unmatched;
      if (!matched || !(other.value[t] == matrix.value[k])) report.symmetric = false;
    }
  }
  return report;
}

void multiply(const SparseMatrix& matrix, std::span<const double> x, std::span<double> y) {
  check_length("x", x.size(), matrix.columns);
  check_length("y", y.size(), matrix.rows);
  check_apart("multiply", x, y);
  std::fill(y.begin(), y.end(), 0.0);
  for (int j = 0; j < matrix.columns; ++j)
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) y[matrix.row[k]] += matrix.value[k] * x[j];
}

BackwardError backward_error(const SparseMatrix& matrix, std::span<const double> b, std::span<const double> x) {
  check_length("x", x.size(), matrix.columns);
  check_length("b", b.size(), matrix.rows);
  const std::size_t n = static_cast<std::size_t>(matrix.rows);
  std::vector<long double> r(b.begin(), b.end());
  std::vector<double> magnitude(n), row_sum(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) magnitude[i] = std::abs(b[i]);
  for (int j = 0; j < matrix.columns; ++j) {
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      const int i = matrix.row[k];
      r[i] -= static_cast<long double>(matrix.value[k]) * x[j];
      magnitude[i] += std::abs(matrix.value[k] * x[j]);
      row_sum[i] += std::abs(matrix.value[k]);
    }
  }
  BackwardError error;
  double residual = 0, matrix_norm = 0, x_norm = 0, b_norm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double r_i = static_cast<double>(std::abs(r[i]));
    keep_largest(residual, r_i);
    keep_largest(matrix_norm, row_sum[i]);
    keep_largest(b_norm, std::abs(b[i]));
    if (!(r_i == 0)) keep_largest(error.componentwise, r_i / magnitude[i]);
  }
  for (const double x_j : x) keep_largest(x_norm, std::abs(x_j));
  if (!(residual == 0)) error.normwise = residual / (matrix_norm * x_norm + b_norm);
  return error;
}

}  // namespace graphsolve
