#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "graphsolve/io/matrix_market.hpp"

namespace graphsolve::io {

namespace {

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
  throw FileError(path, what + std::strerror(error));
}

}  // namespace

std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw FileError(path, "cannot be read: it is a folder");
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, "cannot be read: ", errno);
  std::string text;
  if (const auto size = std::filesystem::file_size(path, error); !error) text.reserve(size);
  char buffer[1 << 16];
  while (const std::size_t got = std::fread(buffer, 1, sizeof buffer, file.get())) text.append(buffer, got);
  if (std::ferror(file.get())) fail(path, "cannot be read: ", errno);
  return text;
}

void write_text(std::string_view text, const std::string& path) {
  std::error_code error;
  const bool special = std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error);
  const std::string target = special ? path : path + ".part";  // /dev/stdout is not renamed to
  File file(std::fopen(target.c_str(), "wb"));
  if (!file) fail(path, "cannot be written: ", errno);
  const bool written = std::fwrite(text.data(), 1, text.size(), file.get()) == text.size();
  const bool closed = std::fclose(file.release()) == 0;
  const int reason = errno;
  if (!written || !closed) {
    if (!special) std::filesystem::remove(target, error);
    fail(path, "cannot be written: ", reason);
  }
  if (special) return;
  std::filesystem::rename(target, path, error);
  if (!error) return;
  const std::string why = error.message();
  std::filesystem::remove(target, error);
  throw FileError(path, "cannot be written: " + why);
}

}  // namespace graphsolve::io
