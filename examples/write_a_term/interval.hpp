#pragma once

#include <algorithm>
#include <cmath>

#include "graphsolve/largest.hpp"
#include "graphsolve/pair.hpp"

/// A law with two pairs: 0 <= u <= width with the force f = z_0 - z_1 of the two ends,
///   s_0 = u >= 0  _|_  z_0 >= 0,     s_1 = width - u >= 0  _|_  z_1 >= 0.
/// Across a limiting (Zener) diode: the voltage stays in the interval, at its ends the current is free.
class Interval {
 public:
  static constexpr int rows = 1;
  explicit Interval(double width, double scale = 1) : width_(width), scale_(scale) {}

  [[nodiscard]] static int degree() { return 2; }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double force() const { return pair_[0].z - pair_[1].z; }

  void remember(double factor) {
    for (auto& p : pair_) p.remember(1, factor);
  }
  void restore() {
    for (auto& p : pair_) p.restore();
  }
  void start_warm(const double* u, double mu, double scale) {
    pair_[0].start_warm(u[0], mu, scale);
    pair_[1].start_warm(width_ - u[0], mu, scale);
  }
  void start_cold(double velocity, double scale) {
    for (auto& p : pair_) p.s = velocity, p.z = scale * velocity;
  }

  void residual(const double* u, double* f) {
    residual_[0] = u[0] - pair_[0].s;
    residual_[1] = width_ - u[0] - pair_[1].s;
    f[0] = force();
  }
  [[nodiscard]] double natural_error(double scale) const {
    double largest = 0;
    for (int e = 0; e < 2; ++e)
      for (const double error : {std::abs(residual_[e]), std::min(pair_[e].s, pair_[e].z / scale)})
        graphsolve::keep_largest(largest, error);  // not std::max: a NaN must stay
    return largest;
  }
  [[nodiscard]] double largest_product() const {
    const double a = pair_[0].s * pair_[0].z, b = pair_[1].s * pair_[1].z;
    return a > b ? a : b;
  }

  void condense(double largest_ratio, double* k) {
    for (int e = 0; e < 2; ++e) ratio_[e] = std::min(pair_[e].z / pair_[e].s, largest_ratio);
    k[0] = ratio_[0] + ratio_[1];
  }
  void right_hand_side(double mu, double correction, double* f0) {
    for (int e = 0; e < 2; ++e) {
      defect_[e] = pair_[e].defect(mu, correction);
      shift_[e] = residual_[e] + defect_[e] / pair_[e].z;
    }
    f0[0] = -ratio_[0] * shift_[0] + ratio_[1] * shift_[1];
  }
  void recover(const double* du) {
    for (int e = 0; e < 2; ++e) {
      Pair& p = pair_[e];
      p.dz = -ratio_[e] * ((e == 0 ? du[0] : -du[0]) + shift_[e]);
      p.ds = -(defect_[e] + p.s * p.dz) / p.z;
    }
  }
  [[nodiscard]] double boundary_ratio() const {
    return std::max(pair_[0].boundary_ratio(), pair_[1].boundary_ratio());
  }
  [[nodiscard]] double complementarity(double alpha) const { return pair_[0].product(alpha) + pair_[1].product(alpha); }
  void accept(double alpha) {
    for (auto& p : pair_) p.accept(alpha);
  }
  static double relax(double) { return 0; }  // monotone: nothing to freeze

 private:
  using Pair = graphsolve::Pair;
  double width_, scale_;
  Pair pair_[2];
  double residual_[2] = {}, ratio_[2] = {}, defect_[2] = {}, shift_[2] = {};
};
