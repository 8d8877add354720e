#pragma once

#include <chrono>

/// A bar on stderr for runs longer than a second, when somebody sits in front of it.
namespace cli {

class Progress {
 public:
  explicit Progress(int steps, const char* unit = "step");
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(int done);

 private:
  using Clock = std::chrono::steady_clock;
  int steps_;
  const char* unit_;
  bool terminal_, shown_ = false;
  Clock::time_point begin_ = Clock::now(), next_ = begin_ + std::chrono::seconds(1);
};

}  // namespace cli
