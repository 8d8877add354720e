// Forces that change a velocity by less than the tolerance in a step: nobody may lose them.

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_weak_forces {

using namespace physics;

Mechanism one_body(double mass, const Vec3& inertia, double time_step) {
  Mechanism scene;
  scene.time_step = time_step;
  scene.start = Start::half_kick;
  Body body;
  body.name = "body";
  body.mass = mass;
  body.inertia = inertia.asDiagonal();
  scene.add(body);
  return scene;
}

void push(Mechanism& scene, const Vec3& force) {
  Load load;
  load.body = {0};
  load.last_step = std::numeric_limits<int>::max();
  load.force = force;
  scene.loads.push_back(load);
}

Vec3 position_after(Simulator& simulator, int steps) {
  for (int k = 0; k < steps; ++k)
    if (!simulator.step().ok()) throw std::runtime_error("step " + std::to_string(k + 1));
  StepRecord record;
  simulator.write_record(record);
  return record.bodies[0].position;
}

/// 9e-9 m/s per step, below the tolerance of 1e-8.
TEST(WeakForces, MoveACartOnItsRail) {
  Mechanism scene = one_body(1, {0.1, 0.1, 0.1}, 1e-4);
  Joint rail;
  rail.name = "rail";
  rail.type = JointType::prismatic;
  rail.child = {0};
  rail.axis = Vec3::UnitX();
  scene.add(rail);
  push(scene, {9e-5, 0, 0});
  Simulator simulator(scene);
  const double t = 1;
  EXPECT_NEAR(position_after(simulator, 10000).x(), 9e-5 * t * t / 2, 1e-9);
}

TEST(WeakForces, MoveASatellite) {
  Mechanism scene = one_body(100, {10, 10, 10}, 1e-3);
  scene.gravity = Vec3::Zero();
  push(scene, {0, 9e-4, 0});
  Simulator simulator(scene);
  const double t = 10;
  EXPECT_NEAR(position_after(simulator, 10000).y(), 9e-6 * t * t / 2, 1e-8);
}

/// Its gyroscopic torque turns it by less than the tolerance in a step; without it angular momentum would turn with the body.
TEST(WeakForces, KeepTheAngularMomentumOfASlowTop) {
  Mechanism scene = one_body(1, {0.05, 0.1, 0.12}, 1e-3);
  scene.gravity = Vec3::Zero();
  scene.bodies[0].angular_velocity = {0.006, 0.006, 0.005};
  Simulator simulator(scene);
  const Vec3 before = simulator.angular_momentum();
  (void)position_after(simulator, 20000);
  EXPECT_LE((simulator.angular_momentum() - before).norm(), 1e-4 * before.norm());
}

/// What a step misses, the next one makes good: velocities are off by a tolerance, not by one for every step.
constexpr double tolerance = 1e-8;

Contact on_the_ground(const std::string& name, const Vec3& point, double radius, double friction) {
  Contact contact;
  contact.name = name;
  contact.body = {0};
  contact.point = point;
  contact.radius = radius;
  contact.friction = friction;
  return contact;
}

TEST(WeakForces, MoveABoxOnIce) {
  Mechanism scene = one_body(1, {0.1, 0.1, 0.1}, 1e-4);
  scene.bodies[0].position = {0, 0, 0.5};
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) scene.contacts.push_back(on_the_ground(std::to_string(x) + std::to_string(y), {x, y, -0.5}, 0, 0));
  push(scene, {7e-5, 5e-5, 0});
  Simulator simulator(scene);
  const double t = 1;
  const Vec3 there = position_after(simulator, 10000);
  EXPECT_NEAR(there.x(), 7e-5 * t * t / 2, tolerance * t);
  EXPECT_NEAR(there.y(), 5e-5 * t * t / 2, tolerance * t);
}

/// A record tells what its step missed: also a run that goes on from the one of every step gets somewhere.
TEST(WeakForces, MoveABoxOnIceFromRecordToRecord) {
  Mechanism scene = one_body(1, {0.1, 0.1, 0.1}, 1e-4);
  scene.start = Start::standard;
  scene.bodies[0].position = {0, 0, 1};
  scene.contacts.push_back(on_the_ground("floor", Vec3::Zero(), 1, 0));
  push(scene, {7e-5, 0, 0});
  Simulator simulator(scene);
  StepRecord record;
  for (int k = 0; k < 3000; ++k) {
    ASSERT_TRUE(simulator.step().ok());
    simulator.write_record(record);
    simulator.restart_from(record);
  }
  const double t = 0.3;
  EXPECT_NEAR(record.bodies[0].position.x(), 7e-5 * t * t / 2, tolerance * t);
}

TEST(WeakForces, RollABall) {
  Mechanism scene = one_body(1, {0.4, 0.4, 0.4}, 1e-4);
  scene.bodies[0].position = {0, 0, 1};
  scene.contacts.push_back(on_the_ground("floor", Vec3::Zero(), 1, 1));
  push(scene, {7e-5, 5e-5, 0});
  Simulator simulator(scene);
  const double t = 1;
  const Vec3 there = position_after(simulator, 10000);
  EXPECT_NEAR(there.x(), 7e-5 * t * t / 2 / 1.4, 2 * tolerance * t);  // of the centre and of the turning
  EXPECT_NEAR(there.y(), 5e-5 * t * t / 2 / 1.4, 2 * tolerance * t);
}

}  // namespace test_weak_forces
