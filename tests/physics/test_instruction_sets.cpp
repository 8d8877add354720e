#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "graphsolve/simd/lane_blocks.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_instruction_sets {

/// One step by each instruction set that this machine has, from the same states.

using namespace physics;

double largest_difference(const std::vector<BodyRecord>& a, const std::vector<BodyRecord>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Quat turn = a[i].orientation.conjugate() * b[i].orientation;
    largest = std::max({largest, (a[i].position - b[i].position).lpNorm<Eigen::Infinity>(),
                        2 * turn.vec().lpNorm<Eigen::Infinity>(), (a[i].velocity - b[i].velocity).lpNorm<Eigen::Infinity>(),
                        (a[i].angular_velocity - b[i].angular_velocity).lpNorm<Eigen::Infinity>()});
  }
  return largest;
}

std::vector<BodyRecord> next(const Mechanism& scene, const StepRecord& from) {
  Simulator simulator(scene);
  simulator.restart_from(from);
  EXPECT_TRUE(simulator.step().ok());
  StepRecord record;
  simulator.write_record(record);
  return record.bodies;
}

TEST(InstructionSets, AgreeOverOneStepToANanometre) {
  const auto best = graphsolve::simd::instruction_set();
  for (const char* spec : {"quadruped", "hopper", "snake:n=20", "pendulum:n=30", "four_bar", "disc:c=10", "tumbling_box"}) {
    const Mechanism scene = built_in_scene(spec);
    Simulator simulator(scene);
    for (int step = 1; step <= 60; ++step) {
      ASSERT_TRUE(simulator.step().ok()) << spec << ", step " << step;
      if (step % 12 != 0) continue;
      StepRecord record;
      simulator.write_record(record);
      const auto expected = next(scene, record);
      for (const auto set : graphsolve::simd::instruction_sets()) {
        graphsolve::simd::use_instruction_set(set);
        EXPECT_LE(largest_difference(expected, next(scene, record)), 1e-9) << spec << ", after step " << step << ", " << name(set);
      }
      graphsolve::simd::use_instruction_set(best);
    }
  }
}

}  // namespace test_instruction_sets
