#include <numbers>

#include "physics/mechanism.hpp"

namespace physics {

namespace {

/// Round about z: `side` about x and y, `axial` about z.
Mat3 round(double side, double axial) { return Vec3(side, side, axial).asDiagonal(); }

/// A cylinder of height h and two half balls, one density. `height` is the cylinder's, without the caps.
Mat3 capsule_inertia(double r, double h, double mass) {
  const double cylinder_volume = std::numbers::pi * r * r * h;
  const double ball_volume = 4.0 / 3.0 * std::numbers::pi * r * r * r;
  const double cylinder = mass * cylinder_volume / (cylinder_volume + ball_volume), ball = mass - cylinder;
  // A half ball has 2/5 r^2 per mass about the centre of its face, and its own centre of mass 3/8 r away from it:
  // moving the face out by h/2 adds h^2/4 + 2 (h/2) (3/8 r).
  const double side = cylinder * (3 * r * r + h * h) / 12 + ball * (0.4 * r * r + 0.25 * h * h + 0.375 * r * h);
  return round(side, 0.5 * cylinder * r * r + 0.4 * ball * r * r);
}

}  // namespace

Mat3 shape_inertia(const Shape& shape, double mass) {
  const double r = shape.radius, h = shape.height;
  switch (shape.type) {
    case Shape::Type::sphere:
      return round(0.4 * mass * r * r, 0.4 * mass * r * r);
    case Shape::Type::box: {
      const Vec3 s = shape.size.cwiseAbs2();
      return Mat3((mass / 12 * Vec3(s.y() + s.z(), s.z() + s.x(), s.x() + s.y())).asDiagonal());
    }
    case Shape::Type::cylinder:
      return round(mass * (3 * r * r + h * h) / 12, 0.5 * mass * r * r);
    case Shape::Type::capsule:
      return capsule_inertia(r, h, mass);
    case Shape::Type::none:
    case Shape::Type::mesh:
      break;
  }
  return Mat3::Zero();
}

}  // namespace physics
