// A copy in a batch moves as it would alone, in any lane and any company.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "physics/batch_simulator.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_batch_simulator {

using namespace physics;

/// Variant i of a scene: another friction, mass and speed.
Mechanism variant(const std::string& spec, int i) {
  Mechanism scene = built_in_scene(spec);
  for (Contact& contact : scene.contacts)
    if (contact.friction) *contact.friction *= 1 + 0.13 * i;
  for (Body& body : scene.bodies) {
    body.mass *= 1 + 0.07 * i;
    body.inertia *= 1 + 0.07 * i;
    body.velocity.x() += 0.05 * i;
  }
  scene.loads.push_back({.body = {0}, .first_step = 3, .last_step = 9, .force = {0.4 * i, 0, 0}});
  return scene;
}

StepRecord record_of(const BatchSimulator& batch, int lane) {
  StepRecord record;
  batch.write_record(lane, record);
  return record;
}

void expect_same_bits(const StepRecord& a, const StepRecord& b, const std::string& what) {
  const auto same = [&](const auto& u, const auto& v) {
    for (Eigen::Index i = 0; i < u.size(); ++i)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(u[i]), std::bit_cast<std::uint64_t>(v[i])) << what;
  };
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  EXPECT_EQ(a.step, b.step) << what;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    same(a.bodies[i].position, b.bodies[i].position);
    same(a.bodies[i].orientation.coeffs(), b.bodies[i].orientation.coeffs());
    same(a.bodies[i].velocity, b.bodies[i].velocity);
    same(a.bodies[i].angular_velocity, b.bodies[i].angular_velocity);
  }
  for (std::size_t i = 0; i < a.contacts.size(); ++i) same(a.contacts[i].friction_force, b.contacts[i].friction_force);
}

class BatchSimulatorScenes : public testing::TestWithParam<const char*> {};

TEST_P(BatchSimulatorScenes, EveryLaneMovesAsASimulatorOfItsOwn) {
  const std::string spec = GetParam();
  constexpr int lanes = 11, steps = 60;  // a full pack of 8 and a rest
  BatchSimulator batch(built_in_scene(spec), lanes);
  std::vector<Simulator> alone;
  for (int i = 0; i < lanes; ++i) {
    batch.load(i, variant(spec, i));
    alone.emplace_back(variant(spec, i));
  }
  for (int k = 0; k < steps; ++k) {
    batch.step();
    for (int i = 0; i < lanes; ++i) {
      ASSERT_TRUE(batch.result(i).ok()) << "lane " << i;
      ASSERT_TRUE(alone[i].step().ok());
    }
  }
  for (int i = 0; i < lanes; ++i) {
    StepRecord record;
    alone[i].write_record(record);
    expect_same_bits(record_of(batch, i), record, spec + ", lane " + std::to_string(i));
    EXPECT_EQ(batch.energy(i), alone[i].energy());
    EXPECT_EQ(batch.smallest_distance(i), alone[i].smallest_distance());
    EXPECT_EQ(batch.largest_joint_error(i), alone[i].largest_joint_error());
  }
}

TEST_P(BatchSimulatorScenes, ACopyIsTheSameInBitsInAnyLaneAndCompany) {
  const std::string spec = GetParam();
  constexpr int steps = 40;
  BatchSimulator first(built_in_scene(spec), 3), second(built_in_scene(spec), 9);
  first.load(1, variant(spec, 4));
  for (int i = 0; i < 9; ++i) second.load(i, variant(spec, i == 8 ? 4 : 2 * i + 1));
  second.unload(3);
  for (int k = 0; k < steps; ++k) {
    first.step();
    second.step();
  }
  expect_same_bits(record_of(first, 1), record_of(second, 8), spec);
  EXPECT_EQ(second.step_index(3), 0) << "an empty lane is left out";
}

TEST_P(BatchSimulatorScenes, AReloadedLaneForgetsWhoWasThereBefore) {
  const std::string spec = GetParam();
  BatchSimulator batch(built_in_scene(spec), 2);
  for (int k = 0; k < 35; ++k) batch.step();
  batch.load(0, variant(spec, 3));  // while lane 1 goes on
  for (int k = 0; k < 35; ++k) batch.step();
  EXPECT_EQ(batch.step_index(0), 35);
  EXPECT_EQ(batch.step_index(1), 70);
  Simulator fresh(variant(spec, 3)), other(built_in_scene(spec));
  StepRecord record;
  for (int k = 0; k < 35; ++k) ASSERT_TRUE(fresh.step().ok());
  fresh.write_record(record);
  expect_same_bits(record_of(batch, 0), record, spec + ", reloaded");
  for (int k = 0; k < 70; ++k) ASSERT_TRUE(other.step().ok());
  other.write_record(record);
  expect_same_bits(record_of(batch, 1), record, spec + ", its neighbour");
}

std::string case_name(const testing::TestParamInfo<const char*>& info) {
  std::string name = info.param;
  return name.substr(0, name.find(':'));
}
// Single body, chain, motors and merged bodies, closed loop, light pads under a heavy block, many facets.
INSTANTIATE_TEST_SUITE_P(BuiltIn, BatchSimulatorScenes,
                         testing::Values("tumbling_box", "snake:n=4", "quadruped", "four_bar", "pads:ratio=100", "hopper"),
                         case_name);

/// A turn that no step length can follow: more momentum than any |w| dt < 2 holds.
Mechanism doomed(int fails_at) {
  Mechanism scene = built_in_scene("free_top");
  scene.loads.push_back({.body = {0}, .first_step = fails_at, .last_step = fails_at, .torque = {0, 0, 1e12}});
  return scene;
}

TEST(BatchSimulator, ALaneThatFailsKeepsItsStateAndTheOthersGoOnUntouched) {
  BatchSimulator batch(built_in_scene("free_top"), 9);
  batch.load(4, doomed(6));
  for (int k = 0; k < 5; ++k) batch.step();
  const StepRecord before = record_of(batch, 4);
  ASSERT_TRUE(batch.running(4));
  for (int k = 0; k < 5; ++k) batch.step();
  EXPECT_FALSE(batch.running(4));
  EXPECT_FALSE(batch.result(4).ok());
  EXPECT_FALSE(batch.result(4).cause.empty());
  EXPECT_NE(batch.failure_place(4).find("body 'top'"), std::string::npos) << batch.failure_place(4);
  EXPECT_EQ(batch.step_index(4), 5);
  expect_same_bits(record_of(batch, 4), before, "the failed lane");
  Simulator alone(built_in_scene("free_top"));
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(alone.step().ok());
  StepRecord record;
  alone.write_record(record);
  for (const int lane : {3, 5, 8}) {
    EXPECT_TRUE(batch.running(lane));
    expect_same_bits(record_of(batch, lane), record, "a neighbour of the failed lane");
  }
  batch.load(4, built_in_scene("free_top"));
  batch.step();
  EXPECT_TRUE(batch.running(4)) << "a failed lane takes another copy";
}

TEST(BatchSimulator, ALaneThatNeedsSubstepsTakesThemAlone) {
  const Mechanism hard = built_in_scene("hanging_bob:n=4"), easy = built_in_scene("hanging_bob:n=4,ratio=1");
  BatchSimulator batch(easy, 3);
  batch.load(1, hard);
  Simulator alone_hard(hard), alone_easy(easy);
  int substepped = 0;
  for (int k = 0; k < 60; ++k) {
    batch.step();
    ASSERT_TRUE(batch.result(1).ok());
    const StepResult result = alone_hard.step();
    ASSERT_TRUE(result.ok() && alone_easy.step().ok());
    EXPECT_EQ(batch.result(1).substeps, result.substeps);
    EXPECT_EQ(batch.result(1).iterations, result.iterations);
    substepped += result.substeps > 1;
    EXPECT_EQ(batch.result(2).substeps, 1);
  }
  EXPECT_GT(substepped, 0) << "the scene was to need substeps";
  StepRecord record;
  alone_hard.write_record(record);
  expect_same_bits(record_of(batch, 1), record, "the hard one");
  alone_easy.write_record(record);
  expect_same_bits(record_of(batch, 2), record, "the easy one");
}

/// Gravity bounds the tolerance, and what rounding of far positions excuses: of each copy its own.
TEST(BatchSimulator, CopiesOfOtherGravityAreAcceptedAtTheToleranceOfASimulatorOfTheirOwn) {
  const std::vector<double> factors{1, 0, 1e-9, 1.1e-5, 1e-3, 1, 7, 1e-6, 1, 1e-7};
  for (const double tolerance : {1e-8, 0.5}) {
    for (const double distance : {0.0, 1e6}) {
      SimulatorSettings settings;
      settings.tolerance = tolerance;
      const auto scene = [&](double factor) {
        Mechanism snake = built_in_scene("snake:n=3,height=0.001");
        snake.gravity *= factor;
        for (Body& body : snake.bodies) body.position.x() += distance;
        return snake;
      };
      const int lanes = static_cast<int>(factors.size());
      BatchSimulator batch(scene(1), lanes, settings);
      std::vector<Simulator> alone;
      long long contact_steps = 0;
      for (int i = 0; i < lanes; ++i) {
        batch.load(i, scene(factors[i]));
        alone.emplace_back(scene(factors[i]), settings);
      }
      for (int k = 0; k < 30; ++k) {
        std::vector<int> running;  // far away some gravities are too small to be told from rounding, and steps fail
        for (int i = 0; i < lanes; ++i)
          if (batch.running(i)) running.push_back(i);
        batch.step();
        for (const int i : running) {
          const StepResult result = alone[i].step();
          ASSERT_EQ(batch.result(i).status, result.status) << factors[i];
          ASSERT_EQ(batch.result(i).iterations, result.iterations) << factors[i];
        }
      }
      for (int i = 0; i < lanes; ++i) {
        StepRecord record;
        alone[i].write_record(record);
        expect_same_bits(record_of(batch, i), record, "gravity times " + std::to_string(factors[i]));
        contact_steps += alone[i].problem_size().contact_steps;
      }
      EXPECT_EQ(batch.problem_size().contact_steps, contact_steps);
      batch.load(2, scene(1));  // what was apart comes back to the others
      batch.step();
      EXPECT_TRUE(batch.result(2).ok());
      EXPECT_GT(batch.problem_size().contact_steps, contact_steps);
    }
  }
}

TEST(BatchSimulator, ACopyOfAnotherStructureIsRefusedByName) {
  BatchSimulator batch(built_in_scene("snake:n=3"), 2);
  const auto refusal = [&](Mechanism copy) {
    try {
      batch.load(0, std::move(copy));
    } catch (const DescriptionError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Mechanism copy = built_in_scene("snake:n=3");
  copy.contacts[1].friction.reset();
  EXPECT_EQ(refusal(copy), "scene 'snake' does not fit those beside it: contact '" + copy.contacts[1].name +
                               "' differs in its body, in having friction, or in directions");
  EXPECT_FALSE(batch.running(0)) << "the lane is empty after a refusal";
  EXPECT_TRUE(batch.running(1));
  EXPECT_NE(refusal(built_in_scene("snake:n=4")).find("it has 4 bodies, not 3"), std::string::npos);
  EXPECT_NE(refusal(built_in_scene("snake:n=3,dt=0.005")).find("its time step is 0.005 s, not 0.01 s"), std::string::npos);
  copy = built_in_scene("snake:n=3");
  copy.joints[0].type = JointType::revolute;
  EXPECT_NE(refusal(copy).find("joint '" + copy.joints[0].name + "' differs in type"), std::string::npos);
  copy = built_in_scene("snake:n=3");
  copy.bodies[2].mass = -1;
  EXPECT_NE(refusal(copy).find("mass"), std::string::npos);
}

TEST(BatchSimulator, AnEmptyBatchIsRefused) {
  EXPECT_THROW(BatchSimulator(built_in_scene("disc"), 0), DescriptionError);
}

}  // namespace test_batch_simulator
