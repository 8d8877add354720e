#include "io/matrix_market_lines.hpp"

#include <algorithm>
#include <cctype>
#include <limits>

#include "io/shown.hpp"

namespace graphsolve::io {

namespace {

constexpr std::string_view blanks = " \t\r\f\v";

std::string in_quotes(std::string_view word) {
  constexpr std::size_t most = 40;
  return "'" + shown(word.substr(0, most)) + (word.size() > most ? "..." : "") + "'";
}

/// from_chars takes no plus sign.
std::string_view without_plus(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+';
  return plus ? word.substr(1) : word;
}

std::string lower(std::string_view word) {
  std::string text(word);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

Lines::Lines(std::string_view text, std::string_view name)
    : text_(text), name_(name), line_end_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {
  if (constexpr std::string_view mark = "\xef\xbb\xbf"; text.starts_with(mark)) at_ = mark.size();
}

bool Lines::next_raw() {
  if (at_ >= text_.size()) return false;
  const std::size_t end = std::min(text_.find(line_end_, at_), text_.size());
  rest_ = text_.substr(at_, end - at_);
  at_ = end + 1;
  ++line_;
  return true;
}

bool Lines::next() {
  while (next_raw()) {
    const std::size_t first = rest_.find_first_not_of(blanks);
    if (first != std::string_view::npos && rest_[first] != '%') return true;
  }
  return false;
}

std::string_view Lines::word() {
  const std::size_t first = rest_.find_first_not_of(blanks);
  if (first == std::string_view::npos) return rest_ = {};
  const std::size_t end = std::min(rest_.find_first_of(blanks, first), rest_.size());
  const std::string_view found = rest_.substr(first, end - first);
  rest_.remove_prefix(end);
  return found;
}

std::int64_t Lines::integer(std::string_view what) {
  const std::string_view found = word();
  if (found.empty()) fail("the " + std::string(what) + " is missing");
  const std::string_view digits = without_plus(found);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range) fail("the " + std::string(what) + " " + in_quotes(found) + " is too large");
  if (error != std::errc() || end != digits.data() + digits.size())
    fail("the " + std::string(what) + " " + in_quotes(found) + " is no integer");
  return value;
}

double Lines::number(std::string_view what) {
  const std::string_view found = word();
  if (found.empty()) fail("the " + std::string(what) + " is missing");
  const std::string_view digits = without_plus(found);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool whole = end == digits.data() + digits.size();
  if (error == std::errc::result_out_of_range && whole) {
    // Too small is zero (or denormal), too large is no number: strtod tells which.
    value = std::strtod(std::string(digits).c_str(), nullptr);
    if (std::abs(value) < 1) return value;
    fail("the " + std::string(what) + " " + in_quotes(found) + " is too large");
  }
  if (error != std::errc() || !whole) fail("the " + std::string(what) + " " + in_quotes(found) + " is no number");
  if (!std::isfinite(value)) fail("the " + std::string(what) + " " + in_quotes(found) + " is not finite");
  return value;
}

void Lines::end() {
  if (const std::string_view extra = word(); !extra.empty()) fail(in_quotes(extra) + " follows where the line should end");
}

namespace {

Header read_banner(Lines& lines) {
  if (!lines.next_raw()) lines.fail_file("the file is empty");
  // Errors quote the words as they stand in the file.
  const std::string_view first = lines.word();
  if (lower(first) != "%%matrixmarket")
    lines.fail("this is no Matrix Market file: it begins with " + in_quotes(first) + ", not '%%MatrixMarket'");
  const std::string_view object_word = lines.word(), format_word = lines.word(), field_word = lines.word(),
                         symmetry_word = lines.word();
  const std::string format = lower(format_word), field = lower(field_word), symmetry = lower(symmetry_word);
  if (lower(object_word) != "matrix") lines.fail("the object must be 'matrix', not " + in_quotes(object_word));
  Header header;
  if (format == "array") header.format = Header::Format::array;
  else if (format != "coordinate") lines.fail("the format must be 'coordinate' or 'array', not " + in_quotes(format_word));
  if (field == "integer") header.field = Field::integer;
  else if (field == "pattern") header.field = Field::pattern;
  else if (field == "complex") lines.fail("complex values are not supported");
  else if (field != "real" && field != "double")
    lines.fail("the field must be 'real', 'integer' or 'pattern', not " + in_quotes(field_word));
  if (symmetry == "symmetric") header.symmetry = Symmetry::symmetric;
  else if (symmetry == "skew-symmetric") header.symmetry = Symmetry::skew_symmetric;
  else if (symmetry == "hermitian") lines.fail("Hermitian matrices are not supported");
  else if (symmetry != "general")
    lines.fail("the symmetry must be 'general', 'symmetric' or 'skew-symmetric', not " + in_quotes(symmetry_word));
  lines.end();
  if (header.field == Field::pattern && header.format == Header::Format::array)
    lines.fail("an 'array' cannot be a 'pattern'");
  if (header.field == Field::pattern && header.symmetry == Symmetry::skew_symmetric)
    lines.fail("a 'pattern' cannot be 'skew-symmetric'");
  return header;
}

int read_size(Lines& lines, std::string_view what) {
  const std::int64_t size = lines.integer(what);
  if (size < 0) lines.fail("the " + std::string(what) + " " + std::to_string(size) + " is negative");
  // Sizes that the length of the file cannot fill come from a damaged line; do not allocate for them.
  constexpr std::int64_t most = std::numeric_limits<int>::max();
  if (size > most)
    lines.fail("the " + std::string(what) + " " + std::to_string(size) + " is more than the " + std::to_string(most) +
               " supported");
  if (size > 1024 && static_cast<std::uint64_t>(size) / 64 > lines.size())
    lines.fail("the " + std::string(what) + " " + std::to_string(size) + " is more than a file of " +
               std::to_string(lines.size()) + " bytes can fill");
  return static_cast<int>(size);
}

}  // namespace

Header read_header(Lines& lines) {
  Header header = read_banner(lines);
  if (!lines.next()) lines.fail_file("the size line is missing");
  header.rows = read_size(lines, "number of rows");
  header.columns = read_size(lines, "number of columns");
  const std::int64_t rows = header.rows, columns = header.columns;
  if (header.symmetry != Symmetry::general && rows != columns)
    lines.fail("a symmetric matrix must be square, not " + std::to_string(rows) + " x " + std::to_string(columns));
  if (header.format == Header::Format::coordinate) {
    header.entries = lines.integer("number of entries");
    if (header.entries < 0) lines.fail("the number of entries " + std::to_string(header.entries) + " is negative");
  } else {
    header.entries = header.symmetry == Symmetry::general     ? rows * columns
                     : header.symmetry == Symmetry::symmetric ? rows * (rows + 1) / 2
                                                              : rows * (rows - 1) / 2;
  }
  lines.end();
  return header;
}

Place read_place(Lines& lines, const Header& header) {
  const std::int64_t i = lines.integer("row"), j = lines.integer("column");
  if (i < 1 || i > header.rows)
    lines.fail("row " + std::to_string(i) + " lies outside of 1 .. " + std::to_string(header.rows));
  if (j < 1 || j > header.columns)
    lines.fail("column " + std::to_string(j) + " lies outside of 1 .. " + std::to_string(header.columns));
  if (header.symmetry == Symmetry::symmetric && j > i)
    lines.fail("entry (" + std::to_string(i) + ", " + std::to_string(j) +
               ") lies above the diagonal: a symmetric file stores the lower triangle");
  if (header.symmetry == Symmetry::skew_symmetric && j >= i)
    lines.fail("entry (" + std::to_string(i) + ", " + std::to_string(j) +
               ") is not below the diagonal: a skew-symmetric file stores the lower triangle without diagonal");
  return {static_cast<int>(i - 1), static_cast<int>(j - 1)};
}

double read_value(Lines& lines, const Header& header) {
  if (header.field != Field::integer) return lines.number("value");
  const std::int64_t value = lines.integer("value");
  if (value > largest_integer || value < -largest_integer)
    lines.fail("the value " + std::to_string(value) + " lies beyond 2^53, where a double does not hold every integer");
  return static_cast<double>(value);
}

void too_few(const Lines& lines, const Header& header, std::int64_t got) {
  lines.fail_file("the file ends after " + std::to_string(got) + " of " + std::to_string(header.entries) + " entries");
}

void check_end(Lines& lines) {
  if (lines.next()) lines.fail("a line follows the last entry: there are more than the size line says");
}

}  // namespace graphsolve::io
