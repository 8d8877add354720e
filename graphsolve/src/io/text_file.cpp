#include "graphsolve/io/text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "graphsolve/io/output_file.hpp"

namespace graphsolve::io {

namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

/// What comes through a pipe or from a device may never end.
constexpr std::size_t largest_stream = std::size_t(1) << 30;

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
  throw FileError(path, what + std::strerror(error));
}

}  // namespace

std::string read_text(const std::string& path, std::size_t longest_line) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw FileError(path, "cannot be read: it is a folder");
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, "cannot be read: ", errno);
  std::string text;
  const bool stream = !std::filesystem::is_regular_file(path, error);
  if (const auto size = std::filesystem::file_size(path, error); !error) text.reserve(size);
  char line_end = '\r';  // where there is no LF
  const auto fail_here = [&](std::size_t end, const std::string& what) {
    throw FileError(path, 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), line_end), what);
  };
  char buffer[1 << 16];
  while (const std::size_t got = std::fread(buffer, 1, sizeof buffer, file.get())) {
    text.append(buffer, got);
    if (std::memchr(buffer, '\n', got)) line_end = '\n';
    if (const std::size_t zero = text.find('\0', text.size() - got); zero != text.npos)
      fail_here(zero, "holds a zero byte: this is no text");
    if (text.size() > longest_line && text.find(line_end, text.size() - longest_line - 1) == text.npos)
      fail_here(text.size(), "the line is longer than " + std::to_string(longest_line) + " characters");
    if (stream && text.size() > largest_stream)
      throw FileError(path, "is no ordinary file and does not end within " + std::to_string(largest_stream) + " bytes");
  }
  if (std::ferror(file.get())) fail(path, "cannot be read: ", errno);
  return text;
}

void write_text(std::string_view text, const std::string& path) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace graphsolve::io
