#include <gtest/gtest.h>

#include <cmath>

#include "physics/simulator.hpp"
#include "thrown_rod.hpp"

namespace test_culling {

// Contacts that seemed out of reach before a step and were not.

using namespace physics;

/// A ledge under the other end, so high that the step ends this far below it when the ledge is not felt.
Mechanism with_ledge(double depth) {
  Mechanism scene = thrown_rod();
  Simulator without(scene);
  EXPECT_TRUE(without.step().ok());
  StepRecord record;
  without.write_record(record);
  Contact high = scene.contacts[0];
  high.name = "high";
  high.point = {0, 0, 0.5};
  high.plane_point = record.bodies[0].position + record.bodies[0].orientation * high.point;
  high.plane_point.z() += depth;
  scene.add(high);
  return scene;
}

TEST(Culling, AContactBrokenThroughByNanometresIsPutBack) {
  for (const double depth : {1e-9, 1e-8, 1e-6, 1e-3}) {
    SCOPED_TRACE(depth);
    Simulator simulator(with_ledge(depth));
    const StepResult result = simulator.step();
    ASSERT_TRUE(result.ok());
    EXPECT_EQ(result.culling_repeats, 1) << "it was not left out, or not put back";
    EXPECT_GE(simulator.smallest_distance(), -1e-10);
  }
}

TEST(Culling, AContactThatIsNotReachedStaysOut) {
  Simulator simulator(with_ledge(-1e-8));
  const StepResult result = simulator.step();
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result.culling_repeats, 0);
  EXPECT_NEAR(simulator.smallest_distance(), 0, 1e-7);
}

}  // namespace test_culling
