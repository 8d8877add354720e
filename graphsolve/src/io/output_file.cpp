#include "graphsolve/io/output_file.hpp"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "graphsolve/io/file_error.hpp"

namespace graphsolve::io {

namespace fs = std::filesystem;

namespace {

/// Unlike that of any other writer, in this process or another.
std::string partial_name(const std::string& target) {
  static std::atomic<int> count{0};
  return target + "." + std::to_string(::getpid()) + "-" + std::to_string(count++) + ".part";
}

}  // namespace

OutputFile::OutputFile(const std::string& path, Refuse refuse) : path_(path), target_(path), refuse_(refuse) {
  std::error_code error;
  if (path.empty() || path.ends_with('/')) refuse_(path, "No file name");
  // /dev/stdout may lead to an ordinary file that belongs to somebody else.
  const bool device = path.starts_with("/dev/");
  if (!device && fs::is_symlink(path, error)) target_ = fs::weakly_canonical(path, error).string();
  const fs::file_status status = fs::status(target_, error);
  if (fs::is_directory(status)) refuse_(path, "Is a directory");
  if (fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail();
  const fs::path folder = fs::path(target_).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error)) refuse_(path, "No such directory");
  if (device || (fs::exists(status) && !fs::is_regular_file(status))) {
    file_ = std::fopen(target_.c_str(), "ab");
  } else {
    partial_ = partial_name(target_);
    file_ = std::fopen(partial_.c_str(), "wbx");
  }
  if (!file_) fail();
}

OutputFile::~OutputFile() {
  if (file_) std::fclose(file_);
  std::error_code error;
  if (!partial_.empty()) fs::remove(partial_, error);
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
}

void OutputFile::commit() {
  // Closing writes out what is still held back, so a full disk may show only here.
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail();
  if (partial_.empty()) return;
  std::error_code error;
  fs::rename(partial_, target_, error);
  if (error) refuse_(path_, error.message());
  partial_.clear();
}

std::int64_t OutputFile::bytes_there() {
  if (file_) std::fclose(std::exchange(file_, nullptr));
  std::error_code error;
  const std::uintmax_t bytes = partial_.empty() ? 0 : fs::file_size(partial_, error);
  return error ? 0 : static_cast<std::int64_t>(bytes);
}

void OutputFile::go_on_behind(std::int64_t bytes) {
  std::error_code error;
  fs::resize_file(partial_, static_cast<std::uintmax_t>(bytes), error);
  if (error) refuse_(path_, error.message());
  file_ = std::fopen(partial_.c_str(), "ab");
  if (!file_) fail();
}

void OutputFile::fail() const { refuse_(path_, std::strerror(errno)); }

void OutputFile::throw_file_error(const std::string& path, std::string_view reason) {
  throw FileError(path, "cannot be written: " + std::string(reason));
}

}  // namespace graphsolve::io
