#include "terms/pyramid_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace test_pyramid_law {

/// A stuck contact that creeps by 5e-9 m/s along t1. With psi = 0 both facets along t1 miss by 5e-9; the law, with psi made
/// from the slip, misses by 1e-8: the facet that pushes along the slip should let go at twice the slip.
TEST(PyramidLaw, NaturalErrorIsThatOfSlipAndImpulsesWhateverTheSlackPsi) {
  constexpr double mass = 2, creep = 5e-9, none = 1e-20;
  for (const double psi : {none, creep, 2 * creep}) {
    physics::PyramidLaw<4> law(0.5, mass, 1e300);
    physics::PyramidLaw<0> any(0.5, mass, 1e300, 4);
    const double u[] = {none, creep, 0};
    double f[3];
    const auto miss = [&](auto& l) {
      l.set_pair(0, none, 8 * mass);
      for (int i = 0; i < 4; ++i) l.set_pair(1 + i, none, 0.5 * mass);
      l.set_pair(5, psi, 2 * mass);
      l.residual(u, f);
      return l.natural_error(mass);
    };
    EXPECT_GE(miss(law), 0.999 * 2 * creep) << psi;
    EXPECT_EQ(miss(any), miss(law)) << psi;
  }
}

/// Whichever pair it is in: what is called solved has looked at all of them.
TEST(PyramidLaw, ANaNInAPairIsInItsErrorAndItsProduct) {
  constexpr double mass = 2, nan = std::numeric_limits<double>::quiet_NaN();
  const double u[] = {0.1, 0.2, 0.3};
  double f[3];
  for (int spoilt = 0; spoilt < 6; ++spoilt) {
    for (const bool slack : {false, true}) {
      physics::PyramidLaw<0> law(0.5, mass, 1e300, 4);
      for (int i = 0; i < 6; ++i) law.set_pair(i, i == spoilt && slack ? nan : 1, i == spoilt && !slack ? nan : 1);
      law.residual(u, f);
      EXPECT_TRUE(std::isnan(law.natural_error(mass))) << spoilt << (slack ? " s" : " z");
      EXPECT_TRUE(std::isnan(law.largest_product())) << spoilt << (slack ? " s" : " z");
    }
  }
}

}  // namespace test_pyramid_law
