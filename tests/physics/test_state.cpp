#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "physics/batch_simulator.hpp"
#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_state {

// The state between two steps: what a failed step leaves of it, and what a record takes up again.

using namespace physics;

void expect_near(const Vec3& a, const Vec3& b, double tolerance) { EXPECT_LE((a - b).norm(), tolerance * (1 + b.norm())); }

void expect_same(const StepRecord& found, const StepRecord& expected, double tolerance) {
  EXPECT_EQ(found.step, expected.step);
  EXPECT_EQ(found.time, expected.time);
  for (std::size_t k = 0; k < expected.bodies.size(); ++k) {
    EXPECT_EQ(found.bodies[k].position, expected.bodies[k].position);
    EXPECT_EQ(found.bodies[k].orientation.coeffs(), expected.bodies[k].orientation.coeffs());
    EXPECT_EQ(found.bodies[k].velocity, expected.bodies[k].velocity);
    EXPECT_EQ(found.bodies[k].angular_velocity, expected.bodies[k].angular_velocity);
  }
  for (std::size_t k = 0; k < expected.contacts.size(); ++k) {
    const ContactRecord &a = found.contacts[k], &b = expected.contacts[k];
    EXPECT_EQ(a.distance, b.distance);
    EXPECT_EQ(a.normal_force, b.normal_force);
    EXPECT_EQ(a.friction_force, b.friction_force);
    EXPECT_EQ(a.facet_forces, b.facet_forces);
    EXPECT_EQ(a.tangent, b.tangent);
  }
  for (std::size_t k = 0; k < expected.joints.size(); ++k) {
    const JointRecord &a = found.joints[k], &b = expected.joints[k];
    expect_near(a.force, b.force, tolerance);
    expect_near(a.torque, b.torque, tolerance);
    EXPECT_EQ(a.error, b.error);
    EXPECT_EQ(a.effort, b.effort);
    EXPECT_EQ(a.coordinate, b.coordinate);
    EXPECT_EQ(a.rate, b.rate);
  }
  ASSERT_TRUE(found.solver && expected.solver);
  EXPECT_EQ(found.solver->status, expected.solver->status);
  EXPECT_EQ(found.solver->iterations, expected.solver->iterations);
  EXPECT_EQ(found.solver->substeps, expected.solver->substeps);
}

/// A wheel driven after a sine, and, where it is to be disturbed, a top so fast that the first step needs substeps.
Mechanism driven_wheel(double time_step, bool with_top) {
  Mechanism scene;
  scene.time_step = time_step;
  scene.start = Start::half_kick;
  Body body;
  body.name = "wheel";
  body.mass = 2;
  body.inertia = 0.02 * Mat3::Identity();
  Joint hub;
  hub.name = "hub";
  hub.type = JointType::revolute;
  hub.child = scene.add(body);
  hub.motor = Motor{.stiffness = 50, .damping = 0.7, .limit = 1e3, .target = SineTarget{.amplitude = 1, .frequency = 8}};
  scene.add(hub);
  if (!with_top) return scene;
  body.name = "top";
  body.position.x() = 5;
  body.angular_velocity = {0, 0, 1.2 / time_step};
  scene.add(body);
  return scene;
}

TEST(State, AMotorsTargetMovesWithinSubsteps) {
  constexpr double dt = 0.01;
  Simulator disturbed(driven_wheel(dt, true));
  const StepResult result = disturbed.step();
  ASSERT_TRUE(result.ok());
  ASSERT_GT(result.substeps, 1) << "the test shows nothing";
  Simulator alone(driven_wheel(dt / result.substeps, false));
  for (int k = 0; k < result.substeps; ++k) ASSERT_TRUE(alone.step().ok());
  StepRecord found, expected;
  disturbed.write_record(found);
  alone.write_record(expected);
  EXPECT_NEAR(found.bodies[0].angular_velocity.z(), expected.bodies[0].angular_velocity.z(), 1e-9);
  EXPECT_NEAR(*found.joints[0].effort, *expected.joints[0].effort, 1e-7);
  EXPECT_GT(std::abs(*found.joints[0].effort), 1);
}

TEST(State, TimeIsTheNumberOfStepsTimesTheirLength) {
  constexpr double dt = 0.01;
  Simulator simulator(driven_wheel(dt, false));
  double sum = 0;
  for (int k = 1; k <= 5000; ++k) {
    ASSERT_TRUE(simulator.step().ok());
    sum += dt;
    ASSERT_EQ(simulator.time(), k * dt) << k;
  }
  EXPECT_NE(simulator.time(), sum) << "the test shows nothing";
  BatchSimulator batch(driven_wheel(dt, false), 2);
  for (int k = 1; k <= 100; ++k) batch.step();
  EXPECT_EQ(batch.time(1), 100 * dt);
}

TEST(State, AContinuedRunHasTheTimesOfTheWholeAndOfItsRecordWhereThatBeganElsewhere) {
  constexpr double dt = 0.01;
  const Mechanism scene = driven_wheel(dt, false);
  Simulator whole(scene), continued(scene);
  StepRecord record;
  for (int k = 0; k < 57; ++k) ASSERT_TRUE(whole.step().ok());
  whole.write_record(record);
  continued.restart_from(record);
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(whole.step().ok() && continued.step().ok());
    ASSERT_EQ(continued.time(), whole.time()) << k;
  }
  record.time = 100.1;
  continued.restart_from(record);
  EXPECT_EQ(continued.time(), 100.1);
  for (int k = 1; k <= 50; ++k) {
    ASSERT_TRUE(continued.step().ok());
    ASSERT_NEAR(continued.time(), 100.1 + k * dt, 1e-14 * 100);
  }
  EXPECT_EQ(continued.step_index(), 107);
}

TEST(State, AFailedStepLeavesTheWholeRecordAsItWas) {
  for (const char* name : {"sliding_box", "sliding_box:model=pyramid", "disc:c=4,height=0.01", "snake:n=3", "quadruped",
                           "pendulum:n=3", "tumbling_box:mu=0"}) {
    SCOPED_TRACE(name);
    Mechanism scene = built_in_scene(name);
    // More angular momentum than any turn of less than half a circle per substep holds.
    scene.add(Load{.body = {0}, .first_step = 41, .last_step = 42, .torque = Vec3(0, 0, 1e12)});
    Simulator simulator(scene);
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(simulator.step().ok()) << k;
    StepRecord before, after;
    simulator.write_record(before);
    const double energy = simulator.energy();
    for (int repeat = 0; repeat < 2; ++repeat) {
      ASSERT_FALSE(simulator.step().ok());
      simulator.write_record(after);
      expect_same(after, before, 1e-10);
      EXPECT_EQ(simulator.energy(), energy);
    }
  }
}

/// A wheel on a motorised hinge that follows a target through several turns.
Mechanism turning_wheel(double limit) {
  Mechanism scene;
  scene.time_step = 0.01;
  scene.gravity = Vec3::Zero();
  Body wheel;
  wheel.name = "wheel";
  wheel.mass = 1;
  wheel.inertia = 0.1 * Mat3::Identity();
  Joint hinge;
  hinge.name = "hinge";
  hinge.type = JointType::revolute;
  hinge.child = scene.add(wheel);
  hinge.axis = Vec3::UnitZ();
  hinge.motor = Motor{.stiffness = 5, .damping = 1, .limit = limit, .target = TableTarget{{0, 0}, {5, 20}, {6, 20}, {12, 2}}};
  scene.add(hinge);
  return scene;
}

// (Where its limit keeps the motor behind its target it is by less than a turn.)
TEST(State, AMotorThatHasMadeFullTurnsIsContinuedInTheTurnWhereItIs) {
  for (const double limit : {std::numeric_limits<double>::infinity(), 0.5}) {
    const Mechanism scene = turning_wheel(limit);
    Simulator whole(scene);
    StepRecord record, expected, found;
    for (int k = 1; k <= 900; ++k) {
      ASSERT_TRUE(whole.step().ok());
      if (k % 90 != 0) continue;
      SCOPED_TRACE("record " + std::to_string(k) + ", limit " + std::to_string(limit));
      whole.write_record(record);
      Simulator continued(scene);
      continued.restart_from(record);
      for (int i = 0; i < 5; ++i, ++k) {
        ASSERT_TRUE(whole.step().ok());
        ASSERT_TRUE(continued.step().ok());
      }
      whole.write_record(expected);
      continued.write_record(found);
      EXPECT_NEAR(*found.joints[0].effort, *expected.joints[0].effort, 1e-6);
      EXPECT_NEAR(found.bodies[0].angular_velocity.z(), expected.bodies[0].angular_velocity.z(), 1e-6);
    }
  }
}

TEST(State, ARestartFromARecordWithoutContactsForgetsTheFrictionBasesToo) {
  const Mechanism scene = built_in_scene("sliding_box:heading=30");
  Simulator fresh(scene), used(scene);
  StepRecord record, expected, found;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(used.step().ok());
  used.write_record(record);
  record.contacts.clear();
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(used.step().ok());  // until it rests
  for (Simulator* simulator : {&fresh, &used}) {
    simulator->restart_from(record);
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(simulator->step().ok());
    simulator->write_record(simulator == &fresh ? expected : found);
  }
  for (std::size_t k = 0; k < expected.contacts.size(); ++k) {
    EXPECT_EQ(found.contacts[k].tangent, expected.contacts[k].tangent);
    EXPECT_EQ(found.contacts[k].facet_forces, expected.contacts[k].facet_forces);
  }
  EXPECT_EQ(found.bodies[0].velocity, expected.bodies[0].velocity);
}

TEST(State, ARecordWhoseForcesOrTangentsAreNoneIsRefusedByName) {
  const Mechanism scene = built_in_scene("sliding_box");
  Simulator simulator(scene);
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(simulator.step().ok());
  StepRecord good;
  simulator.write_record(good);
  const auto refused = [&](auto&& spoil) {
    StepRecord record = good;
    spoil(record.contacts[1]);
    try {
      simulator.restart_from(record);
    } catch (const DescriptionError& error) {
      EXPECT_NE(std::string(error.what()).find("record 10: contact '" + scene.contacts[1].name + "'"), std::string::npos)
          << error.what();
      return true;
    }
    return false;
  };
  EXPECT_FALSE(refused([](ContactRecord&) {}));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.tangent = Vec3(0, 0, 1); }));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.tangent = Vec3(2, 0, 0); }));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.tangent = Vec3(NAN, 0, 0); }));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.normal_force = INFINITY; }));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.normal_force = -1; }));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.facet_forces[2] = NAN; }));
  EXPECT_TRUE(refused([](ContactRecord& c) { c.facet_forces[0] = -1; }));
  ASSERT_TRUE(simulator.step().ok());
}

TEST(State, ARecordWhoseTimeOrJointNumbersAreNotFiniteIsRefusedByName) {
  Simulator simulator(driven_wheel(0.01, false));
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(simulator.step().ok());
  StepRecord good;
  simulator.write_record(good);
  const auto refusal = [&](auto&& spoil) {
    StepRecord record = good;
    spoil(record);
    try {
      simulator.restart_from(record);
    } catch (const DescriptionError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal([](StepRecord&) {}), "");
  EXPECT_EQ(refusal([](StepRecord& r) { r.time = NAN; }), "record 10: its time is not finite");
  EXPECT_EQ(refusal([](StepRecord& r) { r.time = INFINITY; }), "record 10: its time is not finite");
  EXPECT_EQ(refusal([](StepRecord& r) { r.joints[0].coordinate = NAN; }), "record 10: joint 'hub': its coordinate is not finite");
  EXPECT_EQ(refusal([](StepRecord& r) { r.joints[0].rate = INFINITY; }), "record 10: joint 'hub': its rate is not finite");
  EXPECT_EQ(refusal([](StepRecord& r) { r.joints[0].effort = NAN; }), "record 10: joint 'hub': its effort is not finite");
  ASSERT_TRUE(simulator.step().ok());
}

TEST(State, AStartThatOpensAJointIsCorrectedAndSaysByHowMuch) {
  Mechanism scene = built_in_scene("pendulum:n=2");
  EXPECT_EQ(Simulator(scene).start_correction(), 0);
  scene.bodies[0].velocity = {0.3, 0, 0};
  Simulator simulator(scene);
  EXPECT_NEAR(simulator.start_correction(), 0.3, 1e-15);
  ASSERT_TRUE(simulator.step().ok());
  EXPECT_LE(simulator.largest_joint_error(), 1e-9);
}

TEST(State, AJointThatStartsOpenIsNamedWithItsUnit) {
  const auto message = [](auto&& open) {
    Mechanism scene = built_in_scene("pendulum:n=2,joint=revolute");
    open(scene.bodies[1]);
    try {
      const Simulator simulator(scene);
    } catch (const DescriptionError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string joint = "joint '" + built_in_scene("pendulum:n=2,joint=revolute").joints[1].name + "': ";
  EXPECT_EQ(message([](Body& link) { link.position.y() += 0.25; }), joint + "its points start 0.25 m apart");
  for (const auto& [angle, sentence] : {std::pair(0.1, "its bodies start 0.1 rad off their orientation"),
                                        {2.5, "its bodies start 2.5 rad off their orientation"}}) {
    const std::string turned = message([angle](Body& link) {
      // About the point of the joint, which lies on the axis of the link.
      const Quat turn(Eigen::AngleAxisd(angle, link.orientation * Vec3::UnitZ()));
      link.orientation = turn * link.orientation;
    });
    EXPECT_EQ(turned, joint + sentence);
  }
}

}  // namespace test_state
