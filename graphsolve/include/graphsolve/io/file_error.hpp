#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace graphsolve::io {

/// A file that cannot be read or written, or that holds something wrong. What it says is one sentence that names
/// the file, the line (when there is one) and the value: "a.mtx:17: row 9 lies outside of 1 .. 8".
class FileError : public std::runtime_error {
 public:
  FileError(std::string_view file, std::int64_t line, std::string_view what)
      : std::runtime_error(std::string(file) + (line > 0 ? ":" + std::to_string(line) : "") + ": " +
                           std::string(what)),
        line_(line) {}
  FileError(std::string_view file, std::string_view what) : FileError(file, 0, what) {}
  [[nodiscard]] std::int64_t line() const { return line_; }  ///< from 1; 0: the file as a whole

 private:
  std::int64_t line_;
};

}  // namespace graphsolve::io
