// Runs of many copies: in order, complete, the same in bits for any threads and lanes.

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "physics/batch_run.hpp"
#include "physics/batch_variation.hpp"
#include "physics/scenes.hpp"

namespace test_batch_run {

using namespace physics;

const std::vector<Variation> variations{{"friction", 0.1, 0.8}, {"mass", 0.5, 2}, {"start.velocity.x", -1, 1}};

std::vector<CopyResult> results(const Mechanism& scene, BatchRun run) {
  std::vector<CopyResult> all;
  run.make = [&](long long copy) {
    Mechanism mechanism = scene;
    const auto values = draw(variations, 5, copy);
    for (std::size_t i = 0; i < values.size(); ++i) set_value(mechanism, variations[i].key, values[i]);
    return mechanism;
  };
  run.on_result = [&](CopyResult&& result) {
    all.push_back(std::move(result));
    return true;
  };
  run_batch(scene, run);
  return all;
}

BatchRun of(int threads, int lanes, long long first = 0, long long last = 37) {
  BatchRun run;
  run.first = first;
  run.last = last;
  run.steps = 25;
  run.threads = threads;
  run.lanes = lanes;
  return run;
}

TEST(BatchRun, ResultsAreInOrderAndTheSameInBitsForAnyThreadsAndLanes) {
  const Mechanism scene = built_in_scene("snake:n=3");
  const auto expected = results(scene, of(1, 1));
  ASSERT_EQ(expected.size(), 37u);
  for (const BatchRun& run : {of(1, 8), of(2, 8), of(4, 3), of(1, 64)}) {
    const auto found = results(scene, run);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].copy, static_cast<long long>(i));
      EXPECT_TRUE(found[i].ok());
      EXPECT_EQ(found[i].steps, 25);
      EXPECT_EQ(found[i].iterations, expected[i].iterations);
      EXPECT_EQ(found[i].energy_end, expected[i].energy_end);
      EXPECT_EQ(found[i].smallest_distance, expected[i].smallest_distance);
      for (std::size_t b = 0; b < found[i].bodies.size(); ++b)
        EXPECT_TRUE(found[i].bodies[b].position == expected[i].bodies[b].position &&
                    found[i].bodies[b].velocity == expected[i].bodies[b].velocity);
    }
  }
}

TEST(BatchRun, AnyRangeOfCopiesIsTheSamePartOfAll) {
  const Mechanism scene = built_in_scene("tumbling_box");
  const auto all = results(scene, of(2, 8)), part = results(scene, of(1, 8, 11, 20));
  ASSERT_EQ(part.size(), 9u);
  for (std::size_t i = 0; i < part.size(); ++i) {
    EXPECT_EQ(part[i].copy, all[11 + i].copy);
    EXPECT_EQ(part[i].energy_end, all[11 + i].energy_end);
  }
}

TEST(BatchRun, AFailedCopyMakesRoomForTheNext) {
  const Mechanism scene = built_in_scene("free_top");
  BatchRun run = of(1, 2, 0, 9);
  std::vector<int> steps;
  run.make = [&](long long copy) {
    Mechanism mechanism = scene;
    if (copy % 3 == 1) mechanism.add(Load{.body = {0}, .first_step = 4, .last_step = 4, .torque = {0, 1e12, 0}});
    return mechanism;
  };
  run.on_result = [&](CopyResult&& result) {
    steps.push_back(result.steps);
    EXPECT_EQ(result.ok(), result.steps == 25);
    EXPECT_EQ(result.place.empty(), result.ok());
    return true;
  };
  run_batch(scene, run);
  EXPECT_EQ(steps, (std::vector<int>{25, 3, 25, 25, 3, 25, 25, 3, 25}));
}

TEST(BatchRun, TheLowestWrongCopyIsNamedForAnyThreads) {
  const Mechanism scene = built_in_scene("disc");
  for (const int threads : {1, 4}) {
    BatchRun run = of(threads, 4);
    run.make = [&](long long copy) {
      Mechanism mechanism = scene;
      if (copy >= 9) mechanism.bodies[0].mass = -1;
      return mechanism;
    };
    run.on_result = [](CopyResult&&) { return true; };
    try {
      run_batch(scene, run);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const DescriptionError& error) {
      EXPECT_EQ(std::string(error.what()).substr(0, 8), "copy 9: ") << error.what();
    }
  }
}

TEST(BatchRun, NamesWhatIsNotSet) {
  const Mechanism scene = built_in_scene("sliding_box");
  const auto error_of = [&](const BatchRun& run) -> std::string {
    try {
      run_batch(scene, run);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "ran";
  };
  BatchRun run = of(2, 8);
  run.on_result = [](CopyResult&&) { return true; };
  EXPECT_EQ(error_of(run), "run_batch: 'make' is not set, which gives each copy");
  run.make = [&](long long) { return scene; };
  EXPECT_EQ(error_of(run), "ran");
  run.on_result = nullptr;
  EXPECT_EQ(error_of(run), "run_batch: 'on_result' is not set, which takes the results");
}

TEST(BatchRun, EndsWhenTheReceiverHasEnough) {
  const Mechanism scene = built_in_scene("disc");
  BatchRun run = of(2, 4);
  int received = 0;
  run.make = [&](long long) { return scene; };
  run.on_result = [&](CopyResult&&) { return ++received < 5; };
  run_batch(scene, run);
  EXPECT_EQ(received, 5);
}

TEST(BatchVariation, NumbersDependOnSeedCopyAndKeyAloneAndFillTheRange) {
  EXPECT_EQ(uniform(1, 2, "friction"), uniform(1, 2, "friction"));
  std::set<double> all;
  double sum = 0, squares = 0;
  constexpr int n = 20000;
  for (int copy = 0; copy < n; ++copy) {
    const double u = uniform(3, copy, "mass");
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    all.insert(u);
    sum += u;
    squares += u * u;
  }
  EXPECT_EQ(all.size(), static_cast<std::size_t>(n));
  EXPECT_NEAR(sum / n, 0.5, 0.01);          // five standard deviations
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.011);
  double product = 0;
  for (int copy = 0; copy < n; ++copy)
    product += (uniform(3, copy, "a") - 0.5) * (uniform(3, copy, "b") - 0.5) + (uniform(3, copy, "a") - 0.5) * (uniform(4, copy, "a") - 0.5);
  EXPECT_NEAR(product / n, 0, 0.005) << "keys and seeds are independent";
}

TEST(BatchVariation, EveryKeySetsWhatItSays) {
  Mechanism scene = built_in_scene("quadruped");
  const Mechanism before = scene;
  Body& body = scene.bodies[0];
  Joint& joint = *std::find_if(scene.joints.begin(), scene.joints.end(), [](const Joint& j) { return j.motor.has_value(); });
  Contact& contact = scene.contacts[1];
  set_value(scene, "friction", 0.33);
  EXPECT_EQ(*contact.friction, 0.33);
  set_value(scene, contact.name + ".friction", 0.44);
  EXPECT_EQ(*contact.friction, 0.44);
  EXPECT_EQ(*scene.contacts[0].friction, 0.33);
  set_value(scene, body.name + ".mass", 2 * body.mass);
  EXPECT_DOUBLE_EQ(body.mass, 2 * before.bodies[0].mass);
  EXPECT_DOUBLE_EQ(body.inertia(1, 1), 2 * before.bodies[0].inertia(1, 1));
  set_value(scene, "mass", 3);
  EXPECT_DOUBLE_EQ(body.mass, 6 * before.bodies[0].mass);
  EXPECT_DOUBLE_EQ(scene.bodies[1].mass, 3 * before.bodies[1].mass);
  set_value(scene, "gravity", 1.62);
  EXPECT_DOUBLE_EQ(scene.gravity.z(), -1.62);
  set_value(scene, joint.name + ".stiffness", 12);
  set_value(scene, joint.name + ".damping", 0.3);
  EXPECT_EQ(joint.motor->stiffness, 12);
  EXPECT_EQ(joint.motor->damping, 0.3);
  set_value(scene, "start.position.z", 0.5);
  EXPECT_DOUBLE_EQ(scene.bodies[2].position.z(), before.bodies[2].position.z() + 0.5);
  set_value(scene, "start.velocity.y", 0.25);
  EXPECT_DOUBLE_EQ(scene.bodies[2].velocity.y(), before.bodies[2].velocity.y() + 0.25);
  set_value(scene, "start." + body.name + ".angular_velocity.x", 4);
  EXPECT_EQ(body.angular_velocity.x(), 4);
  set_value(scene, "start." + body.name + ".velocity.x", 5);
  EXPECT_EQ(body.velocity.x(), 5);
  EXPECT_THROW(set_value(scene, "start.velocity.w", 1), DescriptionError);
  EXPECT_THROW(set_value(scene, "start.nobody.velocity.x", 1), DescriptionError);
  EXPECT_THROW(set_value(scene, "friction", -1), DescriptionError);
}

}  // namespace test_batch_run
