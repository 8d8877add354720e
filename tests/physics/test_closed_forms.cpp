// Motions without friction that can be written down: free fall, the free top, the pendulum, a box at rest.

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

namespace test_closed_forms {

using namespace physics;

StepRecord record(const Simulator& simulator) {
  StepRecord result;
  simulator.write_record(result);
  return result;
}

/// Throws at the first step that is not solved plainly: nothing after it would be worth looking at.
void advance(Simulator& simulator, int steps) {
  for (int k = 0; k < steps; ++k) {
    const StepResult result = simulator.step();
    if (result.ok() && result.substeps == 1 && !result.new_force_direction) continue;
    throw std::runtime_error("step " + std::to_string(simulator.step_index()) + " took " +
                             std::to_string(result.substeps) + " substeps: " + std::string(result.cause));
  }
}

double relative_to(const Vec3& value, const Vec3& reference) { return (value - reference).norm() / reference.norm(); }

// ---- free fall ------------------------------------------------------------------------------------------------------

/// Largest distance from x0 + v0 t + g t (t + lag) / 2 over 1 s.
double distance_from_the_parabola(Start start, double lag, const SimulatorSettings& settings = {}) {
  Mechanism scene = scenes::free_box();
  scene.start = start;
  Simulator simulator(scene, settings);
  const BodyRecord from = record(simulator).bodies[0];
  double worst = 0;
  for (int k = 0; k < 100; ++k) {
    advance(simulator, 1);
    const double t = simulator.time();
    const Vec3 expected = from.position + t * from.velocity + t * (t + lag) / 2 * scene.gravity;
    worst = std::max(worst, (record(simulator).bodies[0].position - expected).norm());
  }
  return worst;
}

TEST(FreeFall, ThrownBoxLiesOnTheParabolaToRounding) {
  const double worst = distance_from_the_parabola(Start::half_kick, 0);
  EXPECT_LE(worst, 1e-13);
  std::printf("             largest distance %.1e m\n", worst);
}

/// The velocity that led to the first pose belongs half a step earlier: v(0) = v0 + g dt / 2.
TEST(FreeFall, AToleranceLargerThanWhatGravityDoesInAStepLetsNothingHover) {
  SimulatorSettings loose;
  loose.tolerance = 0.5;
  EXPECT_LE(distance_from_the_parabola(Start::half_kick, 0, loose), 0.01 * 9.81 / 2);
}

TEST(FreeFall, StandardStartIsTheParabolaOfAVelocityHalfAStepOlder) {
  EXPECT_LE(distance_from_the_parabola(Start::standard, scenes::FreeBox{}.time_step), 1e-13);
}

TEST(FreeFall, MomentumGrowsByWeightTimesTimeOnly) {
  const Mechanism scene = scenes::free_box();
  Simulator simulator(scene);
  advance(simulator, 1);
  const Vec3 first = simulator.linear_momentum();
  advance(simulator, 99);
  const Vec3 expected = first + 0.99 * scene.bodies[0].mass * scene.gravity;
  EXPECT_LE((simulator.linear_momentum() - expected).norm(), 1e-12);
}

/// In the middle of a step a fall is by g dt^2 / 8 above the chord between the poses, which the energy is told of. A
/// `standard` start is after the step that its velocity belongs to.
TEST(FreeFall, EnergyIsThatOfTheThrowAndStaysSo) {
  for (const Start start : {Start::half_kick, Start::standard}) {
    Mechanism scene = scenes::free_box({.spin = 0});
    scene.start = start;
    const Body& body = scene.bodies[0];
    const double thrown = 0.5 * body.mass * body.velocity.squaredNorm() - body.mass * scene.gravity.dot(body.position);
    Simulator simulator(scene);
    double expected = simulator.energy();
    if (start == Start::half_kick) {
      EXPECT_NEAR(expected, thrown, 1e-14 * thrown);
      expected -= body.mass * (scene.gravity * scene.time_step).squaredNorm() / 8;
    } else {
      EXPECT_NEAR(expected, thrown + 0.5 * scene.time_step * body.mass * scene.gravity.dot(body.velocity), 1e-14 * thrown);
    }
    for (int k = 0; k < 100; ++k) {
      advance(simulator, 1);
      ASSERT_NEAR(simulator.energy(), expected, 1e-12 * std::abs(expected)) << "step " << k + 1;
    }
  }
}

// ---- free top -------------------------------------------------------------------------------------------------------

struct TopRun {
  double momentum_drift = 0;      ///< |L - L0| / |L0|, largest
  double energy_swing = 0;        ///< (max E - min E) / E
  double smallest_alignment = 1;  ///< of the body axis it spun about with the angular momentum
};

TopRun run_top(double spin, int steps) {
  SimulatorSettings settings;
  settings.tolerance = 1e-12;
  Simulator simulator(scenes::free_top({.spin = spin}), settings);
  const Vec3 momentum = simulator.angular_momentum();
  TopRun result;
  double lowest = INFINITY, highest = -INFINITY;
  for (int k = 0; k < steps; ++k) {
    advance(simulator, 1);
    result.momentum_drift = std::max(result.momentum_drift, relative_to(simulator.angular_momentum(), momentum));
    const Vec3 axis = record(simulator).bodies[0].orientation * Vec3::UnitY();
    result.smallest_alignment = std::min(result.smallest_alignment, axis.dot(momentum.normalized()));
    lowest = std::min(lowest, simulator.energy());
    highest = std::max(highest, simulator.energy());
  }
  result.energy_swing = (highest - lowest) / highest;
  return result;
}

/// Only a tumbling body tells: with a wrong sign on the old momentum the gyroscopic torque is lost and L drifts by 3 %.
TEST(FreeTop, AngularMomentumDriftsByNoMoreThan1e12WhileTheTopTurnsOver) {
  for (const double spin : {5.0, 50.0, 150.0}) {
    const TopRun run = run_top(spin, 1000);
    EXPECT_LE(run.momentum_drift, 1e-12) << "spin " << spin;
    EXPECT_LE(run.smallest_alignment, -0.9) << "spin " << spin << ": has not turned over, the test shows nothing";
    std::printf("             spin %3.0f rad/s: momentum drift %.1e, energy swing %.1e\n", spin, run.momentum_drift,
                run.energy_swing);
  }
}

TEST(FreeTop, EnergyOfTenThousandStepsStaysWithin1e11) {
  const TopRun run = run_top(5, 10000);
  EXPECT_LE(run.energy_swing, 1e-11);
  EXPECT_LE(run.momentum_drift, 1e-12);
  std::printf("             energy swing %.1e, momentum drift %.1e\n", run.energy_swing, run.momentum_drift);
}

// ---- pendulum -------------------------------------------------------------------------------------------------------

/// Angle of a physical pendulum after `time`, from rest at `angle`: theta'' = -k sin theta, by Runge-Kutta of order 4
/// in steps whose error is far below anything compared with it.
double exact_angle(double angle, double k, double time) {
  const int steps = 20000;
  const double h = time / steps;
  double theta = angle, rate = 0;
  const auto pull = [k](double a) { return -k * std::sin(a); };
  for (int i = 0; i < steps; ++i) {
    const double k1 = pull(theta), r1 = rate;
    const double r2 = rate + h / 2 * k1, k2 = pull(theta + h / 2 * r1);
    const double r3 = rate + h / 2 * k2, k3 = pull(theta + h / 2 * r2);
    const double r4 = rate + h * k3, k4 = pull(theta + h * r3);
    theta += h / 6 * (r1 + 2 * r2 + 2 * r3 + r4);
    rate += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return theta;
}

Vec3 last_link(const scenes::Pendulum& parameters, Start start, double time) {
  Mechanism scene = scenes::pendulum(parameters);
  scene.start = start;
  SimulatorSettings settings;
  settings.tolerance = 1e-12;
  Simulator simulator(scene, settings);
  advance(simulator, static_cast<int>(std::lround(time / parameters.time_step)));
  return record(simulator).bodies.back().position;
}

/// log2 of the ratio of errors for successive halvings of the time step.
std::vector<double> orders(scenes::Pendulum parameters, Start start, double time, const Vec3& reference) {
  std::vector<double> result;
  double before = 0;
  for (const double dt : {0.02, 0.01, 0.005, 0.0025}) {
    parameters.time_step = dt;
    const double error = (last_link(parameters, start, time) - reference).norm();
    if (before > 0) result.push_back(std::log2(before / error));
    std::printf("             dt %.4f s: error %.2e m%s\n", dt, error,
                before > 0 ? (", order " + std::to_string(result.back())).c_str() : "");
    before = error;
  }
  return result;
}

Vec3 exact_link(const scenes::Pendulum& parameters, double time) {
  const Body body = scenes::pendulum(parameters).bodies[0];
  const double lever = parameters.length / 2;
  const double inertia = body.inertia(1, 1) + body.mass * lever * lever;
  const double start = parameters.angle * std::numbers::pi / 180;
  const double angle = exact_angle(start, body.mass * 9.81 * lever / inertia, time);
  // Which way the scene leans is its own affair.
  return {std::copysign(lever, body.position.x()) * std::sin(angle), 0, -lever * std::cos(angle)};
}

TEST(Pendulum, HalfKickIsOfSecondOrder) {
  for (const scenes::Hinge hinge : {scenes::Hinge::revolute, scenes::Hinge::spherical}) {
    const scenes::Pendulum parameters{.joint = hinge, .angle = 60};
    for (const double order : orders(parameters, Start::half_kick, 1.0, exact_link(parameters, 1.0)))
      EXPECT_NEAR(order, 2, 0.05);
  }
}

TEST(Pendulum, StandardStartIsOfFirstOrder) {
  const scenes::Pendulum parameters{.joint = scenes::Hinge::revolute, .angle = 60};
  for (const double order : orders(parameters, Start::standard, 1.0, exact_link(parameters, 1.0)))
    EXPECT_NEAR(order, 1, 0.1);
}

TEST(Pendulum, OfThreeLinksIsOfSecondOrderTooAgainstAFineRunOfItself) {
  scenes::Pendulum fine{.links = 3, .angle = 20, .time_step = 0.0025 / 32};
  const Vec3 reference = last_link(fine, Start::half_kick, 0.5);
  const std::vector<double> found = orders({.links = 3, .angle = 20}, Start::half_kick, 0.5, reference);
  EXPECT_NEAR(found.back(), 2, 0.1);
}

TEST(Pendulum, JointErrorDoesNotGrowWithTime) {
  Simulator simulator(scenes::pendulum({.links = 3}));
  double worst = 0;
  for (int k = 0; k < 2000; ++k) {
    advance(simulator, 1);
    worst = std::max(worst, simulator.largest_joint_error());
  }
  EXPECT_LE(worst, 1e-10);  // tolerance times time step
  std::printf("             2000 steps: %.1e m\n", worst);
}

// ---- rest -----------------------------------------------------------------------------------------------------------

/// Smallest distance of a flat box over 5 s, put on the ground or dropped.
double smallest_distance_of_a_box(double height, double time_step) {
  Mechanism scene = scenes::sliding_box({.speed = 0, .time_step = time_step});
  scene.bodies[0].position.z() += height;
  Simulator simulator(scene);
  double smallest = INFINITY;
  for (int k = 0; k < std::lround(5 / time_step); ++k) {
    advance(simulator, 1);
    smallest = std::min(smallest, simulator.smallest_distance());
  }
  EXPECT_LE(smallest, 1e-6) << "it has not come down, the test shows nothing";
  EXPECT_NEAR(simulator.linear_momentum().norm(), 0, 1e-8);
  return smallest;
}

TEST(BoxAtRest, NeverSinksDeeperThanAnAtom) {
  for (const double dt : {0.01, 0.001}) {
    for (const double height : {0.0, 0.05}) {
      const double smallest = smallest_distance_of_a_box(height, dt);
      EXPECT_GE(smallest, -1e-10) << "dt " << dt << ", dropped from " << height;
      std::printf("             dt %.3f s, from %.2f m: smallest distance %+.1e m\n", dt, height, smallest);
    }
  }
}

}  // namespace test_closed_forms
