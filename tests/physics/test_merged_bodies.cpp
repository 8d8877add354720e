#include <gtest/gtest.h>

#include <cmath>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"
#include "support/certificate.hpp"

namespace test_merged_bodies {

// Bodies held by fixed joints become one. Kept apart by their joints they move the same way: the chord of a member off
// the centre is as long as its velocity says, so that both have the same discrete Lagrangian.

using namespace physics;

/// Three bodies of different inertia in general position, welded in a row, thrown and spinning.
Mechanism welded(bool with_ground) {
  Mechanism scene;
  scene.time_step = 0.005;
  const double mass[] = {2, 0.5, 1};
  const Vec3 point[] = {{0.3, 0.1, -0.2}, {-0.1, 0.4, 0.2}}, spin(2, -3, 4), centre(0, 0, 1.5);
  const Quat turn[] = {Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized())),
                       Quat(Eigen::AngleAxisd(-1.2, Vec3(0, 1, 3).normalized()))};
  Vec3 position = centre;
  Quat orientation(Eigen::AngleAxisd(0.4, Vec3(3, -1, 2).normalized()));
  const Vec3 spin_world = orientation * spin;
  for (int k = 0; k < 3; ++k) {
    if (k > 0) {
      position += orientation * point[k - 1];
      orientation = orientation * turn[k - 1];
      position -= orientation * Vec3(0.05, 0, 0.1);
    }
    Body body;
    body.name = "part " + std::to_string(k);
    body.mass = mass[k];
    body.inertia = mass[k] * Vec3(0.01, 0.02, 0.025).asDiagonal();
    body.position = position;
    body.orientation = orientation;
    body.velocity = Vec3(0.5, 0.2, 1) + spin_world.cross(position - centre);
    body.angular_velocity = orientation.conjugate() * spin_world;
    scene.add(body);
    if (k == 0) continue;
    Joint weld;
    weld.name = "weld " + std::to_string(k);
    weld.type = JointType::fixed;
    weld.parent = {k - 1};
    weld.child = {k};
    weld.parent_point = point[k - 1];
    weld.child_point = {0.05, 0, 0.1};
    weld.orientation = turn[k - 1];
    scene.add(weld);
  }
  scene.add(Load{.body = {2}, .first_step = 20, .last_step = 60, .force = {3, -1, 2}, .torque = {0.2, 0.1, -0.3}});
  for (int k = 0; with_ground && k < 3; ++k) {
    Contact contact;
    contact.name = "tip " + std::to_string(k);
    contact.body = {k};
    contact.point = {0.1, 0.05, -0.1};
    contact.friction = 0.4;
    scene.add(contact);
  }
  return scene;
}

TEST(MergedBodies, MoveAsTheyDoHeldByTheirJoints) {
  const Mechanism scene = welded(false);
  SimulatorSettings together;
  together.tolerance = 1e-12;
  SimulatorSettings apart = together;
  apart.merge_fixed_joints = false;
  Simulator one(scene, together), three(scene, apart);
  ASSERT_EQ(one.problem_size().body_nodes, 1);
  ASSERT_EQ(three.problem_size().body_nodes, 3);
  StepRecord found, expected;
  for (int k = 1; k <= 200; ++k) {
    ASSERT_TRUE(one.step().ok() && three.step().ok()) << k;
    one.write_record(found);
    three.write_record(expected);
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_LE((found.bodies[i].position - expected.bodies[i].position).norm(), 1e-9) << "step " << k;
      ASSERT_LE(found.bodies[i].orientation.angularDistance(expected.bodies[i].orientation), 1e-8) << "step " << k;
      ASSERT_LE((found.bodies[i].velocity - expected.bodies[i].velocity).norm(), 1e-8) << "step " << k;
    }
    ASSERT_NEAR(one.energy(), three.energy(), 1e-8) << "step " << k;
    ASSERT_LE((one.angular_momentum() - three.angular_momentum()).norm(), 1e-8) << "step " << k;
  }
}

TEST(MergedBodies, TumblingOnTheGroundPassTheCertificate) {
  Simulator simulator(welded(true));
  StepRecord before, after;
  simulator.write_record(before);
  certificate::Certificate all;
  certificate::Missed missed;
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(simulator.step().ok()) << k;
    simulator.write_record(after);
    all.merge(certificate::certify_step(simulator.mechanism(), before, after, &missed));
    std::swap(before, after);
  }
  EXPECT_LE(all.residual(), 1e-8) << all;
}

/// What fixed joints hold together no other joint can close.
TEST(MergedBodies, AJointThatTheirsLeaveOpenIsRefusedByName) {
  const auto sentence = [](JointType type, const Vec3& point, const Quat& orientation) -> std::string {
    Mechanism scene = welded(false);
    Joint joint;
    joint.name = "across";
    joint.type = type;
    joint.parent = scene.joints[0].parent;
    joint.child = scene.joints[0].child;
    joint.parent_point = scene.joints[0].parent_point + point;
    joint.child_point = scene.joints[0].child_point;
    joint.orientation = scene.joints[0].orientation * orientation;
    joint.axis = point.isZero() ? joint.orientation * Vec3::UnitZ() : Vec3::UnitZ();  // across the turn; along the shift
    scene.add(joint);
    try {
      const Simulator simulator(scene);
    } catch (const DescriptionError& error) {
      return error.what();
    }
    return "taken";
  };
  const Quat none = Quat::Identity(), turned(Eigen::AngleAxisd(0.1, Vec3::UnitX()));
  EXPECT_EQ(sentence(JointType::fixed, Vec3::Zero(), none), "taken");
  EXPECT_EQ(sentence(JointType::spherical, Vec3::Zero(), none), "taken");
  EXPECT_EQ(sentence(JointType::prismatic, {0, 0, 3}, none), "taken");
  for (const JointType type : {JointType::fixed, JointType::spherical, JointType::revolute})
    EXPECT_EQ(sentence(type, {0, 0, 3}, none), "joint 'across': its points are 3 m apart, and fixed joints hold its bodies together");
  for (const JointType type : {JointType::fixed, JointType::revolute, JointType::prismatic})
    EXPECT_EQ(sentence(type, Vec3::Zero(), turned),
              "joint 'across': its bodies are 0.1 rad off its orientation, and other fixed joints hold them together");
  EXPECT_EQ(sentence(JointType::spherical, Vec3::Zero(), turned), "taken");
}

TEST(MergedBodies, ASceneWhereNothingMovesIsStepped) {
  Mechanism empty;
  empty.time_step = 0.01;
  Mechanism held = empty;
  Body body;
  body.name = "post";
  body.mass = 1;
  body.inertia = Vec3(1, 1, 1).asDiagonal();
  held.add(body);
  Joint joint;
  joint.name = "weld";
  joint.type = JointType::fixed;
  joint.child = {0};
  held.add(joint);
  for (const Mechanism& scene : {empty, held}) {
    Simulator simulator(scene);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(simulator.step().ok());
    EXPECT_EQ(simulator.energy(), 0);
  }
}

}  // namespace test_merged_bodies
