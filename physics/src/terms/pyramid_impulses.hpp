#pragma once

#include <algorithm>
#include <array>
#include <span>

namespace physics {

/// Facets of the four-sided pyramid in (t1, t2).
inline constexpr std::array<std::array<double, 2>, 4> cross_facets{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

/// The impulses of a contact with a friction pyramid as they are between steps: read, turned, scaled. Law supplies
///   double& z(int pair) const   0: normal gamma, 1 .. facets: beta, facets + 1: s_psi
///   int facets() const;  direction(int facet) const;  double friction() const;  double scale() const
template <class Law>
class PyramidImpulses {
 public:
  [[nodiscard]] double normal_impulse() const { return law().z(0); }
  [[nodiscard]] double facet_impulse(int i) const { return law().z(1 + i); }
  [[nodiscard]] double friction_bound() const { return law().friction() * law().z(0); }  ///< cf gamma
  void friction_impulse(double* t) const {
    t[0] = t[1] = 0;
    for (int i = 0; i < law().facets(); ++i) {
      t[0] += facet_impulse(i) * law().direction(i)[0];
      t[1] += facet_impulse(i) * law().direction(i)[1];
    }
  }

  /// Forgets the forces of earlier steps.
  void clear() { each([](double& z) { z = 0; }); }
  /// Impulses of a step of another length.
  void scale_impulses(double factor) {
    each([factor](double& z) { z *= factor; });
  }
  /// Takes up the impulses of an earlier step, facets in order.
  void set_impulses(double normal, std::span<const double> facet_impulses) {
    law().z(0) = normal;
    double sum = 0;
    for (int i = 0; i < law().facets(); ++i) sum += law().z(1 + i) = facet_impulses[i];
    law().z(law().facets() + 1) = std::max(law().friction() * normal - sum, 0.0);
  }
  /// After the tangents have turned: the same friction impulse, given in the new ones, on the nearest facets.
  void split_friction(const double* t) {
    const double least = 1e-9 * law().scale();
    double sum = 0;
    for (int i = 0; i < law().facets(); ++i) {
      const double along = t[0] * law().direction(i)[0] + t[1] * law().direction(i)[1];
      // The sum over facets of d d^T is facets / 2.
      sum += law().z(1 + i) = std::max(along * 4 / law().facets(), least);
    }
    law().z(law().facets() + 1) = std::max(friction_bound() - sum, least);
  }

 private:
  [[nodiscard]] const Law& law() const { return static_cast<const Law&>(*this); }
  template <class F>
  void each(F&& f) {
    for (int k = 0; k < law().facets() + 2; ++k) f(law().z(k));
  }
};

}  // namespace physics
