#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace graphsolve {

/// largest = max(largest, value), where a NaN on either side stays: std::max would lose it, and with it every sign that
/// something went wrong.
inline void keep_largest(double& largest, double value) {
  if (value > largest || value != value) largest = value;
}

/// Largest magnitude of many numbers, of which a NaN stays too: without their signs, numbers are ordered as their bits are,
/// and NaN lies above infinity. No branches.
class LargestMagnitude {
 public:
  explicit LargestMagnitude(double first = 0) { take(first); }
  void take(double value) { bits_ = std::max(bits_, std::bit_cast<std::uint64_t>(std::abs(value))); }
  void take(const LargestMagnitude& other) { bits_ = std::max(bits_, other.bits_); }
  [[nodiscard]] double value() const { return std::bit_cast<double>(bits_); }

 private:
  std::uint64_t bits_ = 0;
};

}  // namespace graphsolve
