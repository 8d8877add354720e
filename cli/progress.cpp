#include "progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace cli {

Progress::Progress(int steps, const char* unit) : steps_(steps), unit_(unit), terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_) fmt::print(stderr, "\r\x1b[K");  // leaves an empty line for the summary
}

void Progress::update(int done) {
  if (!terminal_ || steps_ <= 0) return;
  const auto now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  shown_ = true;
  constexpr int width = 40;
  const double part = static_cast<double>(done) / steps_;
  const double left = std::chrono::duration<double>(now - begin_).count() * (1 - part) / part;
  const int full = static_cast<int>(part * width);
  fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {} {} of {}, {:.0f} s left\x1b[K", "", full, "", width - full, unit_, done,
             steps_, left);
  std::fflush(stderr);
}

}  // namespace cli
