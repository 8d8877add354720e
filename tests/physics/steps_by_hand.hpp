#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "physics/trajectory.hpp"

/// Steps worked out by hand, for tests of the certificate.
namespace by_hand {

inline constexpr double rounding = 1e-12;

inline physics::StepRecord record(int step, double dt, std::vector<physics::BodyRecord> bodies) {
  physics::StepRecord result;
  result.step = step;
  result.time = step * dt;
  result.bodies = std::move(bodies);
  return result;
}

/// sine: of half the angle
inline physics::Quat about(const physics::Vec3& axis, double sine) {
  return {std::sqrt(1 - sine * sine), sine * axis.x(), sine * axis.y(), sine * axis.z()};
}

}  // namespace by_hand
