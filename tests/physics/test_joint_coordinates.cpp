// Coordinates and rates of joints against closed forms, in space: what they count, from where and in which sense.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>

#include "physics/batch_simulator.hpp"
#include "physics/batch_variation.hpp"
#include "physics/run.hpp"
#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_joint_coordinates {

using namespace physics;

constexpr double turn = 2 * std::numbers::pi;

SimulatorSettings counting_turns() {
  SimulatorSettings settings;
  settings.count_turns = true;
  return settings;
}

Quat about(const Vec3& axis, double angle) { return Quat(Eigen::AngleAxisd(angle, axis.normalized())); }

Body ball(const char* name, double mass, double inertia) {
  Body body;
  body.name = name;
  body.mass = mass;
  body.inertia = inertia * Mat3::Identity();
  return body;
}

/// Two bodies of spherical inertia about one centre, hinged about an axis askew to everything, tumbling freely. Nothing
/// twists the hinge: the angular momentum L stays, both turn with (L - J_child rate axis) / (J + J_child) and the child
/// with rate about the axis besides. The axis goes round L, its angle to it stays, and with it the rate: angle + rate t.
struct TumblingHinge {
  double angle = 0.7, rate = 5;
  [[nodiscard]] Mechanism scene(double dt) const {
    Mechanism scene;
    scene.time_step = dt;
    scene.gravity = Vec3::Zero();
    Body wheel = ball("wheel", 3, 0.3), vane = ball("vane", 1, 0.2);
    Joint hinge;
    hinge.name = "hinge";
    hinge.type = JointType::revolute;
    hinge.axis = Vec3(1, -2, 0.5).normalized();
    hinge.orientation = about({0.3, 1, -2}, 1.3);
    wheel.orientation = about({2, 1, -1}, 2.1);
    vane.orientation = wheel.orientation * about(hinge.axis, angle) * hinge.orientation;
    const Vec3 spin(0.8, -0.5, 1.1), axis = wheel.orientation * hinge.axis;
    wheel.angular_velocity = wheel.orientation.conjugate() * spin;
    vane.angular_velocity = vane.orientation.conjugate() * (spin + rate * axis);
    wheel.velocity = vane.velocity = {0.2, 0.1, -0.3};
    hinge.parent = scene.add(wheel);
    hinge.child = scene.add(vane);
    scene.add(hinge);
    return scene;
  }
};

/// From -pi to pi, by a direction of each body that are the same at rest.
double angle_between(const Mechanism& scene, const StepRecord& record) {
  const Joint& joint = scene.joints[0];
  const Quat parent = record.bodies[0].orientation, child = record.bodies[1].orientation;
  const Vec3 across = joint.axis.unitOrthogonal();
  const Vec3 of_parent = parent * across, of_child = child * (joint.orientation.conjugate() * across);
  return std::atan2((parent * joint.axis).dot(of_parent.cross(of_child)), of_parent.dot(of_child));
}

double largest_deviation(const TumblingHinge& hinge, double dt, double duration) {
  Simulator simulator(hinge.scene(dt), counting_turns());
  double largest = 0;
  while (simulator.time() < duration - 0.5 * dt) {
    if (!simulator.step().ok()) throw std::runtime_error("a step was not solved");
    const double expected = hinge.angle + hinge.rate * simulator.time();
    largest = std::max(largest, std::abs(*simulator.joint_coordinate(0) - expected));
    largest = std::max(largest, std::abs(*simulator.joint_rate(0) - hinge.rate));
  }
  return largest;
}

TEST(JointCoordinates, AHingeAskewOnATumblingBodyTurnsAtTheRateOfTheClosedForm) {
  for (const double rate : {5.0, -5.0}) {
    const TumblingHinge hinge{.angle = 0.7, .rate = rate};
    const double coarse = largest_deviation(hinge, 0.004, 4), fine = largest_deviation(hinge, 0.002, 4);  // three turns
    EXPECT_LT(fine, 2e-3) << rate;
    EXPECT_NEAR(coarse / fine, 4, 0.2) << rate;
  }
}

TEST(JointCoordinates, AreTheAngleThatThePosesShowAndItsChangeInTheStep) {
  const Mechanism scene = TumblingHinge{}.scene(0.01);
  Simulator counting(scene, counting_turns()), plain(scene);
  StepRecord record;
  double before = *counting.joint_coordinate(0);
  EXPECT_NEAR(before, 0.7, 1e-15);
  EXPECT_NEAR(*counting.joint_rate(0), 5, 1e-14);
  for (int k = 0; k < 400; ++k) {
    ASSERT_TRUE(counting.step().ok() && plain.step().ok());
    counting.write_record(record);
    const double angle = *record.joints[0].coordinate, rest = *plain.joint_coordinate(0);
    EXPECT_NEAR(std::remainder(angle - angle_between(scene, record), turn), 0, 1e-13);
    EXPECT_NEAR(*record.joints[0].rate, (angle - before) / scene.time_step, 1e-11);
    EXPECT_LE(std::abs(rest), std::numbers::pi);
    EXPECT_NEAR(std::remainder(angle - rest, turn), 0, 1e-13);
    EXPECT_EQ(*plain.joint_rate(0), *record.joints[0].rate);
    before = angle;
  }
  EXPECT_GT(before, 3 * turn);
}

/// A bead on a rod that tumbles end over end, both of spherical inertia, the bead's travel s along an axis askew through
/// both centres. With r = s + offset, J the sum of inertias and mu the reduced mass, L = (J + mu r^2) w and
/// 2 E = mu s'^2 + L^2 / (J + mu r^2) stay.
struct BeadOnARod {
  static constexpr double offset = 0.1, travel = 0.5, rate = -0.6, spin = 1.5, inertia = 0.3, mass = 2.0 / 3;
  [[nodiscard]] static Mechanism scene(double dt) {
    Mechanism scene;
    scene.time_step = dt;
    scene.gravity = Vec3::Zero();
    Body rod = ball("rod", 2, 0.2), bead = ball("bead", 1, 0.1);
    Joint guide;
    guide.name = "guide";
    guide.type = JointType::prismatic;
    guide.axis = Vec3(1, 2, -1).normalized();
    guide.parent_point = offset * guide.axis;
    guide.orientation = about({1, 0, 2}, 0.8);
    rod.position = {1, -2, 0.5};
    rod.orientation = about({-1, 1, 3}, 1.9);
    bead.orientation = rod.orientation * guide.orientation;
    const Vec3 axis = rod.orientation * guide.axis, turning = spin * axis.unitOrthogonal();
    bead.position = rod.position + (offset + travel) * axis;
    rod.velocity = {0.3, 0.2, -0.1};
    bead.velocity = rod.velocity + turning.cross(bead.position - rod.position) + rate * axis;
    for (Body* body : {&rod, &bead}) body->angular_velocity = body->orientation.conjugate() * turning;
    guide.parent = scene.add(rod);
    guide.child = scene.add(bead);
    scene.add(guide);
    return scene;
  }
  [[nodiscard]] static double inertia_at(double s) { return inertia + mass * (s + offset) * (s + offset); }
  [[nodiscard]] static double rate_squared(double s) {
    const double momentum = inertia_at(travel) * spin;
    return rate * rate + (momentum * spin - momentum * momentum / inertia_at(s)) / mass;
  }
};

TEST(JointCoordinates, ABeadOnATumblingRodKeepsEnergyAndMomentum) {
  double deviation[2] = {0, 0};
  for (const int fine : {0, 1}) {
    const double dt = fine ? 0.002 : 0.004;
    Simulator simulator(BeadOnARod::scene(dt));
    double before = *simulator.joint_coordinate(0);
    EXPECT_NEAR(before, BeadOnARod::travel, 1e-15);
    EXPECT_NEAR(*simulator.joint_rate(0), BeadOnARod::rate, 1e-15);
    bool inwards = false, outwards = false;
    while (simulator.time() < 2) {
      ASSERT_TRUE(simulator.step().ok());
      const double s = *simulator.joint_coordinate(0), rate = *simulator.joint_rate(0);
      ASSERT_NEAR(rate, (s - before) / dt, 1e-11);
      deviation[fine] = std::max(deviation[fine], std::abs(rate * rate - BeadOnARod::rate_squared(0.5 * (s + before))));
      (rate < 0 ? inwards : outwards) = true;
      before = s;
    }
    EXPECT_TRUE(inwards && outwards);
  }
  EXPECT_LT(deviation[1], 1e-5);
  EXPECT_NEAR(deviation[0] / deviation[1], 4, 0.4);
}

TEST(JointCoordinates, CountWhatStartKeysSet) {
  Mechanism hinge = TumblingHinge{}.scene(0.01), bead = BeadOnARod::scene(0.01);
  for (const double angle : {-3.0, -0.4, 0.0, 2.5}) {
    set_value(hinge, "start.hinge.angle", angle);
    set_value(hinge, "start.hinge.rate", 2 * angle);
    const Simulator simulator(hinge);
    EXPECT_NEAR(*simulator.joint_coordinate(0), angle, 1e-14);
    EXPECT_NEAR(*simulator.joint_rate(0), 2 * angle, 1e-13);
    set_value(bead, "start.guide.travel", angle);
    set_value(bead, "start.guide.rate", 2 * angle);
    const Simulator sliding(bead);
    EXPECT_NEAR(*sliding.joint_coordinate(0), angle, 1e-14);
    EXPECT_NEAR(*sliding.joint_rate(0), 2 * angle, 1e-13);
  }
}

TEST(JointCoordinates, AMotorsEffortIsItsLawOfThem) {
  for (const bool slides : {false, true}) {
    Mechanism scene = slides ? BeadOnARod::scene(0.01) : TumblingHinge{}.scene(0.01);
    const Motor motor{.stiffness = 4, .damping = 0.3, .target = TableTarget{{0, 0}, {2, slides ? 0.4 : 20.0}}};
    scene.joints[0].motor = motor;
    Simulator simulator(scene);
    StepRecord record;
    for (int k = 1; k <= 200; ++k) {
      ASSERT_TRUE(simulator.step().ok());
      simulator.write_record(record);
      const JointRecord& joint = record.joints[0];
      const double target = (slides ? 0.2 : 10.0) * record.time;
      EXPECT_NEAR(*joint.effort, motor.stiffness * (target - *joint.coordinate) - motor.damping * *joint.rate, 1e-6) << k;
      EXPECT_GT(std::abs(*joint.effort), 0);
    }
    if (slides) continue;
    EXPECT_GT(*record.joints[0].coordinate, 2 * turn) << "turns are counted without being asked for";
  }
}

TEST(JointCoordinates, ARecordTellsTheTurnsToTheRunThatGoesOnFromIt) {
  for (const bool driven : {false, true}) {
    Mechanism scene = TumblingHinge{}.scene(0.01);
    if (driven) scene.joints[0].motor = Motor{.damping = 0.001};  // without a spring, which could tell
    Simulator whole(scene, counting_turns());
    StepRecord record;
    for (int k = 0; k < 300; ++k) ASSERT_TRUE(whole.step().ok());
    whole.write_record(record);
    ASSERT_GT(*record.joints[0].coordinate, 2 * turn);
    Simulator continued(scene, counting_turns());
    continued.restart_from(record);
    EXPECT_NEAR(*continued.joint_coordinate(0), *record.joints[0].coordinate, 1e-13);
    EXPECT_NEAR(*continued.joint_rate(0), *record.joints[0].rate, 1e-11);
    for (int k = 0; k < 50; ++k) {
      ASSERT_TRUE(whole.step().ok() && continued.step().ok());
      EXPECT_NEAR(*continued.joint_coordinate(0), *whole.joint_coordinate(0), 1e-9);
    }
    record.joints[0].coordinate = NAN;
    EXPECT_THROW(continued.restart_from(record), DescriptionError);
  }
}

TEST(JointCoordinates, AreOfRevoluteAndPrismaticJointsThatMove) {
  Mechanism scene = TumblingHinge{}.scene(0.01);
  const auto join = [&](const char* name, JointType type, BodyId parent, BodyId child) {
    Joint joint;
    joint.name = name;
    joint.type = type;
    joint.parent = parent;
    joint.child = child;
    scene.add(joint);
  };
  const BodyId hung = scene.add(ball("hung", 1, 0.1)), plate = scene.add(ball("plate", 1, 0.1));
  scene.bodies[hung.index].position = scene.bodies[plate.index].position = {5, 0, 0};
  scene.joints.insert(scene.joints.begin(), Joint{});
  scene.joints[0].name = "ball joint";
  scene.joints[0].type = JointType::spherical;
  scene.joints[0].child = hung;
  scene.joints[0].parent_point = {5, 0, 0};
  join("bolt", JointType::fixed, hung, plate);
  join("seized", JointType::revolute, hung, plate);
  Simulator simulator(scene);
  BatchSimulator batch(scene, 3, counting_turns());
  for (int k = 0; k < 5; ++k) {
    ASSERT_TRUE(simulator.step().ok());
    batch.step();
  }
  StepRecord record;
  simulator.write_record(record);
  for (const int joint : {0, 2, 3}) {
    EXPECT_FALSE(simulator.joint_coordinate(joint) || simulator.joint_rate(joint)) << joint;
    EXPECT_FALSE(record.joints[joint].coordinate || record.joints[joint].rate) << joint;
  }
  EXPECT_EQ(*simulator.joint_coordinate(1), *record.joints[1].coordinate);
  EXPECT_EQ(*batch.joint_coordinate(2, 1), *record.joints[1].coordinate);
  EXPECT_EQ(*batch.joint_rate(2, 1), *record.joints[1].rate);
  for (const int none : {-1, 4}) EXPECT_THROW((void)simulator.joint_coordinate(none), std::out_of_range);
}

TEST(JointCoordinates, StandInTrajectories) {
  const Mechanism scene = TumblingHinge{}.scene(0.01);
  Trajectory trajectory{scene, {}};
  Simulator simulator(scene, counting_turns());
  (void)run(simulator, 200, {.on_step = {}, .record = [&](const StepRecord& r) { trajectory.steps.push_back(r); }});
  std::ostringstream json, csv;
  write_trajectory_json(trajectory, json);
  const Trajectory read = parse_scene_json(json.str());
  for (std::size_t k = 0; k < read.steps.size(); ++k) {
    EXPECT_EQ(read.steps[k].joints[0].coordinate, trajectory.steps[k].joints[0].coordinate);
    EXPECT_EQ(read.steps[k].joints[0].rate, trajectory.steps[k].joints[0].rate);
  }
  write_trajectory_csv(trajectory, csv);
  EXPECT_NE(csv.str().find(",hinge.effort,hinge.coordinate,hinge.rate,solver.status"), std::string::npos);
}

}  // namespace test_joint_coordinates
