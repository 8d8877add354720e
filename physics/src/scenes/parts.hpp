#pragma once

#include <numbers>
#include <string>

#include "physics/mechanism.hpp"

/// What several built-in scenes are made of.
namespace physics::scenes {

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Rotation by `angle` [rad] about a unit axis.
Quat rotation(const Vec3& axis, double angle);

Shape sphere(double radius);
Shape box(const Vec3& size);
Shape cylinder(double radius, double height);

/// Homogeneous body at rest at a position, with the shape's inertia.
Body body(std::string name, const Shape& shape, double mass, const Vec3& position);

/// The paper's link: a cylinder along its z axis, +z end at `upper`, -z end at `lower`.
struct Link {
  double mass = 1.0;
  double length = 1.0;
  double radius = 0.05;
};
Body link(std::string name, const Link& link, const Vec3& upper, const Vec3& lower);

/// As `link`, for ends in a plane y = const: turned about y only, so that joints about y fit.
Body planar_link(std::string name, const Link& link, const Vec3& upper, const Vec3& lower);

/// Moves `child` so that its joint point lies on the parent's exactly.
void close_joint(const Mechanism& mechanism, const Joint& joint, Body& child);

/// Contact of a body point with the ground z = 0.
Contact ground_contact(std::string name, BodyId body, const Vec3& point, double friction);

/// Contacts "<name> 0".. at the four corners of the lower face of a box.
void add_lower_corners(Mechanism& mechanism, const std::string& name, BodyId body, const Vec3& size,
                       const Contact& pattern);

}  // namespace physics::scenes
