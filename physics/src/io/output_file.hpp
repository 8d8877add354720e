#pragma once

#include <cstdio>
#include <string>
#include <string_view>

/// A file that appears complete or not at all.
namespace physics::io {

/// Written under another name in the same folder and renamed by `commit`. What is not an ordinary file (a pipe,
/// a terminal) is written directly. Every failure throws DescriptionError "cannot write 'path': reason".
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  /// Without `commit`: removes what was written so far.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

 private:
  [[noreturn]] void fail();

  std::string path_;     ///< as given, for messages
  std::string target_;   ///< with symbolic links followed
  std::string partial_;  ///< empty: written directly
  std::FILE* file_ = nullptr;
};

}  // namespace physics::io
