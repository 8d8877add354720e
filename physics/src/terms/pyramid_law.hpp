#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <type_traits>
#include <vector>

#include "graphsolve/largest.hpp"
#include "graphsolve/pair.hpp"
#include "terms/pyramid_impulses.hpp"

namespace physics {

/// Bound on the stiffness z/s of a contact pair in the matrix [kg]: rounding, 2e-16 of it, may erase a thousandth
/// of the smallest inertia that a body shows at an arm from its centre, 1 / (1/m + arm^2/J_min). (Lower bounds only
/// slow down the last iterations, which gain a factor of it over the mass that is pressed on.)
inline double largest_stiffness(double mass, double smallest_inertia, double arm) {
  return 1e12 / (1 / mass + arm * arm / smallest_inertia);
}

/// One step of the relaxation of a friction bound: frozen at what it is, moved by `damping`, or set free by 0. Returns
/// the change relative to the scale. Flag is bool or a number that is 0 or 1.
template <class Flag>
double relax_bound(double bound, double scale, double damping, Flag& frozen, double& frozen_bound) {
  if (damping == 0) {
    frozen = 0;
    return 0;
  }
  if (!(frozen != 0)) frozen_bound = bound;
  frozen = 1;
  const double change = std::abs(bound - frozen_bound) / scale;
  frozen_bound = std::max(0.0, frozen_bound + damping * (bound - frozen_bound));  // damping > 1 leads beyond `bound`
  return change;
}

/// Contact with pyramidal Coulomb friction (eq. 15, 20 with slacks, 26c-i), rows n, t1, t2.
/// Pairs (velocity s, impulse z): (s_g, gamma), (eta_i, beta_i) for each facet, (psi, s_psi).
///   r0 = u_n - s_g,   r_i = d_i . u_t + psi - eta_i,   r5 = cf gamma - sum beta - s_psi
/// Facets d_i = (cos, sin)(2 pi i / Facets) in (t1, t2). Facets = 0: the number is given at run time.
/// Condensed as in docs/algorithm.md: with w = z/s of each pair, q = s_psi/psi, S = q + sum w_i,
///   K_nn = w_0,  K_tn = cf w_0 sum w_i d_i / S,
///   K_tt = (q sum w_i d_i d_i^T + sum_{i<j} w_i w_j (d_i - d_j)(d_i - d_j)^T) / S,
/// forms that do not cancel.
template <int Facets>
class PyramidLaw : public PyramidImpulses<PyramidLaw<Facets>> {
 public:
  static constexpr int rows = 3;

  /// island_mass: largest mass of what hangs together [kg]; stiffness: bound on z/s in the matrix [kg].
  PyramidLaw(double friction, double island_mass, double stiffness, int facets = Facets)
      : friction_(friction), scale_(island_mass), largest_ratio_(stiffness) {
    if constexpr (Facets == 0) {
      facet_.resize(facets);
      direction_.resize(facets);
      for (auto* v : {&ratio_, &residual_, &shift_, &defect_}) v->resize(facets);
    }
    for (int i = 0; i < facets; ++i) {
      const double angle = 2 * std::numbers::pi * i / facets;
      direction_[i] = {std::cos(angle), std::sin(angle)};
    }
  }

  [[nodiscard]] int facets() const { return static_cast<int>(facet_.size()); }
  [[nodiscard]] int degree() const { return facets() + 2; }
  [[nodiscard]] double scale() const { return scale_; }
  [[nodiscard]] double friction() const { return friction_; }
  [[nodiscard]] double& z(int pair) const {
    auto& self = const_cast<PyramidLaw&>(*this);  // PyramidImpulses hands it out as const only to readers
    return pair == 0 ? self.normal_.z : pair <= facets() ? self.facet_[pair - 1].z : self.bound_.z;
  }
  [[nodiscard]] const std::array<double, 2>& direction(int i) const {
    if constexpr (Facets == 4) return cross_facets[i];
    else return direction_[i];
  }
  /// Other numbers; forgets all impulses.
  void describe(double friction, double island_mass, double stiffness, int facets) {
    *this = PyramidLaw(friction, island_mass, stiffness, facets);
  }
  /// Pairs as PyramidImpulses numbers them.
  void set_pair(int pair, double s, double z) {
    graphsolve::Pair& p = pair == 0 ? normal_ : pair <= facets() ? facet_[pair - 1] : bound_;
    p.s = s;
    p.z = z;
  }

  void remember(double factor) {
    normal_.remember(1, factor);
    bound_.remember(1, factor);
    for (auto& f : facet_) f.remember(1, factor);
  }
  void restore() {
    normal_.restore();
    bound_.restore();
    for (auto& f : facet_) f.restore();
  }
  void start_warm(const double* u, double mu, double m) {
    double psi = 0;
    for (int i = 0; i < facets(); ++i) psi = std::max(psi, -slip(i, u));
    normal_.start_warm(u[0], mu, m);
    for (int i = 0; i < facets(); ++i) facet_[i].start_warm(slip(i, u) + psi, mu, m);
    bound_.start_warm(psi, mu, m);
  }
  void start_cold(double velocity, double m) {
    const auto start = [&](graphsolve::Pair& p) {
      p.s = velocity;
      p.z = m * velocity;
    };
    start(normal_);
    start(bound_);
    for (auto& f : facet_) start(f);
  }

  void residual(const double* u, double* f) {
    normal_residual_ = u[0] - normal_.s;
    double sum = 0;
    f[0] = normal_.z;
    f[1] = f[2] = 0;
    for (int i = 0; i < facets(); ++i) {
      const double z = facet_[i].z;
      residual_[i] = slip(i, u) + bound_.s - facet_[i].s;
      f[1] += z * direction(i)[0];
      f[2] += z * direction(i)[1];
      sum += z;
    }
    bound_residual_ = (frozen_ ? frozen_bound_ : friction_ * normal_.z) - sum - bound_.z;
  }
  /// Residuals, and of each pair the smaller side as u and the impulses alone make it: gap u_n, psi = max(0, -min
  /// d_i.u), eta_i = d_i.u + psi. (The slack psi can be off by a residual of one facet and so hide half of another's
  /// slip.)
  [[nodiscard]] double natural_error(double m) const {
    const double gap = std::abs(normal_residual_), bound = std::abs(bound_residual_) / m;
    double largest = gap, psi = 0;
    const auto take = [&](double e) {
      graphsolve::keep_largest(largest, e);
    };
    const auto slip = [&](int i) { return facet_[i].s + residual_[i] - bound_.s; };
    for (int i = 0; i < facets(); ++i) psi = std::max(psi, -slip(i));
    take(bound);
    take(std::min(normal_.s + gap, normal_.z / m));
    take(std::min(psi, bound_.z / m + bound));
    for (int i = 0; i < facets(); ++i) {
      take(std::abs(residual_[i]));
      take(std::min(slip(i) + psi, facet_[i].z / m));
    }
    return largest;
  }
  [[nodiscard]] double largest_product() const {
    double largest = normal_.s * normal_.z;
    graphsolve::keep_largest(largest, bound_.s * bound_.z);
    for (const auto& f : facet_) graphsolve::keep_largest(largest, f.s * f.z);
    return largest;
  }

  void condense(double largest_ratio, double* k) {
    const double cap = std::min(largest_ratio, largest_ratio_);
    const auto capped = [cap](const graphsolve::Pair& p) { return std::min(p.z / p.s, cap); };
    normal_ratio_ = capped(normal_);
    bound_ratio_ = capped(bound_);
    double sum = bound_ratio_, along[2] = {0, 0};
    for (int i = 0; i < facets(); ++i) {
      const double w = capped(facet_[i]);
      ratio_[i] = w;
      sum += w;
      along[0] += w * direction(i)[0];
      along[1] += w * direction(i)[1];
    }
    one_over_sum_ = 1 / sum;
    const double coupling = (frozen_ ? 0 : friction_) * normal_ratio_ * one_over_sum_;
    double k11, k12, k22;
    tangential(k11, k12, k22);
    k[0] = normal_ratio_;
    k[1] = coupling * along[0];
    k[2] = coupling * along[1];
    k[3] = 0;
    k[4] = k11;
    k[5] = k12;
    k[6] = 0;
    k[7] = k12;
    k[8] = k22;
  }

  /// Of the friction impulse (rows t1, t2) by the coefficient, u held: gamma sum w_i d_i / S. After condense.
  void friction_derivative(double* df) const {
    df[0] = df[1] = 0;
    for (int i = 0; i < facets(); ++i) {
      df[0] += ratio_[i] * direction(i)[0];
      df[1] += ratio_[i] * direction(i)[1];
    }
    df[0] *= normal_.z * one_over_sum_;
    df[1] *= normal_.z * one_over_sum_;
  }

  void right_hand_side(double mu, double correction, double* f0) {
    normal_defect_ = normal_.defect(mu, correction);
    bound_defect_ = bound_.defect(mu, correction);
    normal_shift_ = normal_residual_ + normal_defect_ / normal_.z;
    double sum =
        -(bound_residual_ + bound_defect_ / bound_.s) + (frozen_ ? 0 : friction_) * normal_ratio_ * normal_shift_;
    for (int i = 0; i < facets(); ++i) {
      defect_[i] = facet_[i].defect(mu, correction);
      shift_[i] = residual_[i] + defect_[i] / facet_[i].z;
      sum -= ratio_[i] * shift_[i];
    }
    psi_shift_ = sum * one_over_sum_;
    f0[0] = -normal_ratio_ * normal_shift_;
    f0[1] = f0[2] = 0;
    for (int i = 0; i < facets(); ++i) {
      const double f = ratio_[i] * (shift_[i] + psi_shift_);
      f0[1] -= f * direction(i)[0];
      f0[2] -= f * direction(i)[1];
    }
  }
  void recover(const double* du) {
    double psi = (frozen_ ? 0 : friction_) * normal_ratio_ * du[0];
    for (int i = 0; i < facets(); ++i) psi -= ratio_[i] * slip(i, du);
    psi = psi_shift_ + psi * one_over_sum_;
    normal_.dz = -normal_ratio_ * (du[0] + normal_shift_);
    normal_.ds = -(normal_defect_ + normal_.s * normal_.dz) / normal_.z;
    // As in the other pairs: the impulse from the condensed system, the velocity from the product. The other way round
    // a bounded ratio would turn rounding errors of psi into large impulses.
    bound_.dz = -bound_defect_ / bound_.s - bound_ratio_ * psi;
    bound_.ds = -(bound_defect_ + bound_.s * bound_.dz) / bound_.z;
    for (int i = 0; i < facets(); ++i) {
      auto& f = facet_[i];
      f.dz = -ratio_[i] * (slip(i, du) + psi + shift_[i]);
      f.ds = -(defect_[i] + f.s * f.dz) / f.z;
    }
  }
  [[nodiscard]] double boundary_ratio() const {
    double largest = std::max(normal_.boundary_ratio(), bound_.boundary_ratio());
    for (const auto& f : facet_) {
      graphsolve::keep_largest(largest, f.boundary_ratio());
    }
    return largest;
  }
  [[nodiscard]] double complementarity(double alpha) const {
    double sum = normal_.product(alpha) + bound_.product(alpha);
    for (const auto& f : facet_) sum += f.product(alpha);
    return sum;
  }
  void accept(double alpha) {
    normal_.accept(alpha);
    bound_.accept(alpha);
    for (auto& f : facet_) f.accept(alpha);
  }
  /// The friction bound cf gamma is what makes the problem non-monotone: frozen, it is a convex one.
  double relax(double damping) {
    return relax_bound(this->friction_bound(), scale_, damping, frozen_, frozen_bound_);
  }

 private:
  template <class T>
  using Array = std::conditional_t<Facets == 0, std::vector<T>, std::array<T, (Facets > 0 ? Facets : 1)>>;

  [[nodiscard]] double slip(int i, const double* u) const { return direction(i)[0] * u[1] + direction(i)[1] * u[2]; }

  /// K_tt. For the axis-aligned cross the pairwise sum is short.
  void tangential(double& k11, double& k12, double& k22) const {
    const double q = bound_ratio_;
    if constexpr (Facets == 4) {
      const double w1 = ratio_[0], w2 = ratio_[2], w3 = ratio_[1], w4 = ratio_[3];
      const double p1 = w1 + w2, p2 = w3 + w4;
      k11 = (p1 * (q + p2) + 4 * w1 * w2) * one_over_sum_;
      k12 = -(w1 - w2) * (w3 - w4) * one_over_sum_;
      k22 = (p2 * (q + p1) + 4 * w3 * w4) * one_over_sum_;
    } else {
      k11 = k12 = k22 = 0;
      for (int i = 0; i < facets(); ++i) {
        const auto& a = direction_[i];
        k11 += q * ratio_[i] * a[0] * a[0];
        k12 += q * ratio_[i] * a[0] * a[1];
        k22 += q * ratio_[i] * a[1] * a[1];
        for (int j = 0; j < i; ++j) {
          const double x = a[0] - direction_[j][0], y = a[1] - direction_[j][1], w = ratio_[i] * ratio_[j];
          k11 += w * x * x;
          k12 += w * x * y;
          k22 += w * y * y;
        }
      }
      k11 *= one_over_sum_;
      k12 *= one_over_sum_;
      k22 *= one_over_sum_;
    }
  }

  graphsolve::Pair normal_, bound_;
  Array<graphsolve::Pair> facet_;
  Array<double> ratio_, residual_, shift_, defect_;
  Array<std::array<double, 2>> direction_;
  double friction_, scale_, largest_ratio_;
  double normal_residual_ = 0, bound_residual_ = 0, normal_ratio_ = 0, bound_ratio_ = 0, one_over_sum_ = 0;
  double normal_defect_ = 0, bound_defect_ = 0, normal_shift_ = 0, psi_shift_ = 0;
  double frozen_bound_ = 0;
  bool frozen_ = false;
};

}  // namespace physics
