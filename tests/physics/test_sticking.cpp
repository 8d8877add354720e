// Below the Coulomb limit nothing moves, and what has come to rest stays: whatever pushes, in any direction, with a basis
// that points anywhere at first.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_sticking {

using namespace physics;

constexpr double mass = 2, mu = 0.5, g = 9.81;
constexpr int headings = 12;

/// Not along facets, and not along their bisectors.
double heading(int k) { return 0.13 + k * 2 * std::numbers::pi / headings; }

Load always(const Vec3& force, const Vec3& torque) {
  Load load;
  load.body = {0};
  load.last_step = std::numeric_limits<int>::max();
  load.force = force;
  load.torque = torque;
  return load;
}

/// A flat box on its four corners.
Mechanism box(int directions, double time_step) {
  Mechanism scene;
  scene.time_step = time_step;
  Body body;
  body.name = "box";
  body.mass = mass;
  body.inertia = Vec3(0.2, 0.3, 0.4).asDiagonal();
  body.position = {0, 0, 0.1};
  scene.add(body);
  for (int i = 0; i < 4; ++i) {
    Contact contact;
    contact.name = "corner " + std::to_string(i);
    contact.body = {0};
    contact.point = Vec3((i & 1) ? 0.5 : -0.5, (i & 2) ? 0.3 : -0.3, -0.1);
    contact.friction = mu;
    contact.directions = directions;
    scene.add(contact);
  }
  return scene;
}

struct End {
  double way = 0;      ///< from where it began
  double fastest = 0;  ///< in the last 20 steps
};

End run(const Mechanism& scene, double duration) {
  Simulator simulator(scene);
  StepRecord record;
  End end;
  const int steps = static_cast<int>(std::lround(duration / scene.time_step));
  for (int k = 1; k <= steps; ++k) {
    const StepResult result = simulator.step();
    EXPECT_TRUE(result.ok()) << result.cause;
    if (!result.ok()) return {INFINITY, INFINITY};
    simulator.write_record(record);
    if (k > steps - 20) end.fastest = std::max(end.fastest, record.bodies[0].velocity.norm());
  }
  end.way = (record.bodies[0].position - scene.bodies[0].position).norm();
  return end;
}

/// With its basis turned against the slip alone, it crept for ever at up to 3.6 cm/s, status solved.
TEST(Sticking, ABoxPushedBelowItsFrictionStays) {
  for (const int directions : {4, 8})
    for (const double time_step : {1e-2, 1e-3})
      for (const double part : {0.6, 0.8, 0.9, 0.99})
        for (int k = 0; k < headings; ++k) {
          Mechanism scene = box(directions, time_step);
          const double force = part * mu * mass * g;
          const Vec3 push(force * std::cos(heading(k)), force * std::sin(heading(k)), 0);
          scene.loads.push_back(always(push, Vec3(0, 0, -0.1).cross(push)));  // at the height of the floor
          const End end = run(scene, 1);
          EXPECT_LE(end.fastest, 1e-9) << directions << " directions, " << time_step << " s, " << part << ", " << k;
          EXPECT_LE(end.way, 0.1 * time_step) << directions << " directions, " << time_step << " s, " << part << ", " << k;
        }
}

/// Gravity along a wall, in any direction, under a press of many times the weight: friction could stop far more than what
/// pulls, and its bound is no measure of the mass.
TEST(Sticking, ABoxPressedToAWallStays) {
  for (int k = 0; k < headings; ++k) {
    Mechanism scene = box(4, 1e-2);
    const double pull = 10, press = pull / (0.95 * mu);
    scene.gravity = Vec3(pull * std::cos(heading(k)), pull * std::sin(heading(k)), 0);
    for (Contact& contact : scene.contacts) contact.point.z() = 0;
    scene.bodies[0].position.setZero();
    scene.loads.push_back(always(Vec3(0, 0, -mass * press), Vec3::Zero()));
    EXPECT_LE(run(scene, 0.5).fastest, 1e-9) << k;
    scene.loads[0].force *= 20;
    EXPECT_LE(run(scene, 0.5).fastest, 1e-9) << k << " pressed hard";
  }
}

TEST(Sticking, ABoxThatSlidOnASlopeComesToRest) {
  for (const double fraction : {0.5, 0.8, 0.9, 0.95})
    for (int k = 0; k < headings; ++k) {
      Mechanism scene = built_in_scene("box_on_slope:dt=0.01,fraction=" + std::to_string(fraction));
      const Vec3 normal = scene.contacts[0].normal;
      const Vec3 down = (scene.gravity - normal * normal.dot(scene.gravity)).normalized(), side = normal.cross(down);
      const double speed = 0.5;
      scene.bodies[0].velocity = speed * (std::cos(heading(k)) * down + std::sin(heading(k)) * side);
      const double brake = -*scene.contacts[0].friction * normal.dot(scene.gravity) * (1 - fraction);  // at the least
      EXPECT_LE(run(scene, speed / brake + 0.3).fastest, 1e-9) << fraction << ' ' << k;
    }
}

}  // namespace test_sticking
