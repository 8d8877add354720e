#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace graphsolve::io {

/// A file that appears complete or not at all: written under a name of its own in the same folder, and renamed by `commit`.
/// Links are followed. What is not an ordinary file (a pipe, a terminal) is written directly.
class OutputFile {
 public:
  /// Throws what the caller's callers expect of a file that cannot be written.
  using Refuse = void (*)(const std::string& path, std::string_view reason);

  /// refuse: called where opening, writing or closing fails, and throws; by default FileError.
  explicit OutputFile(const std::string& path, Refuse refuse = throw_file_error);
  /// Without `commit`: removes what was written so far.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

  /// After `write` or `commit` has thrown: bytes that got into the file, which is closed by that; 0 where it is no
  /// ordinary one.
  [[nodiscard]] std::int64_t bytes_there();
  /// Then: goes on behind the first of them.
  void go_on_behind(std::int64_t bytes);

 private:
  static void throw_file_error(const std::string& path, std::string_view reason);
  void fail() const;

  std::string path_;     ///< as given, for messages
  std::string target_;   ///< with symbolic links followed
  std::string partial_;  ///< empty: written directly
  Refuse refuse_;
  std::FILE* file_ = nullptr;
};

}  // namespace graphsolve::io
