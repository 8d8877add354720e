#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "physics/mechanism.hpp"

/// A tilted rod hits the ground with one end, which throws the other down faster than it was falling: too fast for the
/// forecast that leaves contacts of the other end out of this step. With a contact 'low' at the first.
inline physics::Mechanism thrown_rod() {
  using namespace physics;
  Mechanism scene;
  scene.name = "thrown rod";
  Body rod;
  rod.name = "rod";
  rod.mass = 1;
  rod.inertia = Vec3(1 / 12.0, 1 / 12.0, 1e-4).asDiagonal();
  const double tilt = 0.07;
  rod.orientation = Quat(Eigen::AngleAxisd(std::acos(tilt), Vec3::UnitY()));
  rod.position = {0, 0, tilt / 2};
  rod.velocity = {0, 0, -5};
  Contact low;
  low.name = "low";
  low.body = scene.add(rod);
  low.point = {0, 0, -0.5};
  low.friction = 0.3;
  scene.add(low);
  return scene;
}
