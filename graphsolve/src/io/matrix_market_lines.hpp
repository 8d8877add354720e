#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "graphsolve/io/matrix_market.hpp"

namespace graphsolve::io {

/// 2^53: up to here every integer is a double.
constexpr std::int64_t largest_integer = std::int64_t{1} << 53;

/// The first line and the size line of a file.
struct Header {
  enum class Format { coordinate, array };
  Format format = Format::coordinate;
  Field field = Field::real;
  Symmetry symmetry = Symmetry::general;
  int rows = 0, columns = 0;
  std::int64_t entries = 0;  ///< lines that must follow
};

/// Walks the lines of a text, word by word, and knows where it is. Lines end in LF or CR LF; in a text without LF, in CR,
/// as those of old programs. A byte order mark of UTF-8 is passed over.
class Lines {
 public:
  Lines(std::string_view text, std::string_view name);

  /// Moves to the next line that has words and is no comment; false at the end.
  bool next();
  /// Moves to the very next line; false at the end.
  bool next_raw();
  /// The next word of the line, empty at its end.
  std::string_view word();
  /// The words must be numbers; `what` names them in errors.
  std::int64_t integer(std::string_view what);
  double number(std::string_view what);
  /// Nothing may follow on this line.
  void end();

  [[noreturn]] void fail(const std::string& what) const { throw FileError(name_, line_, what); }
  /// About the file as a whole.
  [[noreturn]] void fail_file(const std::string& what) const { throw FileError(name_, what); }
  [[nodiscard]] std::size_t size() const { return text_.size(); }

 private:
  std::string_view text_, name_, rest_;
  char line_end_;
  std::size_t at_ = 0;
  std::int64_t line_ = 0;
};

/// Reads up to and with the size line, and leaves the entries to the caller.
Header read_header(Lines& lines);

/// Calls entry(i, j, value) for every entry of the file, from 0, in the order of the file; nothing is mirrored.
template <class F>
void for_each_entry(Lines& lines, const Header& header, F&& entry);

/// Row and column of the next line of a coordinate file, from 0, checked.
struct Place {
  int row, column;
};
Place read_place(Lines& lines, const Header& header);
/// Fails when lines follow the last entry, or when the entries end too early.
void check_end(Lines& lines);
[[noreturn]] void too_few(const Lines& lines, const Header& header, std::int64_t got);
double read_value(Lines& lines, const Header& header);

template <class F>
void for_each_entry(Lines& lines, const Header& header, F&& entry) {
  if (header.format == Header::Format::coordinate) {
    for (std::int64_t k = 0; k < header.entries; ++k) {
      if (!lines.next()) too_few(lines, header, k);
      const Place at = read_place(lines, header);
      const double value = header.field == Field::pattern ? 1 : read_value(lines, header);
      lines.end();
      entry(at.row, at.column, value);
    }
  } else {
    std::int64_t k = 0;
    for (int j = 0; j < header.columns; ++j) {
      const int first = header.symmetry == Symmetry::general ? 0 : header.symmetry == Symmetry::symmetric ? j : j + 1;
      for (int i = first; i < header.rows; ++i, ++k) {
        if (!lines.next()) too_few(lines, header, k);
        const double value = read_value(lines, header);
        lines.end();
        entry(i, j, value);
      }
    }
  }
  check_end(lines);
}

}  // namespace graphsolve::io
