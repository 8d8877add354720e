#pragma once

namespace graphsolve {

/// largest = max(largest, value), where a NaN on either side stays: std::max would lose it, and with it every sign that
/// something went wrong.
inline void keep_largest(double& largest, double value) {
  if (value > largest || value != value) largest = value;
}

}  // namespace graphsolve
