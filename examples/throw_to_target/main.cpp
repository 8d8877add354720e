// How hard, and which way, to push a box on a rough floor so that it stops on a mark?
//
//   build/release/bin/throw_to_target
//
// Gauss-Newton through all steps of the slide: each step leaves its linearisation on a tape (StepGradient), and two
// vector-Jacobian products per step carry the derivative of the final position back to the first velocity. Expect a
// miss of half a metre to become one of less than a micrometre in a few tries, and v = sqrt(2 mu g 0.5 m) = 1.716 m/s.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <optional>
#include <vector>

#include "../no_arguments.hpp"
#include "physics/gradients.hpp"
#include "physics/scenes.hpp"

namespace {

using namespace physics;

constexpr int steps = 100;  // 1 s: the box has come to rest

struct Slide {
  Eigen::Vector2d end;
  Eigen::Matrix2d by_velocity;  // of the end by the first velocity
};

/// None where a step failed or has no derivative.
std::optional<Slide> slide(const Eigen::Vector2d& velocity) {
  Mechanism scene = scenes::sliding_box({.friction = 0.3});
  scene.bodies[0].position.head<2>().setZero();
  scene.bodies[0].velocity = {velocity.x(), velocity.y(), 0};
  Simulator simulator(scene);
  std::vector<StepGradient> tape;
  for (int k = 0; k < steps; ++k) {
    if (!simulator.step().ok()) return std::nullopt;
    tape.emplace_back(simulator, GradientSettings{.friction_basis = FrictionBasis::following});
    if (tape.back().evaluate() != GradientStatus::ready) return std::nullopt;
  }
  Slide result;
  result.end = tape.back().position(0).head<2>();
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> adjoint(tape[0].state_size()), gradient(tape[0].gradient_size());
    adjoint[axis] = 1;  // of the position after the last step
    for (int k = steps - 1; k >= 0; --k) {
      tape[k].vector_jacobian(adjoint, gradient);
      std::copy_n(gradient.begin(), adjoint.size(), adjoint.begin());  // by the state before the step
    }
    result.by_velocity.row(axis) << adjoint[6], adjoint[7];
  }
  return result;
}

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words,
               "How to push a box so that it stops on a mark, found by derivatives of all steps of its slide.");
  const Eigen::Vector2d mark(0.4, 0.3);
  Eigen::Vector2d velocity(0.5, -0.5);
  for (int k = 0; k < 12; ++k) {
    const std::optional<Slide> at = slide(velocity);
    if (!at) break;
    const Eigen::Vector2d miss = at->end - mark;
    std::printf("pushed at (%+.4f, %+.4f) m/s it stops at (%+.6f, %+.6f) m and misses by %.1e m\n", velocity.x(),
                velocity.y(), at->end.x(), at->end.y(), miss.norm());
    if (miss.norm() < 1e-6) {
      std::printf("found: %.3f m/s at %.2f degrees\n", velocity.norm(),
                  std::atan2(velocity.y(), velocity.x()) * 180 / std::numbers::pi);
      return 0;
    }
    Eigen::Vector2d change = -at->by_velocity.fullPivLu().solve(miss);
    if (change.norm() > 1) change *= 1 / change.norm();  // one m/s per try
    velocity += change;
  }
  std::printf("not found\n");
  return 1;
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "throw_to_target: %s\n", error.what());
  return 2;
}
