#pragma once

#include <thread>
#include <vector>

namespace physics {

/// f(0) .. f(count - 1) at the same time, the first on the calling thread. f must not throw.
template <class F>
void parallel_for(int count, F&& f) {
  std::vector<std::jthread> threads;
  for (int i = 1; i < count; ++i) threads.emplace_back([&f, i] { f(i); });
  f(0);
}

}  // namespace physics
