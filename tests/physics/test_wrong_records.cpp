// Records that no run has written are refused, and nothing is changed by them.

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>

#include "physics/batch_run.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_wrong_records {

using namespace physics;

std::string refusal(Simulator& simulator, const StepRecord& record) {
  try {
    simulator.restart_from(record);
  } catch (const DescriptionError& error) {
    return error.what();
  }
  return "";
}

class WrongRecords : public testing::Test {
 protected:
  void SetUp() override {
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(simulator.step().ok());
    simulator.write_record(record);
    position = record.bodies[2].position;
  }
  void expect_as_before() const {
    StepRecord now;
    simulator.write_record(now);
    EXPECT_EQ(now.bodies[2].position, position);
    EXPECT_EQ(now.step, 5);
  }
  Simulator simulator{built_in_scene("pendulum:n=4")};
  StepRecord record;
  Vec3 position;
};

TEST_F(WrongRecords, WithOpenJointsAreRefusedByName) {
  record.bodies[2].position.x() += 1;
  const std::string refused = refusal(simulator, record);
  EXPECT_TRUE(refused.starts_with("record 5: the points of joint '")) << refused;
  EXPECT_TRUE(refused.ends_with("are 1 m apart")) << refused;
  record.bodies[2].position.x() = 1e200;  // its square is no number
  record.bodies[2].velocity.setZero();
  EXPECT_TRUE(refusal(simulator, record).ends_with("are 1e+200 m apart")) << refusal(simulator, record);
  expect_as_before();
}

/// A joint holds angles as well as points; the bodies turn about the points here, which leaves those together.
TEST(WrongRecordsOfJoints, ThatAreBentAreRefusedByName) {
  for (const JointType type : {JointType::revolute, JointType::prismatic, JointType::fixed, JointType::spherical}) {
    Mechanism scene;
    for (const char* name : {"base", "arm"}) {
      Body body;
      body.name = name;
      body.mass = 1;
      body.inertia = Mat3::Identity();
      scene.add(body);
    }
    Joint joint;
    joint.name = "hinge";
    joint.type = type;
    joint.parent = {0};
    joint.child = {1};
    joint.axis = Vec3::UnitX();
    joint.orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 2) / 3));
    scene.bodies[1].orientation = joint.orientation;
    scene.add(joint);
    Simulator simulator(scene);
    ASSERT_TRUE(simulator.step().ok());
    StepRecord record;
    simulator.write_record(record);
    const Quat held = record.bodies[1].orientation;
    for (int axis = 0; axis < 3; ++axis) {
      const bool free = type == JointType::spherical || (type == JointType::revolute && axis == 0);
      record.bodies[1].orientation = Quat(Eigen::AngleAxisd(0.1, Vec3::Unit(axis))) * held;
      EXPECT_EQ(refusal(simulator, record), free ? "" : "record 1: the bodies of joint 'hinge' are 0.1 rad off their orientation")
          << "type " << static_cast<int>(type) << ", axis " << axis;
    }
    record.bodies[1].orientation.coeffs() = -held.coeffs();  // the same orientation
    EXPECT_EQ(refusal(simulator, record), "");
  }
}

TEST_F(WrongRecords, OfBodiesWithoutAnEnergyAreRefusedByName) {
  record.bodies[2].velocity.z() = 1e200;
  EXPECT_EQ(refusal(simulator, record),
            "record 5: body 'link 2' moves so fast or lies so far away that its energy is no number");
  expect_as_before();
}

TEST_F(WrongRecords, WithASpinThatHasNoMomentumAreRefusedByName) {
  record.bodies[2].angular_velocity.z() = 1000;
  const std::string refused = refusal(simulator, record);
  EXPECT_NE(refused.find("spins too fast: |w| dt = 10 must be <"), std::string::npos) << refused;
  expect_as_before();
}

/// Steps after it would have no numbers.
TEST_F(WrongRecords, OfTheLastStepThereIsAreRefused) {
  record.step = std::numeric_limits<int>::max();
  EXPECT_FALSE(refusal(simulator, record).empty());
  expect_as_before();
  record.step = 1 << 30;
  EXPECT_EQ(refusal(simulator, record), "");
  EXPECT_TRUE(simulator.step().ok());
  EXPECT_EQ(simulator.step_index(), (1 << 30) + 1);
}

/// A contact of a body that cannot move may lie inside a plane for ever; it is not what a copy is refused for.
TEST(StartInside, NamesTheContactThatCanMove) {
  Mechanism scene;
  scene.time_step = 0.01;
  for (const char* name : {"static", "moving"}) {
    Body body;
    body.name = name;
    body.mass = 1;
    body.inertia = Mat3::Identity();
    body.position.z() = scene.bodies.empty() ? -3 : -0.001;
    Contact contact;
    contact.name = name;
    contact.body = scene.add(body);
    scene.add(contact);
  }
  Joint weld;
  weld.name = "weld";
  weld.type = JointType::fixed;
  weld.child = {0};
  weld.parent_point = {0, 0, -3};
  scene.add(weld);
  BatchRun run;
  run.last = 1;
  run.steps = 1;
  run.make = [&](long long) { return scene; };
  CopyResult result;
  run.on_result = [&](CopyResult&& copy) {
    result = std::move(copy);
    return true;
  };
  run_batch(scene, run);
  EXPECT_EQ(result.start_contact, 1);
  EXPECT_NEAR(result.start_depth, 0.001, 1e-12);
}

}  // namespace test_wrong_records
