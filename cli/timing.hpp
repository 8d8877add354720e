#pragma once

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <vector>

/// How long things take, for programs: CPU time of this thread, so that waiting for a shared core does not count.
namespace timing {

/// [s]
inline double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Of at least one value; of an even number the upper one of the middle.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What a pair of calls of thread_time() finds between them: time of the clock itself, a third of a microsecond where it is a
/// system call. Where single steps of a few microseconds are timed it is taken off.
inline double clock_time(int count = 1001) {
  std::vector<double> pairs;
  for (int i = 0; i < count; ++i) {
    const double begin = thread_time();
    pairs.push_back(thread_time() - begin);
  }
  return median(std::move(pairs));
}

}  // namespace timing
