#include "scenes/parts.hpp"

#include <cmath>

namespace physics::scenes {

Quat rotation(const Vec3& axis, double angle) {
  const Vec3 v = std::sin(angle / 2) * axis;
  return {std::cos(angle / 2), v.x(), v.y(), v.z()};
}

Shape sphere(double radius) {
  Shape shape;
  shape.type = Shape::Type::sphere;
  shape.radius = radius;
  return shape;
}

Shape box(const Vec3& size) {
  Shape shape;
  shape.type = Shape::Type::box;
  shape.size = size;
  return shape;
}

Shape cylinder(double radius, double height) {
  Shape shape;
  shape.type = Shape::Type::cylinder;
  shape.radius = radius;
  shape.height = height;
  return shape;
}

Body body(std::string name, const Shape& shape, double mass, const Vec3& position) {
  Body result;
  result.name = std::move(name);
  result.shape = shape;
  result.mass = mass;
  result.inertia = shape_inertia(shape, mass);
  result.position = position;
  return result;
}

Body link(std::string name, const Link& link, const Vec3& upper, const Vec3& lower) {
  Body result = body(std::move(name), cylinder(link.radius, link.length), link.mass, (upper + lower) / 2);
  const Vec3 z = (upper - lower).normalized();
  // Half-way quaternion of the shortest arc from e_z to z; the sum is zero only for a link upside down.
  const Quat arc(1 + z.z(), -z.y(), z.x(), 0);
  result.orientation = Quat(0, 1, 0, 0);
  if (arc.norm() > 1e-6) result.orientation = arc.normalized();
  return result;
}

Body planar_link(std::string name, const Link& link, const Vec3& upper, const Vec3& lower) {
  Body result = body(std::move(name), cylinder(link.radius, link.length), link.mass, (upper + lower) / 2);
  const Vec3 z = upper - lower;
  result.orientation = rotation(Vec3::UnitY(), std::atan2(z.x(), z.z()));
  return result;
}

void close_joint(const Mechanism& mechanism, const Joint& joint, Body& child) {
  Vec3 point = joint.parent_point;
  if (!joint.parent.is_world()) {
    const Body& parent = mechanism.bodies[joint.parent.index];
    point = parent.position + parent.orientation * joint.parent_point;
  }
  child.position = point - child.orientation * joint.child_point;
}

Contact ground_contact(std::string name, BodyId body, const Vec3& point, double friction) {
  Contact contact;
  contact.name = std::move(name);
  contact.body = body;
  contact.point = point;
  contact.friction = friction;
  return contact;
}

void add_lower_corners(Mechanism& mechanism, const std::string& name, BodyId body, const Vec3& size,
                       const Contact& pattern) {
  for (int i = 0; i < 4; ++i) {
    Contact contact = pattern;
    contact.name = name + ' ' + std::to_string(i);
    contact.body = body;
    contact.point = {(i < 2 ? 0.5 : -0.5) * size.x(), (i % 2 == 0 ? 0.5 : -0.5) * size.y(), -0.5 * size.z()};
    mechanism.add(std::move(contact));
  }
}

}  // namespace physics::scenes
