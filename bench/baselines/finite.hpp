#pragma once

#include <cmath>
#include <span>

#include "baselines/baselines.hpp"

namespace baselines {

/// What a solve ends with: no package here says by itself that its result holds no numbers.
inline Status judged(std::span<const double> x) {
  double sum = 0;
  for (const double value : x) sum += value * 0;  // 0, or NaN
  return sum == 0 ? Status{} : Status{false, "result is not finite"};
}

}  // namespace baselines
