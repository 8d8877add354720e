// Keys of variations for loads, motors, and joints and bodies at the start: what they set, and that no joint opens.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "physics/batch_variation.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_variation_keys {

using namespace physics;

template <class Things>
auto& named(Things& things, const std::string& name) {
  return *std::find_if(things.begin(), things.end(), [&](const auto& thing) { return thing.name == name; });
}

std::string refusal(Mechanism scene, const std::string& key, double value = 0.1) {
  try {
    set_value(scene, key, value);
    validate(scene);
  } catch (const DescriptionError& error) {
    return error.what();
  }
  return "";
}

struct Frame {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero(), w = Vec3::Zero();  ///< w in the world
  Quat q = Quat::Identity();
};
Frame frame(const Mechanism& scene, BodyId id) {
  if (id.is_world()) return {};
  const Body& body = scene.bodies[id.index];
  return {body.position, body.velocity, body.orientation * body.angular_velocity, body.orientation};
}

/// Of a revolute joint, from the directions that it joins.
double angle(const Mechanism& scene, const Joint& joint) {
  const Frame a = frame(scene, joint.parent), b = frame(scene, joint.child);
  const Vec3 across = joint.axis.unitOrthogonal();
  const Vec3 turned = a.q.conjugate() * (b.q * (joint.orientation.conjugate() * across));
  return std::atan2(joint.axis.dot(across.cross(turned)), across.dot(turned));
}
double rate(const Mechanism& scene, const Joint& joint) {
  const Frame a = frame(scene, joint.parent), b = frame(scene, joint.child);
  return (a.q * joint.axis).dot(b.w - a.w);
}

/// Everything turns as one, besides what its joints do.
void spin(Mechanism& scene, const Vec3& w) {
  const Vec3 origin = scene.bodies[0].position;
  for (Body& body : scene.bodies) {
    body.velocity += w.cross(body.position - origin);
    body.angular_velocity += body.orientation.conjugate() * w;
  }
}

void expect_closed(const Mechanism& scene, const std::string& what) {
  const Simulator simulator(scene);
  EXPECT_LT(simulator.largest_joint_error(), 1e-13) << what;
  EXPECT_LT(simulator.start_correction(), 1e-12) << what;
}

/// Turns about several of its joints and as a whole, so that velocities that were left behind show.
Mechanism moving_quadruped() {
  Mechanism scene = built_in_scene("quadruped");
  spin(scene, {0.3, -0.5, 0.7});
  set_value(scene, "start.velocity.x", 0.4);
  set_value(scene, "start.front left hip joint.rate", 1.5);
  set_value(scene, "start.front left thigh joint.rate", -2);
  set_value(scene, "start.rear right calf joint.rate", 3);
  return scene;
}

TEST(VariationKeys, ForcesAndTorquesAreLoadsBesideThoseThatAreThere) {
  Mechanism scene = built_in_scene("quadruped");
  set_value(scene, "trunk.force.y", 7);
  set_value(scene, "front left calf.torque.z@20-40", -3);
  ASSERT_EQ(scene.loads.size(), 2u);
  EXPECT_EQ(scene.loads[0].body, BodyId{0});
  EXPECT_EQ(scene.loads[0].force, Vec3(0, 7, 0));
  EXPECT_EQ(scene.loads[0].torque, Vec3(0, 0, 0));
  EXPECT_EQ(scene.loads[0].first_step, 1);
  EXPECT_EQ(scene.loads[0].last_step, std::numeric_limits<int>::max());
  EXPECT_EQ(scene.bodies[scene.loads[1].body.index].name, "front left calf");
  EXPECT_EQ(scene.loads[1].force, Vec3(0, 0, 0));
  EXPECT_EQ(scene.loads[1].torque, Vec3(0, 0, -3));
  EXPECT_EQ(scene.loads[1].first_step, 20);
  EXPECT_EQ(scene.loads[1].last_step, 40);
  set_value(scene, "loads", 2);
  set_value(scene, "trunk.loads", 3);
  EXPECT_EQ(scene.loads[0].force, Vec3(0, 42, 0));
  EXPECT_EQ(scene.loads[1].torque, Vec3(0, 0, -6));
}

TEST(VariationKeys, APushOfThreeStepsAddsItsImpulse) {
  Mechanism scene = built_in_scene("free_box");
  const auto momentum = [](const Mechanism& mechanism) {
    Simulator simulator(mechanism);
    for (int i = 0; i < 8; ++i) EXPECT_TRUE(simulator.step().ok());
    return simulator.linear_momentum();
  };
  const Vec3 before = momentum(scene);
  set_value(scene, scene.bodies[0].name + ".force.y@3-5", 6);
  const Vec3 gained = momentum(scene) - before;
  EXPECT_NEAR(gained.y(), 3 * scene.time_step * 6, 1e-12);
  EXPECT_NEAR(gained.x(), 0, 1e-12);
}

TEST(VariationKeys, MotorsTakeLimitsAndTargets) {
  Mechanism scene = built_in_scene("quadruped");
  Motor& hip = *named(scene.joints, "front left hip joint").motor;
  Motor& thigh = *named(scene.joints, "front left thigh joint").motor;
  const SineTarget before = std::get<SineTarget>(thigh.target);
  set_value(scene, "front left hip joint.limit", 12);
  EXPECT_EQ(hip.limit, 12);
  set_value(scene, "front left hip joint.target", 0.2);
  EXPECT_EQ(std::get<double>(hip.target), 0.2);
  set_value(scene, "front left thigh joint.target.offset", 0.9);
  set_value(scene, "front left thigh joint.target.phase", 0.4);
  SineTarget now = std::get<SineTarget>(thigh.target);
  EXPECT_EQ(now.offset, 0.9);
  EXPECT_EQ(now.phase, 0.4);
  EXPECT_EQ(now.amplitude, before.amplitude);
  EXPECT_EQ(now.frequency, before.frequency);
  set_value(scene, "front left thigh joint.target.amplitude", 0.05);
  set_value(scene, "front left thigh joint.target.frequency", 2);
  now = std::get<SineTarget>(thigh.target);
  EXPECT_EQ(now.amplitude, 0.05);
  EXPECT_EQ(now.frequency, 2);
}

TEST(VariationKeys, ABodyTurnsWithAllThatIsJoinedToIt) {
  const Mechanism before = moving_quadruped();
  Mechanism scene = before;
  set_value(scene, "start.trunk.rotation.z", 1.2);
  set_value(scene, "start.trunk.rotation.x", -0.4);
  const Quat turn = Quat(Eigen::AngleAxisd(-0.4, Vec3::UnitX())) * Quat(Eigen::AngleAxisd(1.2, Vec3::UnitZ()));
  const Frame trunk = frame(before, {0});
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Frame was = frame(before, {i}), is = frame(scene, {i});
    EXPECT_LT((is.x - trunk.x - turn * (was.x - trunk.x)).norm(), 1e-14) << i;
    EXPECT_LT(is.q.angularDistance(turn * was.q), 1e-14) << i;
    EXPECT_LT((is.w - turn * was.w).norm(), 1e-14) << i;
    EXPECT_LT((is.v - trunk.v - turn * (was.v - trunk.v)).norm(), 1e-14) << i;
  }
  EXPECT_EQ(scene.bodies[0].velocity, before.bodies[0].velocity);
  expect_closed(scene, "turned");
}

TEST(VariationKeys, AJointStartsAtItsAngleAndRateAndNoOtherMoves) {
  const Mechanism before = moving_quadruped();
  for (const double wanted : {-3.1, -0.7, 0.0, 2.5, std::numbers::pi}) {
    Mechanism scene = before;
    set_value(scene, "start.front left hip joint.angle", wanted);
    set_value(scene, "start.rear right calf joint.rate", 4);  // which had another
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const double expected = joint.name == "front left hip joint" ? wanted : angle(before, joint);
      EXPECT_LT(std::abs(std::remainder(angle(scene, joint) - expected, 2 * std::numbers::pi)), 1e-14) << joint.name;
      EXPECT_NEAR(rate(scene, joint), joint.name == "rear right calf joint" ? 4 : rate(before, joint), 1e-13) << joint.name;
    }
    EXPECT_EQ(scene.bodies[0].position, before.bodies[0].position) << "the parent's side stays";
    expect_closed(scene, "angle " + std::to_string(wanted));
  }
}

TEST(VariationKeys, WhereTheChildIsHeldTheParentMoves) {
  Mechanism scene = built_in_scene("pendulum:n=3,joint=revolute");
  Joint& joint = scene.joints[2];
  ASSERT_EQ(joint.parent, BodyId{1});
  std::swap(joint.parent, joint.child);
  std::swap(joint.parent_point, joint.child_point);
  joint.orientation = joint.orientation.conjugate();
  set_value(scene, "start." + scene.joints[0].name + ".rate", 2);  // the child moves, and the parent otherwise
  set_value(scene, "start." + joint.name + ".rate", 0.7);
  const Mechanism before = scene;
  set_value(scene, "start." + joint.name + ".angle", 0.6);
  set_value(scene, "start." + joint.name + ".rate", -1.5);
  EXPECT_NEAR(angle(scene, scene.joints[2]), 0.6, 1e-14);
  EXPECT_NEAR(rate(scene, scene.joints[2]), -1.5, 1e-14);
  EXPECT_EQ(scene.bodies[1].position, before.bodies[1].position);
  EXPECT_GT((scene.bodies[2].position - before.bodies[2].position).norm(), 0.1);
  expect_closed(scene, "swapped");
}

TEST(VariationKeys, SphericalJointsTurnAboutAxesOfTheParent) {
  Mechanism scene = built_in_scene("snake:n=4");
  spin(scene, {0.2, 0.4, -0.3});
  const std::string name = scene.joints[1].name;
  const BodyId parent = scene.joints[1].parent, child = scene.joints[1].child;
  const Frame a = frame(scene, parent), was = frame(scene, child);
  set_value(scene, "start." + name + ".angle.y", 0.8);
  set_value(scene, "start." + name + ".rate.x", 2);
  const Frame is = frame(scene, child);
  const Vec3 axis = a.q * Vec3::UnitY();
  EXPECT_LT(is.q.angularDistance(Quat(Eigen::AngleAxisd(0.8, axis)) * was.q), 1e-14);
  EXPECT_NEAR((a.q * Vec3::UnitX()).dot(is.w - a.w), 2, 1e-14);
  expect_closed(scene, "snake");
}

TEST(VariationKeys, ASliderStartsAtItsTravelAndRateOnABodyThatTurns) {
  Mechanism scene;
  Body carrier{.name = "carrier", .mass = 2, .inertia = Mat3::Identity()};
  carrier.orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 2) / 3));
  carrier.velocity = {1, 0, 0};
  carrier.angular_velocity = {0.5, -1, 2};
  Body slide{.name = "slide", .mass = 1, .inertia = Mat3::Identity()};
  slide.orientation = carrier.orientation;
  slide.angular_velocity = carrier.angular_velocity;
  const Vec3 on_carrier(1, 0, 0.5), on_slide(0, 0.2, 0), offset = carrier.orientation * (on_carrier - on_slide);
  slide.position = offset;
  slide.velocity = carrier.velocity + (carrier.orientation * carrier.angular_velocity).cross(offset);
  Joint joint{.name = "rail", .type = JointType::prismatic, .parent = scene.add(carrier), .child = scene.add(slide)};
  joint.parent_point = on_carrier;
  joint.child_point = on_slide;
  joint.axis = Vec3(0, 3, 4);
  scene.add(joint);
  for (const bool rate_first : {false, true}) {
    Mechanism copy = scene;
    if (rate_first) set_value(copy, "start.rail.rate", 1.25);
    set_value(copy, "start.rail.travel", 0.5);
    set_value(copy, "start.rail.travel", 0.3);
    if (!rate_first) set_value(copy, "start.rail.rate", 1.25);
    const Frame a = frame(copy, {0}), b = frame(copy, {1});
    const Vec3 axis = a.q * Vec3(0, 0.6, 0.8);
    EXPECT_LT((b.x - a.x - offset - 0.3 * axis).norm(), 1e-14) << rate_first;
    EXPECT_LT((b.v - a.v - a.w.cross(b.x - a.x) - 1.25 * axis).norm(), 1e-14) << rate_first;
    expect_closed(copy, "rail");
  }
}

TEST(VariationKeys, WhatNamesNothingOrMakesNoSenseIsOneSentence) {
  const Mechanism quadruped = built_in_scene("quadruped"), pendulum = built_in_scene("pendulum:n=2,joint=revolute"),
                  snake = built_in_scene("snake:n=3"), four_bar = built_in_scene("four_bar");
  EXPECT_EQ(refusal(quadruped, "wheel.force.x"), "vary 'wheel.force.x': the scene has no body 'wheel'");
  for (const std::string steps : {"@0-5", "@7-5", "@5", "@5-", "@-5", "@a-b", "@1-2c", "@1-99999999999"})
    EXPECT_EQ(refusal(quadruped, "trunk.force.x" + steps),
              "vary 'trunk.force.x" + steps + "': '" + steps + "' is not @FIRST-LAST with steps 1 <= FIRST <= LAST");
  EXPECT_EQ(refusal(quadruped, "loads"), "vary 'loads': the scene has no loads: vary BODY.force.x to add one");
  EXPECT_EQ(refusal(quadruped, "trunk.loads"),
            "vary 'trunk.loads': the scene has no load on body 'trunk': vary trunk.force.x to add one");
  EXPECT_EQ(refusal(snake, "joint 1.target"), "vary 'joint 1.target': joint 'joint 1' has no motor");
  EXPECT_EQ(refusal(snake, "joint 1.limit"), "vary 'joint 1.limit': joint 'joint 1' has no motor");
  EXPECT_EQ(refusal(snake, "joint 9.target.offset"), "vary 'joint 9.target.offset': the scene has no joint 'joint 9'");
  const std::string thigh = "front left thigh joint", hip = "front left hip joint";
  EXPECT_EQ(refusal(quadruped, thigh + ".target"), "vary '" + thigh + ".target': the target of joint '" + thigh +
                                                       "' is a sine: vary " + thigh +
                                                       ".target.offset, .amplitude, .frequency or .phase");
  EXPECT_EQ(refusal(quadruped, hip + ".target.phase"),
            "vary '" + hip + ".target.phase': the target of joint '" + hip + "' is no sine");
  EXPECT_EQ(refusal(quadruped, hip + ".limit", 0), "revolute joint '" + hip + "': motor limit 0 is not > 0");
  Mechanism with_table = quadruped;
  named(with_table.joints, hip).motor->target = TableTarget{{0, 0}, {1, 1}};
  EXPECT_EQ(refusal(with_table, hip + ".target"), "vary '" + hip + ".target': the target of joint '" + hip + "' is a table");

  const std::string joint = pendulum.joints[1].name, body = pendulum.bodies[1].name;
  EXPECT_EQ(refusal(pendulum, "start." + body + ".rotation.x"),
            "vary 'start." + body + ".rotation.x': joints hold body '" + body +
                "' at the world, and a turn would open them: vary start.JOINT.angle");
  EXPECT_EQ(refusal(pendulum, "start." + joint + ".angle", 3.2), "joint '" + joint + "': start angle 3.2 rad is not from -pi to pi");
  EXPECT_EQ(refusal(pendulum, "start." + joint + ".travel"),
            "vary 'start." + joint + ".travel': joint '" + joint + "' is not prismatic: vary start." + joint + ".angle");
  EXPECT_EQ(refusal(pendulum, "start." + joint + ".angle.x"),
            "vary 'start." + joint + ".angle.x': joint '" + joint + "' has one axis: leave out .x");
  EXPECT_EQ(refusal(snake, "start.joint 1.angle"),
            "vary 'start.joint 1.angle': joint 'joint 1' is spherical: the key needs an axis, as in start.joint 1.angle.x");
  Mechanism other = pendulum;
  other.joints[1].type = JointType::fixed;
  EXPECT_EQ(refusal(other, "start." + joint + ".rate"), "vary 'start." + joint + ".rate': joint '" + joint + "' is fixed");
  other.joints[1].type = JointType::prismatic;
  EXPECT_EQ(refusal(other, "start." + joint + ".angle"),
            "vary 'start." + joint + ".angle': joint '" + joint + "' is prismatic: vary start." + joint + ".travel");
  for (const Joint& closed : four_bar.joints)
    EXPECT_EQ(refusal(four_bar, "start." + closed.name + ".angle"),
              "vary 'start." + closed.name + ".angle': joint '" + closed.name +
                  "' is part of a closed loop, which another start would open");
  Mechanism floating = built_in_scene("loop:n=5");
  std::erase_if(floating.joints, [](const Joint& j) { return j.parent.is_world(); });
  const std::string any = floating.joints[1].name;
  EXPECT_EQ(refusal(floating, "start." + any + ".angle.y"),
            "vary 'start." + any + ".angle.y': joint '" + any + "' is part of a closed loop, which another start would open");
  for (const char* key : {"start.trunk.rotation", "trunk.force", "trunk.force.w", "start.rotation.x", "trunk.mass@1-2"})
    EXPECT_NE(refusal(quadruped, key).find("unknown key; there are: friction"), std::string::npos) << key;
}

}  // namespace test_variation_keys
