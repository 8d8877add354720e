#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "graphsolve/pair.hpp"

namespace graphsolve {

/// The law 0 <= u _|_ f >= 0: an inequality u(x) >= 0 with its multiplier f.
class Nonnegative {
 public:
  static constexpr int rows = 1;

  /// scale: natural size of f over u, as the diagonal of the matrix; one that is far off costs iterations.
  /// largest_ratio bounds f/s in the matrix, so that a stiff pair does not erase what it is added to.
  /// Throws std::invalid_argument unless both are > 0 and the scale is finite.
  explicit Nonnegative(double scale = 1, double largest_ratio = 1e12) : scale_(scale), largest_ratio_(largest_ratio) {
    if (!(scale > 0 && std::isfinite(scale) && largest_ratio > 0))
      throw std::invalid_argument("nonnegative: scale " + std::to_string(scale) + " and largest ratio " +
                                  std::to_string(largest_ratio) + " are not both > 0 and the scale finite");
  }

  [[nodiscard]] static int degree() { return 1; }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double force() const { return pair_.z; }
  [[nodiscard]] double slack() const { return pair_.s; }
  void set_force(double force) { pair_.z = force; }

  void remember(double factor) { pair_.remember(1.0, factor); }
  void restore() { pair_.restore(); }
  void start_warm(const double* u, double mu, double scale) { pair_.start_warm(u[0], mu, scale); }
  void start_cold(double velocity, double scale) {
    pair_.s = velocity;
    pair_.z = scale * velocity;
  }
  void residual(const double* u, double* f) {
    residual_ = u[0] - pair_.s;
    f[0] = pair_.z;
  }
  [[nodiscard]] double natural_error(double scale) const {
    const double gap = std::min(pair_.s, pair_.z / scale), r = std::abs(residual_);
    return gap > r ? gap : r;
  }
  [[nodiscard]] double largest_product() const { return pair_.s * pair_.z; }
  void condense(double largest_ratio, double* k) {
    ratio_ = std::min({pair_.z / pair_.s, largest_ratio_, largest_ratio});
    k[0] = std::max(ratio_, smallest_ratio * scale_);
  }
  void right_hand_side(double mu, double correction, double* f0) {
    defect_ = pair_.defect(mu, correction);
    shift_ = residual_ + defect_ / pair_.z;
    f0[0] = -ratio_ * shift_;
  }
  void recover(const double* du) {
    pair_.dz = -ratio_ * (du[0] + shift_);
    pair_.ds = -(defect_ + pair_.s * pair_.dz) / pair_.z;
  }
  [[nodiscard]] double boundary_ratio() const { return pair_.boundary_ratio(); }
  [[nodiscard]] double complementarity(double alpha) const { return pair_.product(alpha); }
  void accept(double alpha) { pair_.accept(alpha); }
  static double relax(double) { return 0; }  // monotone: nothing to freeze

 private:
  /// Of f/s over the scale in the matrix. A limit that is far away would be all that a cost without curvature has on its
  /// diagonal; divided by so little, what the shift of constraints leaves undone would never fall below a tolerance.
  static constexpr double smallest_ratio = 1e-11;
  Pair pair_;
  double scale_, largest_ratio_;
  double residual_ = 0, ratio_ = 0, defect_ = 0, shift_ = 0;
};

}  // namespace graphsolve
