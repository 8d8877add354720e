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

}  // namespace test_weak_forces
