#include "graph/block_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graphsolve {

namespace {

std::string place(int i, int j) { return "entry (" + std::to_string(i + 1) + ", " + std::to_string(j + 1) + ")"; }

void check(const SparseMatrix& matrix) {
  if (matrix.rows != matrix.columns)
    throw std::invalid_argument("the matrix must be square, not " + std::to_string(matrix.rows) + " x " +
                                std::to_string(matrix.columns));
  if (matrix.rows == 0) throw std::invalid_argument("the matrix has no rows");
  check_columns(matrix);
  for (int j = 0; j < matrix.columns; ++j)
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k)
      if (!std::isfinite(matrix.value[k]))
        throw std::invalid_argument(place(matrix.row[k], j) + " of the matrix is not finite: " +
                                    std::to_string(matrix.value[k]));
}

}  // namespace

Pattern symmetric_pattern(const SparseMatrix& matrix) {
  check(matrix);
  const SparseMatrix other = transpose(matrix);
  Pattern pattern;
  pattern.diagonal.assign(static_cast<std::size_t>(matrix.rows), 0.0);
  pattern.begin.reserve(static_cast<std::size_t>(matrix.rows) + 1);
  pattern.row.reserve(static_cast<std::size_t>(matrix.entries()));
  for (int j = 0; j < matrix.columns; ++j) {
    std::int64_t a = matrix.begin[j], b = other.begin[j];
    const std::int64_t a_end = matrix.begin[j + 1], b_end = other.begin[j + 1];
    bool diagonal_done = false;
    while (a < a_end || b < b_end) {
      const int row_a = a < a_end ? matrix.row[a] : matrix.rows, row_b = b < b_end ? other.row[b] : matrix.rows;
      const int i = std::min(row_a, row_b);
      if (i >= j && !diagonal_done) {
        diagonal_done = true;
        if (i > j) pattern.row.push_back(j);
      }
      pattern.row.push_back(i);
      if (i == j) pattern.diagonal[j] = matrix.value[a];
      if (row_a != row_b) {
        ++pattern.added_entries;
        pattern.symmetric = false;
      } else if (!(matrix.value[a] == other.value[b])) {
        pattern.symmetric = false;
      }
      if (row_a == i) ++a;
      if (row_b == i) ++b;
    }
    if (!diagonal_done) pattern.row.push_back(j);
    pattern.begin.push_back(static_cast<std::int64_t>(pattern.row.size()));
  }
  // Each missing entry was met twice: in its own column and in its partner's.
  pattern.added_entries /= 2;
  return pattern;
}

std::string name_of_rows(std::span<const int> rows) {
  if (rows.size() == 1) return "row " + std::to_string(rows[0] + 1);
  std::string name;
  constexpr int most_ranges = 3;
  int ranges = 0;
  for (std::size_t i = 0; i < rows.size(); ++ranges) {
    if (ranges == most_ranges) return "rows " + name + " and " + std::to_string(rows.size() - i) + " more";
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end] == rows[end - 1] + 1) ++end;
    name += (ranges ? ", " : "") + std::to_string(rows[i] + 1);
    if (end - i > 1) name += "-" + std::to_string(rows[end - 1] + 1);
    i = end;
  }
  return "rows " + name;
}

}  // namespace graphsolve
