#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "rubbing_scenes.hpp"
#include "support/certificate.hpp"

namespace test_rubbing {

// Steps that only fail at first: what they need is looked for where the step before found it.

using namespace physics;

struct Count {
  long long steps = 0, iterations = 0;
  int most = 0, turned = 0;
};

void run(const Mechanism& scene, int steps, Count& count) {
  Simulator simulator(scene);
  StepRecord before, after;
  simulator.write_record(before);
  for (int step = 1; step <= steps; ++step) {
    const StepResult result = simulator.step();
    ASSERT_TRUE(result.ok()) << scene.name << " step " << step << ": " << simulator.failure_place();
    ++count.steps;
    count.iterations += result.iterations;
    count.most = std::max(count.most, result.iterations);
    count.turned += result.new_force_direction;
    simulator.write_record(after);
    if (result.substeps == 1 && !result.new_force_direction) {
      const auto worst = certificate::certify_step(scene, before, after).worst();
      EXPECT_LE(worst.value, 2e-8) << scene.name << " step " << step << ' ' << worst.what;
    }
    std::swap(before, after);
  }
}

TEST(Rubbing, ScenesAtHighFrictionAreSolvedAndCertified) {
  Count count;
  for (const Mechanism& scene : rubbing::scenes(60)) run(scene, 100, count);
}

/// 52 iterations per step when every step began its search at two parts.
TEST(Rubbing, ChainsThatNeedManyPartsAgainAreTriedInHalfAsManyFirst) {
  campaign::Options options;
  options.families = {"snapping"};
  options.steps = 11111;
  const campaign::Count count = campaign::run(options).total();
  const double mean = static_cast<double>(count.iterations) / count.steps;
  std::printf("             %.1f iterations on average, %d steps with new directions\n", mean, count.turned);
  EXPECT_LE(mean, 46);
  EXPECT_LE(count.turned, 850);
}

/// A bar that hangs from a hinge and is jammed between it and the floor: no force directions at the old configuration hold
/// it, step after step (412 iterations each when every step tried all of them), where slip is the paper's.
TEST(Rubbing, AJammedBarIsHeldWithoutTryingEverythingEveryTime) {
  Count count;
  Mechanism scene = rubbing::scene(659);
  for (Contact& contact : scene.contacts) contact.friction_model = FrictionModel::pyramid;
  run(scene, 200, count);
  std::printf("             %.0f iterations on average\n", static_cast<double>(count.iterations) / 200);
  EXPECT_GT(count.turned, 20) << "the test shows nothing";
  EXPECT_LE(count.iterations, 350 * 200);
}

}  // namespace test_rubbing
