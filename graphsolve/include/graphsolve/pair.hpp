#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace graphsolve {

/// One complementarity pair 0 <= s _|_ z >= 0 with its Newton step; laws are made of these.
///   s z = mu  is linearised as  s dz + z ds = -(s z - mu + correction).
struct Pair {
  double s = 0, z = 0;
  double ds = 0, dz = 0;
  double remembered_s = 0, remembered_z = 0;

  void remember(double s_factor, double z_factor) {
    remembered_s = s * s_factor;
    remembered_z = z * z_factor;
  }
  void restore() {
    s = remembered_s;
    z = remembered_z;
  }
  /// The point on s z = mu with s - z/m = predicted - remembered_z/m; the smaller one from mu over the other.
  void start_warm(double predicted, double mu, double m) {
    const double d = predicted - remembered_z / m;
    const double root = std::sqrt(d * d + 4 * mu / m);
    if (d >= 0) {
      s = 0.5 * (d + root);
      z = mu / s;
    } else {
      z = 0.5 * m * (root - d);
      s = mu / z;
    }
  }
  /// Without a correction the last step does not count, not even when it was no number.
  [[nodiscard]] double defect(double mu, double correction) const {
    return s * z - mu + (correction != 0 ? correction * ds * dz : 0);
  }
  [[nodiscard]] double boundary_ratio() const { return std::max(-dz / z, -ds / s); }
  [[nodiscard]] double product(double alpha) const { return (s + alpha * ds) * (z + alpha * dz); }
  void accept(double alpha) {
    s = moved(s, alpha * ds);
    z = moved(z, alpha * dz);
  }
  /// Stays positive: a step to the boundary, or back (alpha < 0) from a value that had grown by 1e16, leaves of a small one
  /// nothing but the rounding of the move, which may be 0 or less. A NaN stays one.
  [[nodiscard]] static double moved(double value, double by) {
    return std::max(value + by, std::numeric_limits<double>::epsilon() * std::abs(by));
  }
};

}  // namespace graphsolve
