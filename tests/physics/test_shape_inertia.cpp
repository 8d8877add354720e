#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/mechanism.hpp"

namespace test_shape_inertia {

using namespace physics;

TEST(ShapeInertia, MatchesTheTextbook) {
  using enum Shape::Type;
  EXPECT_TRUE(shape_inertia({.type = sphere, .radius = 2, .file = ""}, 5).isApprox(8 * Mat3::Identity()));
  EXPECT_TRUE(
      shape_inertia({.type = box, .size = Vec3(1, 2, 3), .file = ""}, 12).isApprox(Mat3(Vec3(13, 10, 5).asDiagonal())));
  EXPECT_TRUE(shape_inertia({.type = cylinder, .radius = 0.5, .height = 0.1, .file = ""}, 1)
                  .isApprox(Mat3(Vec3(0.19 / 3, 0.19 / 3, 0.125).asDiagonal())));
  EXPECT_EQ(shape_inertia({.type = mesh, .file = "a.obj"}, 1), Mat3::Zero());
}

TEST(ShapeInertia, OfACapsuleMatchesASumOverSlices) {
  const double r = 0.3, h = 0.8;
  const int slices = 20000;
  double volume = 0, side = 0, axial = 0;
  for (int i = 0; i < slices; ++i) {
    const double dz = (h + 2 * r) / slices, z = -h / 2 - r + (i + 0.5) * dz;
    const double outside = std::max(0.0, std::abs(z) - h / 2), area_radius2 = r * r - outside * outside;
    volume += area_radius2 * dz;
    axial += 0.5 * area_radius2 * area_radius2 * dz;
    side += area_radius2 * (0.25 * area_radius2 + z * z) * dz;
  }
  const Mat3 inertia = shape_inertia({.type = Shape::Type::capsule, .radius = r, .height = h, .file = ""}, 3);
  EXPECT_NEAR(inertia(0, 0), 3 * side / volume, 1e-7);
  EXPECT_NEAR(inertia(1, 1), 3 * side / volume, 1e-7);
  EXPECT_NEAR(inertia(2, 2), 3 * axial / volume, 1e-7);
}

}  // namespace test_shape_inertia
