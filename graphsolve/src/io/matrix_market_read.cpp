#include <algorithm>

#include "graphsolve/io/text_file.hpp"
#include "io/matrix_market_lines.hpp"

namespace graphsolve::io {

namespace {

/// No more than the file can hold: the size line may be wrong.
std::size_t room(const Lines& lines, const Header& header) {
  return static_cast<std::size_t>(std::min<std::uint64_t>(header.entries, lines.size() / 2 + 1));
}

constexpr std::size_t longest_line = 1 << 16;

/// Of entries that were read one by one; nullptr: nothing.
const char* wrong_sum(const Header& header, double value) {
  if (!std::isfinite(value)) return "no finite value";
  const bool beyond = header.field == Field::integer && std::abs(value) > static_cast<double>(largest_integer);
  return beyond ? "an integer beyond 2^53, where a double does not hold every one" : nullptr;
}

double mirrored(Symmetry symmetry, double value) { return symmetry == Symmetry::skew_symmetric ? -value : value; }

}  // namespace

MatrixFile parse_matrix_market(std::string_view text, std::string_view name) {
  Lines lines(text, name);
  const Header header = read_header(lines);
  const bool both = header.symmetry != Symmetry::general;
  std::vector<Triplet> triplets;
  triplets.reserve(room(lines, header) * (both ? 2 : 1));
  std::int64_t on_diagonal = 0;
  for_each_entry(lines, header, [&](int i, int j, double value) {
    if (header.format == Header::Format::array && value == 0) return;
    triplets.push_back({i, j, value});
    if (i == j) ++on_diagonal;
    else if (both) triplets.push_back({j, i, mirrored(header.symmetry, value)});
  });
  MatrixFile file{from_triplets(header.rows, header.columns, triplets), header.field, header.symmetry, 0};
  std::int64_t kept_diagonal = 0;
  for (int j = 0; j < file.matrix.columns; ++j)
    for (std::int64_t k = file.matrix.begin[j]; k < file.matrix.begin[j + 1]; ++k) kept_diagonal += file.matrix.row[k] == j;
  const std::int64_t lost_diagonal = on_diagonal - kept_diagonal;
  const std::int64_t lost = static_cast<std::int64_t>(triplets.size()) - file.matrix.entries();
  file.repeated = both ? lost_diagonal + (lost - lost_diagonal) / 2 : lost;
  if (header.field == Field::pattern) std::fill(file.matrix.value.begin(), file.matrix.value.end(), 1.0);
  for (int j = 0; j < file.matrix.columns; ++j)
    for (std::int64_t k = file.matrix.begin[j]; k < file.matrix.begin[j + 1]; ++k)
      if (const char* wrong = wrong_sum(header, file.matrix.value[k]))
        lines.fail_file("the repeated entries (" + std::to_string(file.matrix.row[k] + 1) + ", " + std::to_string(j + 1) +
                        ") add up to " + wrong);
  return file;
}

MatrixFile read_matrix_market(const std::string& path) { return parse_matrix_market(read_text(path, longest_line), path); }

DenseMatrix parse_dense_matrix_market(std::string_view text, std::string_view name) {
  Lines lines(text, name);
  const Header header = read_header(lines);
  const std::int64_t size = static_cast<std::int64_t>(header.rows) * header.columns;
  if (size > 1024 && static_cast<std::uint64_t>(size) / 64 > lines.size())
    lines.fail("a dense matrix of " + std::to_string(header.rows) + " x " + std::to_string(header.columns) +
               " is more than a file of " + std::to_string(lines.size()) + " bytes can fill");
  DenseMatrix dense{header.rows, header.columns, std::vector<double>(static_cast<std::size_t>(size), 0.0)};
  const bool both = header.symmetry != Symmetry::general;
  const auto at = [&](int i, int j) -> double& {
    return dense.value[static_cast<std::size_t>(j) * header.rows + i];
  };
  for_each_entry(lines, header, [&](int i, int j, double value) {
    at(i, j) += value;
    if (const char* wrong = wrong_sum(header, at(i, j))) lines.fail(std::string("the repeated entries here add up to ") + wrong);
    if (both && i != j) at(j, i) += mirrored(header.symmetry, value);
  });
  return dense;
}

DenseMatrix read_dense_matrix_market(const std::string& path) {
  return parse_dense_matrix_market(read_text(path, longest_line), path);
}

}  // namespace graphsolve::io
