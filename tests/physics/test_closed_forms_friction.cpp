// Motions with dry friction that can be written down: stopping, sticking and sliding on a slope, rolling.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_closed_forms_friction {

using namespace physics;

constexpr double g = 9.81;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

BodyRecord first_body(const Simulator& simulator) {
  StepRecord record;
  simulator.write_record(record);
  return record.bodies[0];
}

/// Throws at the first step that is not solved plainly: nothing after it would be worth looking at.
void advance(Simulator& simulator, double duration) {
  for (long k = std::lround(duration / simulator.time_step()); k > 0; --k) {
    const StepResult result = simulator.step();
    if (result.ok() && result.substeps == 1 && !result.new_force_direction) continue;
    throw std::runtime_error("step " + std::to_string(simulator.step_index()) + " took " +
                             std::to_string(result.substeps) + " substeps: " + std::string(result.cause));
  }
}

// ---- far away, in short steps ----

/// Rounding of a position of 100 m shows as more than gravity in a step of 0.1 us. It is no excuse for not feeling it: the
/// floor carries the sphere and brakes it.
TEST(SlidingSphere, ShortStepsFarFromTheOriginFeelGravityAndFriction) {
  Mechanism scene;
  Body ball;
  ball.name = "ball";
  ball.mass = 1;
  ball.shape.type = Shape::Type::sphere;
  ball.shape.radius = 0.1;
  ball.inertia = shape_inertia(ball.shape, ball.mass);
  ball.position = {100, 0, 0.1};
  ball.velocity = {1, 0, 0};
  Contact contact;
  contact.name = "floor";
  contact.body = scene.add(ball);
  contact.radius = 0.1;
  contact.friction = 0.5;
  scene.add(contact);
  scene.time_step = 1e-7;
  Simulator simulator(scene);
  constexpr int steps = 1000;
  for (int k = 0; k < steps; ++k) ASSERT_TRUE(simulator.step().ok()) << simulator.failure_place();
  StepRecord record;
  simulator.write_record(record);
  EXPECT_NEAR(record.contacts[0].normal_force, g, 1e-3 * g);
  EXPECT_NEAR(record.bodies[0].velocity.x(), 1 - 0.5 * g * (steps - 0.5) * scene.time_step, 1e-3 * 0.5 * g * steps * scene.time_step);
}

// ---- stopping -------------------------------------------------------------------------------------------------------

/// Displacement of a sliding block when it has stopped.
Vec3 stopping_path(const scenes::SlidingBox& parameters, Start start, FrictionModel model) {
  Mechanism scene = scenes::sliding_box(parameters);
  scene.start = start;
  for (Contact& contact : scene.contacts) {
    contact.friction_model = model;
    contact.tangent = Vec3::UnitX();
  }
  Simulator simulator(scene);
  const Vec3 from = first_body(simulator).position;
  advance(simulator, 1.5);
  EXPECT_LE(first_body(simulator).velocity.norm(), 1e-8) << "it has not stopped, the test shows nothing";
  return first_body(simulator).position - from;
}

double stopping_distance(const scenes::SlidingBox& p) { return p.speed * p.speed / (2 * p.friction * g); }

TEST(SlidingBlock, StopsAfterV0SquaredOver2MuGAtAnyHeading) {
  // At 190 degrees the basis that is given, t1 = x, lies 10 degrees off the friction force: near, but not near enough.
  for (const double heading : {0.0, 1.0, 10.0, 20.0, 30.0, 45.0, 100.0, 190.0, 200.0}) {
    const scenes::SlidingBox p{.heading = heading, .time_step = 0.01};
    const Vec3 path = stopping_path(p, Start::half_kick, FrictionModel::aligned);
    const double error = path.norm() / stopping_distance(p) - 1;
    EXPECT_LE(std::abs(error), 0.003) << "heading " << heading;
    EXPECT_NEAR(std::remainder(std::atan2(path.y(), path.x()) - radians(heading), 2 * std::numbers::pi), 0, 1e-6);
    std::printf("             heading %3.0f deg: distance off by %+.1e\n", heading, error);
  }
}

/// Its first velocity belongs half a step earlier, so that it is slowed down for half a step longer.
TEST(SlidingBlock, StandardStartStopsShortByHalfAStepsWay) {
  for (const double heading : {0.0, 30.0, 45.0, 100.0}) {
    const scenes::SlidingBox p{.heading = heading, .time_step = 0.01};
    const double path = stopping_path(p, Start::standard, FrictionModel::aligned).norm();
    const double error = (path + p.speed * p.time_step / 2) / stopping_distance(p) - 1;
    EXPECT_LE(std::abs(error), 0.003) << "heading " << heading;
    std::printf("             heading %3.0f deg: corrected distance off by %+.1e\n", heading, error);
  }
}

/// Four directions bound |f1| + |f2|, not |f|: along the diagonal the friction is weaker by sqrt 2.
TEST(SlidingBlock, PyramidOfThePaperSlides42PercentFartherAlongItsDiagonal) {
  const double straight = stopping_path({.heading = 0}, Start::half_kick, FrictionModel::pyramid).norm();
  const double diagonal = stopping_path({.heading = 45}, Start::half_kick, FrictionModel::pyramid).norm();
  EXPECT_NEAR(straight, stopping_distance({}), 0.003 * straight);
  EXPECT_NEAR(diagonal / straight, std::numbers::sqrt2, 0.003);
  // Away from both it does not even stop on its line.
  const Vec3 oblique = stopping_path({.heading = 30}, Start::half_kick, FrictionModel::pyramid);
  EXPECT_GT(std::atan2(oblique.y(), oblique.x()), radians(35));
  std::printf("             diagonal over straight %.4f, heading 30 deg ends at %.1f deg\n", diagonal / straight,
              std::atan2(oblique.y(), oblique.x()) * 180 / std::numbers::pi);
}

// ---- slope ----------------------------------------------------------------------------------------------------------

enum class Stand { box, tripod, point };

std::string name(Stand stand) { return stand == Stand::box ? "box" : stand == Stand::tripod ? "tripod" : "point"; }

struct Slope {
  Stand stand = Stand::box;
  double heading = 0;  ///< of the way down, from x [deg]
  double yaw = 0;      ///< of the body on the slope, against the way down [deg]
  double friction = 0.5;
  double fraction = 0.9;  ///< tan(angle) over the friction coefficient
  double time_step = 0.01;

  [[nodiscard]] double angle() const { return std::atan(fraction * friction); }
};

/// Points that touch the slope, in the body frame: corners of a box, three round feet, or a mass point.
std::vector<Vec3> feet(Stand stand) {
  if (stand == Stand::point) return {Vec3::Zero()};
  std::vector<Vec3> points;
  const int count = stand == Stand::box ? 4 : 3;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count + 0.1;
    points.push_back({0.25 * std::cos(angle), 0.25 * std::sin(angle), stand == Stand::box ? -0.05 : -0.03});
  }
  return points;
}

Mechanism make(const Slope& p) {
  const Vec3 down(std::cos(radians(p.heading)), std::sin(radians(p.heading)), 0);
  const Quat tilt(Eigen::AngleAxisd(p.angle(), Vec3::UnitZ().cross(down)));
  Mechanism scene;
  scene.time_step = p.time_step;
  Body body;
  body.name = name(p.stand);
  body.mass = 2;
  body.inertia = Vec3(0.03, 0.03, 0.05).asDiagonal();
  body.orientation = tilt * Quat(Eigen::AngleAxisd(radians(p.yaw), Vec3::UnitZ()));
  const Vec3 normal = tilt * Vec3::UnitZ();
  if (p.stand != Stand::point) body.position = 0.05 * normal;
  const BodyId id = scene.add(body);
  for (const Vec3& point : feet(p.stand)) {
    Contact contact;
    contact.name = "foot " + std::to_string(scene.contacts.size());
    contact.body = id;
    contact.point = point;
    contact.normal = normal;
    contact.friction = p.friction;
    contact.radius = p.stand == Stand::tripod ? 0.02 : 0;
    scene.add(contact);
  }
  return scene;
}

struct Creep {
  double drift = 0;      ///< way over a second, over that second [m/s]
  double momentary = 0;  ///< fastest step within it [m/s]
};

Creep creep_after_settling(const Slope& slope) {
  Simulator simulator(make(slope));
  advance(simulator, 1);
  const Vec3 from = first_body(simulator).position;
  Creep creep;
  for (long k = std::lround(1 / slope.time_step); k > 0; --k) {
    advance(simulator, slope.time_step);
    creep.momentary = std::max(creep.momentary, first_body(simulator).velocity.norm());
  }
  creep.drift = (first_body(simulator).position - from).norm();
  return creep;
}

class SlopeOfAnyDirection : public testing::TestWithParam<Stand> {};

TEST_P(SlopeOfAnyDirection, At90PercentOfTheConeNothingCreeps) {
  for (const double dt : {0.01, 0.001}) {
    Creep worst;
    for (const double heading : {0.0, 17.0, 30.0, 45.0, 80.0, 123.0, 200.0, 310.0}) {
      for (const double yaw : {0.0, 25.0}) {
        const Creep creep =
            creep_after_settling({.stand = GetParam(), .heading = heading, .yaw = yaw, .time_step = dt});
        EXPECT_LE(creep.drift, 1e-9) << "heading " << heading << ", yaw " << yaw << ", dt " << dt;
        // One step may move by what the tolerance leaves open (1e-8); it must not add up.
        EXPECT_LE(creep.momentary, dt == 0.01 ? 1e-9 : 1e-8) << "heading " << heading << ", yaw " << yaw;
        worst = {std::max(worst.drift, creep.drift), std::max(worst.momentary, creep.momentary)};
      }
    }
    std::printf("             %s, dt %.3f s: drift %.1e m/s, fastest step %.1e m/s\n", name(GetParam()).c_str(), dt,
                worst.drift, worst.momentary);
  }
}

TEST_P(SlopeOfAnyDirection, AboveTheConeEverythingSlidesDownwardsAtGSinMinusMuCos) {
  double worst = 0;
  for (const double heading : {0.0, 30.0, 45.0, 123.0, 200.0}) {
    for (const double fraction : {1.1, 1.5}) {
      const Slope slope{.stand = GetParam(), .heading = heading, .yaw = 20, .fraction = fraction};
      Simulator simulator(make(slope));
      advance(simulator, 0.5);
      const Vec3 before = first_body(simulator).velocity;
      advance(simulator, 0.5);
      const Vec3 gained = (first_body(simulator).velocity - before) / 0.5;
      const double expected = g * (std::sin(slope.angle()) - slope.friction * std::cos(slope.angle()));
      const double error = std::abs(gained.norm() / expected - 1);
      EXPECT_LE(error, 1e-5) << "heading " << heading << ", fraction " << fraction;
      EXPECT_NEAR(std::remainder(std::atan2(gained.y(), gained.x()) - radians(heading), 2 * std::numbers::pi), 0, 1e-6);
      EXPECT_LT(gained.z(), 0);
      worst = std::max(worst, error);
    }
  }
  std::printf("             %s: acceleration off by %.1e at most\n", name(GetParam()).c_str(), worst);
}

INSTANTIATE_TEST_SUITE_P(Standing, SlopeOfAnyDirection, testing::Values(Stand::box, Stand::tripod, Stand::point),
                         [](const auto& test) { return name(test.param); });

// ---- rolling --------------------------------------------------------------------------------------------------------

BodyRecord rolling_sphere(double time_step, double heading) {
  const scenes::SpinningSphere p{.time_step = time_step};
  Mechanism scene = scenes::spinning_sphere(p);
  // Spin about the horizontal axis that drives it towards `heading`.
  scene.bodies[0].angular_velocity = p.spin * Vec3(-std::sin(radians(heading)), std::cos(radians(heading)), 0);
  Simulator simulator(scene);
  advance(simulator, 2);
  return first_body(simulator);
}

/// The angular momentum about the contact point never changes: m r v + p(w) = J w0, with w = v / r at the end.
/// In discrete time p(w) = J w sqrt(1 - (w dt / 2)^2): 2/7 up to that root. Wrong by a factor in the torque arm of
/// friction it would end at another fraction altogether.
TEST(SpinningSphere, EndsRollingAtTwoSeventhsOfItsRimSpeed) {
  const scenes::SpinningSphere p;
  for (const double dt : {0.01, 0.001}) {
    for (const double heading : {0.0, 30.0, 45.0}) {
      const BodyRecord end = rolling_sphere(dt, heading);
      const double v = end.velocity.norm(), w = end.angular_velocity.norm();
      EXPECT_NEAR(v, 2.0 / 7 * p.spin * p.radius, v * std::pow(p.spin / 3.5 * dt, 2) / 8);
      EXPECT_NEAR(v, w * p.radius, 1e-8) << "it slips";
      const double momentum = v + 0.4 * p.radius * w * std::sqrt(1 - std::pow(w * dt / 2, 2));
      EXPECT_NEAR(momentum, 0.4 * p.radius * p.spin, 1e-8);
      EXPECT_NEAR(std::atan2(end.velocity.y(), end.velocity.x()), radians(heading), 1e-6);
      std::printf("             dt %.3f s, heading %2.0f deg: %.9f of the rim speed (2/7 = %.9f)\n", dt, heading,
                  v / (p.spin * p.radius), 2.0 / 7);
    }
  }
}

}  // namespace test_closed_forms_friction
