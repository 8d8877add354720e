#include <charconv>
#include <cmath>
#include <stdexcept>

#include "io/matrix_market_lines.hpp"

namespace graphsolve::io {

namespace {

void append(std::string& text, double value) {
  char buffer[32];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

void append(std::string& text, std::int64_t value) {
  char buffer[24];
  text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

void append_comment(std::string& text, std::string_view comment) {
  while (!comment.empty()) {
    const std::size_t end = std::min(comment.find('\n'), comment.size());
    text.append("% ").append(comment.substr(0, end)).push_back('\n');
    comment.remove_prefix(std::min(end + 1, comment.size()));
  }
}

std::string_view name(Field field) {
  return field == Field::real ? "real" : field == Field::integer ? "integer" : "pattern";
}
std::string_view name(Symmetry symmetry) {
  return symmetry == Symmetry::general ? "general" : symmetry == Symmetry::symmetric ? "symmetric" : "skew-symmetric";
}

std::string place(int i, int j) { return "entry (" + std::to_string(i + 1) + ", " + std::to_string(j + 1) + ")"; }

void check_value(int i, int j, double value, Field field) {
  if (!std::isfinite(value)) throw std::invalid_argument(place(i, j) + " is not finite");
  if (field != Field::integer) return;
  if (value != std::trunc(value)) throw std::invalid_argument(place(i, j) + " is no integer: " + std::to_string(value));
  if (std::abs(value) > static_cast<double>(largest_integer))
    throw std::invalid_argument(place(i, j) + " lies beyond 2^53, where a double does not hold every integer");
}

void check_symmetry(const SparseMatrix& matrix, Symmetry kind) {
  const SparseMatrix other = transpose(matrix);
  const double sign = kind == Symmetry::symmetric ? 1 : -1;
  if (matrix.rows != matrix.columns || other.row != matrix.row || other.begin != matrix.begin)
    throw std::invalid_argument("the pattern of the matrix is not symmetric");
  for (int j = 0; j < matrix.columns; ++j) {
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      if (sign < 0 && matrix.row[k] == j) throw std::invalid_argument(place(j, j) + " of a skew-symmetric matrix");
      if (other.value[k] != sign * matrix.value[k])
        throw std::invalid_argument(place(matrix.row[k], j) + " has no equal on the other side of the diagonal");
      // Only one of the two is written. Skew zeros come in any signs, from A - A^T in equal ones; nothing depends on them.
      if (kind == Symmetry::symmetric && std::signbit(other.value[k]) != std::signbit(matrix.value[k]))
        throw std::invalid_argument(place(matrix.row[k], j) + " is a zero of another sign than that on the other side of " +
                                    "the diagonal");
    }
  }
}

}  // namespace

std::string matrix_market(const SparseMatrix& matrix, const WriteOptions& options) {
  if (options.symmetry != Symmetry::general) check_symmetry(matrix, options.symmetry);
  const auto written = [&](int i, int j) { return options.symmetry == Symmetry::general || i >= j; };
  std::int64_t entries = 0;
  for (int j = 0; j < matrix.columns; ++j)
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) entries += written(matrix.row[k], j);
  std::string text = "%%MatrixMarket matrix coordinate ";
  text.append(name(options.field)).append(" ").append(name(options.symmetry)).push_back('\n');
  append_comment(text, options.comment);
  text += std::to_string(matrix.rows) + " " + std::to_string(matrix.columns) + " " + std::to_string(entries) + "\n";
  for (int j = 0; j < matrix.columns; ++j) {
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      const int i = matrix.row[k];
      if (!written(i, j)) continue;
      append(text, std::int64_t{i} + 1);
      text.push_back(' ');
      append(text, std::int64_t{j} + 1);
      if (options.field != Field::pattern) {
        check_value(i, j, matrix.value[k], options.field);
        text.push_back(' ');
        if (options.field == Field::integer) append(text, static_cast<std::int64_t>(matrix.value[k]));
        else append(text, matrix.value[k]);
      }
      text.push_back('\n');
    }
  }
  return text;
}

std::string matrix_market(std::span<const double> values, int rows, std::string_view comment) {
  const std::size_t size = values.size();
  if (rows < 0 || (rows == 0 ? size != 0 : size % static_cast<std::size_t>(rows) != 0))
    throw std::invalid_argument(std::to_string(size) + " values do not fill columns of " + std::to_string(rows));
  const std::size_t columns = rows == 0 ? 0 : size / static_cast<std::size_t>(rows);
  std::string text = "%%MatrixMarket matrix array real general\n";
  append_comment(text, comment);
  text += std::to_string(rows) + " " + std::to_string(columns) + "\n";
  for (std::size_t k = 0; k < size; ++k) {
    check_value(static_cast<int>(k % rows), static_cast<int>(k / rows), values[k], Field::real);
    append(text, values[k]);
    text.push_back('\n');
  }
  return text;
}

}  // namespace graphsolve::io
