#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "physics/simulator.hpp"

namespace test_stuck_points {

/// What friction holds stays where it is while its body turns: a stuck point is a joint, and nothing is done on it.

using namespace physics;

/// A rod of 1 m that spins and falls about its lower end, which a joint or friction holds.
Mechanism falling_rod(double time_step, int directions) {
  Mechanism scene;
  scene.time_step = time_step;
  Body rod;
  rod.name = "rod";
  rod.mass = 1;
  rod.inertia = Vec3(1.0 / 12, 1.0 / 12, 1e-4).asDiagonal();
  rod.orientation = Quat(Eigen::AngleAxisd(0.2, Vec3::UnitY()));
  rod.position = rod.orientation * Vec3(0, 0, 0.5);
  const Vec3 spin(0, 0, 2);
  rod.velocity = spin.cross(rod.position);
  rod.angular_velocity = rod.orientation.conjugate() * spin;
  const BodyId id = scene.add(rod);
  if (directions > 0) {
    Contact tip;
    tip.name = "tip";
    tip.body = id;
    tip.point = {0, 0, -0.5};
    tip.friction = 1000;
    tip.directions = directions;
    scene.add(tip);
  } else {
    Joint joint;
    joint.name = "tip";
    joint.type = JointType::spherical;
    joint.child = id;
    joint.child_point = {0, 0, -0.5};
    scene.add(joint);
  }
  return scene;
}

/// 2 cm in 0.8 s at 10 ms, when slip was the velocity at the pose before the step.
TEST(StuckPoints, ARodOnItsTipMovesAsOnABallJoint) {
  for (const int directions : {4, 8})
    for (const double time_step : {0.02, 0.005}) {
      Simulator stuck(falling_rod(time_step, directions)), jointed(falling_rod(time_step, 0));
      StepRecord a, b;
      double tip = 0, apart = 0;
      for (int k = 0; k < std::lround(0.7 / time_step); ++k) {
        ASSERT_TRUE(stuck.step().ok() && jointed.step().ok());
        stuck.write_record(a);
        jointed.write_record(b);
        tip = std::max(tip, (a.bodies[0].position + a.bodies[0].orientation * Vec3(0, 0, -0.5)).norm());
        apart = std::max(apart, (a.bodies[0].position - b.bodies[0].position).norm());
      }
      EXPECT_LE(tip, 1e-10) << directions << " directions, " << time_step << " s";
      EXPECT_LE(apart, 1e-8) << directions << " directions, " << time_step << " s";
      EXPECT_GT((a.bodies[0].position - Vec3(0, 0, 0.5)).norm(), 0.3) << "it has fallen";
    }
}

/// Over its lower edge, two corners of it, friction within its bound: the edge crept 2.6 mm at 10 ms.
TEST(StuckPoints, AColumnThatTipsKeepsItsEdge) {
  Mechanism scene;
  scene.time_step = 0.01;
  Body column;
  column.name = "column";
  column.mass = 1;
  column.inertia = Vec3(1.04 / 12, 1.04 / 12, 0.08 / 12).asDiagonal();
  const Quat turned(Eigen::AngleAxisd(0.7, Vec3::UnitZ()));
  column.orientation = turned * Quat(Eigen::AngleAxisd(std::atan(0.2) + 0.05, Vec3::UnitY()));
  column.position = -(column.orientation * Vec3(0.1, 0, -0.5));
  const BodyId id = scene.add(column);
  for (const double x : {0.1, -0.1})
    for (const double y : {-0.1, 0.1}) {
      Contact corner;
      corner.name = "corner " + std::to_string(scene.contacts.size());
      corner.body = id;
      corner.point = {x, y, -0.5};
      corner.friction = 1;
      scene.add(corner);
    }
  Simulator simulator(scene);
  StepRecord record;
  double tilt = 0;
  while (tilt < 1) {
    ASSERT_TRUE(simulator.step().ok());
    ASSERT_LT(simulator.time(), 3);
    simulator.write_record(record);
    tilt = std::acos((record.bodies[0].orientation * Vec3::UnitZ()).z());
    const Vec3 edge = record.bodies[0].position + record.bodies[0].orientation * Vec3(0.1, 0, -0.5);
    EXPECT_LE(edge.norm(), 1e-8) << "at " << simulator.time() << " s";
  }
}

/// An eccentric sphere rocks without slip for ever; with the velocity at the pose before the step it gained energy, passed
/// over its heavy side and rolled away. The bound is on a swing that comes back, second order in the time step.
TEST(StuckPoints, ARockingEggKeepsItsEnergy) {
  for (const double time_step : {0.01, 0.005}) {
    Mechanism scene;
    scene.time_step = time_step;
    Body egg;
    egg.name = "egg";
    egg.mass = 1;
    egg.inertia = 0.016 * Mat3::Identity();
    egg.orientation = Quat(0.315322362395, 0.948984619356, 0, 0).normalized();
    egg.position = {0, 0, 0.264109149243};
    const BodyId id = scene.add(egg);
    Contact shell;
    shell.name = "shell";
    shell.body = id;
    shell.point = {0, 0, 0.08};
    shell.radius = 0.2;
    shell.friction = 2;
    scene.add(shell);
    Simulator simulator(scene);
    ASSERT_TRUE(simulator.step().ok());
    const double start = simulator.energy();
    double most = 0;
    while (simulator.time() < 30) {
      ASSERT_TRUE(simulator.step().ok());
      most = std::max(most, std::abs(simulator.energy() - start));
    }
    std::printf("             %.3f s: energy off by %.1e of %.2f J at most\n", time_step, most, start);
    EXPECT_LE(most, 60 * time_step * time_step);
    StepRecord record;
    simulator.write_record(record);
    EXPECT_LE(record.bodies[0].position.head<2>().norm(), 0.5);
  }
}

}  // namespace test_stuck_points
