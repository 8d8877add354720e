#pragma once

#include <string>

namespace cli {

/// Keeps other runs of this program from writing the same file for as long as it lives; the system lets go of it when a run
/// is killed. The file is made if there is none. One that cannot be opened or locked is left to whoever writes it to speak
/// of. Throws physics::DescriptionError when another run holds it.
class FileLock {
 public:
  explicit FileLock(const std::string& path);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace cli
