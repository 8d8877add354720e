// Simulator::step allocates nothing, and what a Simulator holds is counted.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "physics/batch_simulator.hpp"
#include "physics/gradients.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"
#include "support/count_allocations.hpp"
#include "thrown_rod.hpp"

namespace test_allocation {

using namespace physics;

using allocation::Counting;

class Allocation : public testing::Test {
 protected:
  void SetUp() override {
    if (!allocation::counted) GTEST_SKIP() << "this build has an allocator that cannot be counted";
  }
};

struct Stepped {
  long allocations = 0;
  int steps = 0, substepped = 0, restarted = 0, put_back = 0;
  bool failed = false;
};

/// From the very first step on; a failed step ends it, and is counted too.
Stepped step_counted(const Mechanism& scene, double duration) {
  Simulator simulator(scene);
  Stepped result;
  for (long k = std::lround(duration / simulator.time_step()); k > 0 && !result.failed; --k) {
    StepResult step;
    {
      const Counting counting;
      step = simulator.step();
      result.allocations += Counting::so_far();
    }
    ++result.steps;
    result.substepped += step.substeps > 1;
    result.restarted += step.restarts > 0;
    result.put_back += step.culling_repeats;
    result.failed = !step.ok();
  }
  EXPECT_EQ(result.allocations, 0) << scene.name << ", " << result.steps << " steps";
  std::printf("             %-16s %4d steps, %d with substeps, %d restarted, %d contacts put back%s\n",
              scene.name.c_str(), result.steps, result.substepped, result.restarted, result.put_back,
              result.failed ? ", the last one failed" : "");
  return result;
}

Stepped step_counted(const char* spec, double duration) { return step_counted(built_in_scene(spec), duration); }

TEST_F(Allocation, IsSeenWhereverItComesFrom) {
  volatile int size = 100;
  const Counting counting;
  const auto vector = std::make_unique<std::vector<double>>(size);
  const long by_new = Counting::so_far();
  EXPECT_GE(by_new, 2);
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  const long by_eigen = Counting::so_far() - by_new;
  EXPECT_GE(by_eigen, 1);
  struct alignas(64) Line {
    char bytes[64];
  };
  const auto line = std::make_unique<Line>();
  EXPECT_GE(Counting::so_far() - by_new - by_eigen, 1);
}

TEST_F(Allocation, NeverHappensInAStepWithContacts) {
  for (const char* spec : {"tumbling_box", "tumbling_box:model=pyramid", "disc:c=30,spin=6", "disc:mu=0",
                           "box_on_slope:fraction=1.3", "spinning_sphere", "pads", "sliding_box:start=standard"})
    step_counted(spec, 1);
}

TEST_F(Allocation, NeverHappensInAStepWithJointsLoopsAndMotors) {
  for (const char* spec : {"pendulum:n=5,dt=0.002", "pendulum:joint=revolute", "loop", "four_bar", "stiff_hinge",
                           "spinning_top", "free_top"})
    step_counted(spec, 0.5);
}

TEST_F(Allocation, NeverHappensInAStepWithBoth) {
  for (const char* spec : {"snake", "snake:n=50,model=pyramid", "hopper", "quadruped"}) step_counted(spec, 1);
}

TEST_F(Allocation, NeverHappensInPuttingACulledContactBack) {
  Mechanism scene = thrown_rod();
  Contact high = scene.contacts[0];
  high.name = "high";
  high.point = {0, 0, 0.5};
  scene.add(high);
  EXPECT_GT(step_counted(scene, 0.5).put_back, 0) << "the test shows nothing";
}

TEST_F(Allocation, NeverHappensWhereSubstepsAndRestartsAreNeeded) {
  int substepped = 0, restarted = 0;
  for (const char* spec : {"hanging_bob:n=4,ratio=100", "hanging_bob", "hanging_bob:start=standard",
                           "free_top:spin=300", "pendulum:n=30,dt=0.05"}) {
    const Stepped stepped = step_counted(spec, 1);
    substepped += stepped.substepped;
    restarted += stepped.restarted;
  }
  EXPECT_GT(substepped, 0) << "the test shows nothing";
  EXPECT_GT(restarted, 0) << "the test shows nothing";
}

/// No turn within a step, |w| dt < 2, takes up this much angular momentum.
TEST_F(Allocation, NeverHappensInAStepThatFails) {
  Mechanism scene = built_in_scene("free_box");
  Load load;
  load.body = {0};
  load.first_step = load.last_step = 5;
  load.torque = {0, 1e6, 0};
  scene.add(load);
  const Stepped stepped = step_counted(scene, 1);
  EXPECT_TRUE(stepped.failed) << "the test shows nothing";
  EXPECT_EQ(stepped.steps, 5);
}

/// Lanes that pass, that need substeps, and one that fails.
TEST_F(Allocation, NeverHappensInAStepOfABatch) {
  BatchSimulator batch(built_in_scene("hanging_bob:n=4,ratio=1"), 10);
  batch.load(2, built_in_scene("hanging_bob:n=4"));
  Mechanism doomed = built_in_scene("hanging_bob:n=4,ratio=1");
  doomed.add(Load{.body = {4}, .first_step = 5, .last_step = 5, .torque = {0, 1e9, 0}});
  batch.load(7, doomed);
  int substepped = 0;
  for (int k = 0; k < 40; ++k) {
    const Counting counting;
    batch.step();
    EXPECT_EQ(Counting::so_far(), 0) << "step " << k + 1;
    substepped += batch.result(2).substeps > 1;
  }
  EXPECT_GT(substepped, 0) << "the test shows nothing";
  EXPECT_FALSE(batch.running(7)) << "the test shows nothing";
}

TEST_F(Allocation, NeverHappensInAskingForFiguresOfTheState) {
  Simulator simulator(built_in_scene("snake"));
  ASSERT_TRUE(simulator.step().ok());
  const Counting counting;
  const double sum = simulator.smallest_distance() + simulator.largest_joint_error() + simulator.energy() +
                     simulator.linear_momentum().norm() + simulator.angular_momentum().norm();
  EXPECT_EQ(Counting::so_far(), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST_F(Allocation, NeverHappensInWritingARecordAgain) {
  Simulator simulator(built_in_scene("snake"));
  StepRecord record;
  ASSERT_TRUE(simulator.step().ok());
  simulator.write_record(record);
  ASSERT_TRUE(simulator.step().ok());
  const Counting counting;
  simulator.write_record(record);
  EXPECT_EQ(Counting::so_far(), 0);
}

TEST_F(Allocation, NeverHappensInDerivativesOfAStep) {
  for (const char* spec : {"quadruped", "tumbling_box", "four_bar"}) {
    Simulator simulator(built_in_scene(spec));
    StepGradient sharp(simulator), smooth(simulator, {.smoothing = 1e-5});
    std::vector<double> adjoint(sharp.state_size(), 1.0), gradient(sharp.gradient_size()),
        by_state(sharp.state_size() * sharp.columns(StepInput::state)),
        by_effort(sharp.state_size() * sharp.columns(StepInput::effort));
    long counted = 0;
    for (int k = 0; k < 40; ++k) {
      ASSERT_TRUE(simulator.step().ok());
      const Counting counting;
      const bool ready = smooth.evaluate() == GradientStatus::ready && sharp.evaluate() == GradientStatus::ready;
      ASSERT_TRUE(ready) << spec << ", step " << k;
      sharp.vector_jacobian(adjoint, gradient);
      sharp.jacobian(StepInput::state, by_state);
      sharp.jacobian(StepInput::effort, by_effort);
      counted += Counting::so_far();
    }
    EXPECT_EQ(counted, 0) << spec;
  }
}

/// Of the heap, by a simulator that has taken a step.
double bytes_held(const Mechanism& scene) {
  const std::int64_t before = allocation::bytes_in_use();
  Simulator simulator(scene);
  EXPECT_TRUE(simulator.step().ok());
  return static_cast<double>(allocation::bytes_in_use() - before);
}

/// Half way between powers of two, where vectors that have grown by doubling are half empty.
template <class Scene>
double bytes_per_link(const char* name, Scene&& scene) {
  const double bytes = (bytes_held(scene(1500)) - bytes_held(scene(750))) / 750;
  std::printf("             %-24s %.0f bytes per link\n", name, bytes);
  return bytes;
}

double bytes_per_link(const char* scene) {
  return bytes_per_link(scene, [&](int n) { return built_in_scene(scene + (":n=" + std::to_string(n))); });
}

/// Free bodies in a row, each a sphere on the floor.
Mechanism balls(int n) {
  Mechanism scene;
  for (int i = 0; i < n; ++i) {
    Body body;
    body.name = "ball " + std::to_string(i);
    body.mass = 1;
    body.shape.type = Shape::Type::sphere;
    body.shape.radius = 0.1;
    body.inertia = shape_inertia(body.shape, body.mass);
    body.position = Vec3(0.3 * i, 0, 0.1);
    body.velocity = Vec3(0.1, 0, 0);
    Contact contact;
    contact.name = "floor " + std::to_string(i);
    contact.body = scene.add(body);
    contact.radius = 0.1;
    contact.friction = 0.5;
    scene.add(contact);
  }
  return scene;
}

TEST_F(Allocation, OfALinkIsBounded) {
  EXPECT_LE(bytes_per_link("snake"), 7330) << "with one contact";
  EXPECT_LE(bytes_per_link("pendulum"), 6110);
}

TEST_F(Allocation, OfABodyWithOneContactIsBounded) { EXPECT_LE(bytes_per_link("balls, one contact each", balls), 3980); }

double bytes_held_by_batch(const Mechanism& scene, int lanes) {
  const std::int64_t before = allocation::bytes_in_use();
  const BatchSimulator batch(scene, lanes);
  return static_cast<double>(allocation::bytes_in_use() - before);
}

/// So many lanes fit nowhere, and the sentence that refuses them must neither exaggerate nor play down.
TEST_F(Allocation, WhatABatchSaysThatItNeedsIsALowerBound) {
  for (const char* spec : {"snake:n=20", "pendulum:n=20", "disc", "free_top"}) {
    const Mechanism scene = built_in_scene(spec);
    const double per_lane = (bytes_held_by_batch(scene, 64) - bytes_held_by_batch(scene, 32)) / 32;
    try {
      const BatchSimulator endless(scene, 2'000'000'000);
      FAIL() << spec;
    } catch (const DescriptionError& error) {
      double needed = 0;
      ASSERT_EQ(std::sscanf(error.what(), "a batch of 2000000000 lanes needs %lf GB or more", &needed), 1)
          << error.what();
      EXPECT_LE(needed, per_lane * 2) << spec;
      EXPECT_GE(needed, per_lane * 2 / 4) << spec;
    }
  }
}

}  // namespace test_allocation
