#include <gtest/gtest.h>

#include <string>

#include "physics/scene_io.hpp"
#include "physics/simulator.hpp"
#include "support/certificate.hpp"

namespace test_jammed_chain {

/// A foot of 3 g slides under a tumbling chain of 220 kg (campaign, seed 11, mass_ratio scene 162): as in Painleve's
/// paradox no force near the last one holds the step, however short it is. What does lies where the slip has stopped, and
/// steps of frozen friction bounds get there only if they grow.

using namespace physics;

TEST(JammedChain, TheStepIsFoundFarFromTheOneBefore) {
  const Trajectory jammed = read_scene(std::string(GRAPHSOLVE_SOURCE_DIR) + "/tests/data/scenes/jammed_chain.json");
  Simulator simulator(jammed.mechanism);
  simulator.restart_from(jammed.steps.back());
  StepRecord before, after;
  const StepResult result = simulator.step();
  ASSERT_TRUE(result.ok()) << result.cause << ' ' << simulator.failure_place();
  EXPECT_LE(result.residual, 1e-8);
  EXPECT_GE(simulator.smallest_distance(), -1e-12);
  EXPECT_LE(simulator.largest_joint_error(), 1e-10);
  for (int i = 0; i < 5; ++i) {
    simulator.write_record(before);
    ASSERT_TRUE(simulator.step().ok()) << simulator.failure_place();
    simulator.write_record(after);
    EXPECT_LE(certificate::certify_step(simulator.mechanism(), before, after).worst().value, 1e-6) << "step " << i;
  }
}

}  // namespace test_jammed_chain
