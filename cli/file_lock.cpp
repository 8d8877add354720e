#include "file_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

#include "physics/mechanism.hpp"

namespace cli {

FileLock::FileLock(const std::string& path) : file_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (file_ < 0 || flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(file_);
  throw physics::DescriptionError(
      fmt::format("{}: another rollout is writing this file; wait for it, or give --out another name", path));
}

FileLock::~FileLock() {
  if (file_ >= 0) close(file_);
}

}  // namespace cli
