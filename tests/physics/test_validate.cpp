#include <gtest/gtest.h>

#include <cmath>

#include "scene_mistakes.hpp"

namespace test_validate {

// Every error of `validate` is provoked once; its sentence names the thing, the key and the value.

using namespace physics;
using mistakes::good_scene;
using mistakes::infinity;
using mistakes::message;
using mistakes::nan;

/// Where the wrong value stands in a scene file.
std::string place(const std::function<void(Mechanism&)>& change) {
  Mechanism scene = good_scene();
  change(scene);
  try {
    validate(scene);
  } catch (const DescriptionError& error) {
    return error.place();
  }
  return "nothing is wrong";
}

TEST(Validate, AcceptsAGoodScene) { EXPECT_EQ(message(CHANGE((void)scene)), ""); }

TEST(Validate, NamesTheTimeStep) {
  EXPECT_EQ(message(CHANGE(scene.time_step = 0)), "scene: time step 0 s is not > 0");
  EXPECT_EQ(message(CHANGE(scene.time_step = nan)), "scene: time step nan s is not > 0");
  EXPECT_EQ(message(CHANGE(scene.time_step = infinity)), "scene: time step inf s is not finite");
}

TEST(Validate, ErrorsKnowThePlaceInAFile) {
  EXPECT_EQ(place(CHANGE(scene.time_step = 0)), "time_step");
  EXPECT_EQ(place(CHANGE(scene.gravity.x() = nan)), "gravity");
  EXPECT_EQ(place(CHANGE(scene.bodies[1].name = "disc")), "bodies[1].name");
  EXPECT_EQ(place(CHANGE(scene.bodies[0].name = "world")), "bodies[0].name");
  EXPECT_EQ(place(CHANGE(scene.bodies[1].mass = 0)), "bodies[1].mass");
  EXPECT_EQ(place(CHANGE(scene.bodies[1].inertia.setZero())), "bodies[1].inertia");
  EXPECT_EQ(place(CHANGE(scene.bodies[0].angular_velocity.x() = 1e4)), "bodies[0].angular_velocity");
  EXPECT_EQ(place(CHANGE(scene.bodies[0].shape.type = Shape::Type::sphere)), "bodies[0].shape.radius");
  EXPECT_EQ(place(CHANGE(scene.joints[0].parent_point.x() = nan)), "joints[0].parent_point");
  EXPECT_EQ(place(CHANGE(scene.joints[1].child = world)), "joints[1].child");
  EXPECT_EQ(place(CHANGE(scene.joints[0].motor->target = SineTarget{.phase = nan})), "joints[0].motor.target.phase");
  EXPECT_EQ(place(CHANGE(scene.joints[0].motor->target = TableTarget({{0, 1}, {0, 1}}))), "joints[0].motor.target[1]");
  EXPECT_EQ(place(CHANGE(scene.contacts[0].friction = -1)), "contacts[0].friction");
  EXPECT_EQ(place(CHANGE(scene.loads[0].first_step = 0)), "loads[0].steps[0]");
}

TEST(Validate, NamesGravity) {
  EXPECT_EQ(message(CHANGE(scene.gravity.z() = -infinity)), "scene: gravity (0, 0, -inf) is not finite");
}

TEST(Validate, WantsNamesThatDiffer) {
  EXPECT_EQ(message(CHANGE(scene.bodies[1].name = "disc")), "there are two bodies called 'disc'");
  EXPECT_EQ(message(CHANGE(scene.joints[1].name = "knee")), "there are two joints called 'knee'");
  EXPECT_EQ(message(CHANGE(scene.add(scene.contacts[0]))), "there are two contacts called 'rim'");
  EXPECT_EQ(message(CHANGE(scene.bodies[1].name = "")), "body 1 has no name");
  EXPECT_EQ(message(CHANGE(scene.contacts[0].name = "disc")), "") << "a contact may be called like a body";
}

TEST(Validate, KeepsTheNameWorldForTheGround) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].name = "world")),
            "body 0 is called 'world', which is the name of the ground");
}

TEST(Validate, NamesAWrongMass) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].mass = -1)), "body 'disc': mass -1 kg is not > 0");
  EXPECT_EQ(message(CHANGE(scene.bodies[1].mass = 0)), "body 'rod': mass 0 kg is not > 0");
  EXPECT_EQ(message(CHANGE(scene.bodies[1].mass = nan)), "body 'rod': mass nan kg is not > 0");
  EXPECT_EQ(message(CHANGE(scene.bodies[1].mass = infinity)), "body 'rod': mass inf kg is not finite");
  EXPECT_EQ(message(CHANGE(scene.bodies[1].mass = 1e-320)),
            "body 'rod': mass 1e-320 kg is so small that its digits are lost");
}

TEST(Validate, NamesAnUnsymmetricInertia) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].inertia(0, 2) = 0.1)),
            "body 'disc': inertia is not symmetric ([2][0] is 0, [0][2] is 0.1)");
}

TEST(Validate, NamesAnInertiaThatIsNotPositiveDefinite) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].inertia.setZero())),
            "body 'disc': inertia is not positive definite (principal moments (0, 0, 0) kg m^2)");
  EXPECT_EQ(message(CHANGE(scene.bodies[0].inertia(0, 1) = scene.bodies[0].inertia(1, 0) = 1.5)).substr(0, 68),
            "body 'disc': inertia is not positive definite (principal moments (-0");
  EXPECT_EQ(message(CHANGE(scene.bodies[0].inertia(1, 1) = nan)), "body 'disc': inertia is not finite");
}

TEST(Validate, NamesAnInertiaNoBodyCanHave) {
  EXPECT_EQ(
      message(CHANGE(scene.bodies[0].inertia(2, 2) = 3.1)),
      "body 'disc': inertia violates the triangle inequality (principal moments (1, 2, 3.1) kg m^2: the smaller two "
      "add up to 3)");
}

TEST(Validate, AcceptsAFlatDiscWhichLiesOnTheTriangleInequality) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].inertia = Vec3(0.1, 0.2, 0.30000000000000004).asDiagonal())), "");
}

TEST(Validate, AcceptsAVeryThinRod) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].inertia = Vec3(1, 1, 1e-13).asDiagonal())), "");
}

TEST(Validate, NamesValuesOfABodyThatAreNotFinite) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].position.x() = nan)), "body 'disc': position (nan, 0, 0) is not finite");
  EXPECT_EQ(message(CHANGE(scene.bodies[0].velocity.y() = infinity)),
            "body 'disc': velocity (0, inf, 0) is not finite");
  EXPECT_EQ(message(CHANGE(scene.bodies[0].angular_velocity.z() = nan)),
            "body 'disc': angular velocity (0, 0, nan) is not finite");
  EXPECT_EQ(message(CHANGE(scene.bodies[0].orientation.w() = nan)), "body 'disc': orientation is not finite");
}

TEST(Validate, NamesAQuaternionFarFromUnit) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].orientation = Quat(1, 0, 0.1, 0))),
            "body 'disc': orientation [1, 0, 0.1, 0] has length 1.00498756, not 1");
  EXPECT_EQ(message(CHANGE(scene.joints[1].orientation = Quat(0, 0, 0, 0))),
            "spherical joint 'ball': orientation [0, 0, 0, 0] has length 0, not 1");
}

TEST(Validate, NormalisesAQuaternionNearUnit) {
  Mechanism scene = good_scene();
  scene.bodies[0].orientation = Quat(1 + 5e-7, 0, 0, 0);
  scene.joints[0].orientation = Quat(0, 1 - 5e-7, 0, 0);
  validate(scene);
  EXPECT_NEAR(scene.bodies[0].orientation.w(), 1, 1e-15);
  EXPECT_NEAR(scene.joints[0].orientation.x(), 1, 1e-15);
}

TEST(Validate, ChangesNothingTheSecondTime) {
  Mechanism scene = good_scene();
  scene.bodies[0].orientation = Quat(0.3, 0.4, 0.5, 0.7071067);
  scene.joints[0].axis = Vec3(1, 2, 3);
  scene.contacts[0].normal = Vec3(0.6, 0, 0.8000001);
  scene.contacts[0].tangent = Vec3(1, 2, 0);
  validate(scene);
  const Mechanism once = scene;
  validate(scene);
  EXPECT_EQ(scene.bodies[0].orientation.coeffs(), once.bodies[0].orientation.coeffs());
  EXPECT_EQ(scene.joints[0].axis, once.joints[0].axis);
  EXPECT_EQ(scene.contacts[0].normal, once.contacts[0].normal);
  EXPECT_EQ(*scene.contacts[0].tangent, *once.contacts[0].tangent);
}

TEST(Validate, SaysWhichTimeStepASpinNeeds) {
  EXPECT_EQ(message(CHANGE(scene.bodies[0].angular_velocity = Vec3(0, 0, 250))),
            "body 'disc': spins at 250 rad/s; |w| dt = 2.5 must be < 1.9: use a time step below 0.0076 s");
}

TEST(Validate, NamesAWrongShape) {
  const auto with = [](Shape shape) { return message([shape](Mechanism& scene) { scene.bodies[0].shape = shape; }); };
  using enum Shape::Type;
  EXPECT_EQ(with({.type = sphere, .file = ""}), "body 'disc': shape radius 0 m is not > 0");
  EXPECT_EQ(with({.type = cylinder, .radius = 1, .height = -2, .file = ""}),
            "body 'disc': shape height -2 m is not > 0");
  EXPECT_EQ(with({.type = box, .size = Vec3(1, 0, 1), .file = ""}),
            "body 'disc': shape size (1, 0, 1) m is not > 0");
  EXPECT_EQ(with({.type = mesh, .file = ""}), "body 'disc': shape file is empty");
}

TEST(Validate, NamesAWrongAxis) {
  EXPECT_EQ(message(CHANGE(scene.joints[0].axis.setZero())), "revolute joint 'knee': axis has length 0");
  EXPECT_EQ(message(CHANGE(scene.joints[0].axis.x() = nan)), "revolute joint 'knee': axis (nan, 0, 1) is not finite");
}

TEST(Validate, NormalisesAnAxis) {
  Mechanism scene = good_scene();
  scene.joints[0].axis = Vec3(0, 3, 4);
  validate(scene);
  EXPECT_TRUE(scene.joints[0].axis.isApprox(Vec3(0, 0.6, 0.8), 1e-15));
}

TEST(Validate, NamesJointPointsThatAreNotFinite) {
  EXPECT_EQ(message(CHANGE(scene.joints[0].parent_point.x() = nan)),
            "revolute joint 'knee': parent point (nan, 0, 0) is not finite");
  EXPECT_EQ(message(CHANGE(scene.joints[0].child_point.x() = nan)),
            "revolute joint 'knee': child point (nan, 0, 0) is not finite");
}

TEST(Validate, NamesJointsThatConnectNothing) {
  EXPECT_EQ(message(CHANGE(scene.joints[0].parent = scene.joints[0].child)),
            "revolute joint 'knee': connects body 'rod' with itself");
  EXPECT_EQ(message(CHANGE(scene.joints[1].child = world)),
            "spherical joint 'ball': child is the world, which can only be the parent");
  EXPECT_EQ(message(CHANGE(scene.joints[0].parent.index = 7)),
            "revolute joint 'knee': parent 7 is not a body (the scene has 2, counted from 0)");
  EXPECT_EQ(message(CHANGE(scene.joints[0].child.index = 2)),
            "revolute joint 'knee': child 2 is not a body (the scene has 2, counted from 0)");
}

TEST(Validate, NamesAMotorWithNothingToDrive) {
  EXPECT_EQ(message(CHANGE(scene.joints[1].motor.emplace())),
            "spherical joint 'ball': has a motor, which only revolute and prismatic joints can have");
}

TEST(Validate, NamesWrongFiguresOfAMotor) {
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->stiffness = -1)),
            "revolute joint 'knee': motor stiffness -1 is not >= 0");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->stiffness = infinity)),
            "revolute joint 'knee': motor stiffness inf is not finite");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->damping = nan)),
            "revolute joint 'knee': motor damping nan is not >= 0");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->limit = 0)), "revolute joint 'knee': motor limit 0 is not > 0");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->limit = nan)), "revolute joint 'knee': motor limit nan is not > 0");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->limit = infinity)), "");
}

TEST(Validate, NamesAWrongTargetOfAMotor) {
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->target = nan)),
            "revolute joint 'knee': motor target nan is not finite");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->target = SineTarget{.frequency = infinity})),
            "revolute joint 'knee': motor target frequency inf is not finite");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->target = TableTarget{})),
            "revolute joint 'knee': motor target is an empty table");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->target = TableTarget({{0, 1}, {0.5, nan}}))),
            "revolute joint 'knee': value 1 of the motor target nan is not finite");
  EXPECT_EQ(message(CHANGE(scene.joints[0].motor->target = TableTarget({{0, 1}, {2, 1}, {2, 3}}))),
            "revolute joint 'knee': times of the motor target do not increase (time 2 is 2 s after 2 s)");
}

}  // namespace test_validate
