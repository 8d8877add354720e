#include <Eigen/LU>
#include <cmath>

#include "physics/scenes.hpp"
#include "scenes/parts.hpp"

namespace physics::scenes {

namespace {

struct Bar {
  std::string name;
  Vec3 from, to;  // ends at the local -z and +z end
  double rate;    // about y [rad/s]
  Vec3 velocity;  // of `from`
};

BodyId add_bar(Mechanism& scene, const Bar& bar) {
  Link part;
  part.length = (bar.to - bar.from).norm();
  part.mass = part.length;  // 1 kg/m
  part.radius = 0.03;
  Body body = planar_link(bar.name, part, bar.to, bar.from);
  body.angular_velocity = {0, bar.rate, 0};
  body.velocity = bar.velocity + body.angular_velocity.cross(body.position - bar.from);
  return scene.add(std::move(body));
}

struct Pin {
  std::string name;
  BodyId parent, child;
  Vec3 parent_point, child_point;
};

void add_pin(Mechanism& scene, const Pin& pin) {
  Joint joint;
  joint.name = pin.name;
  joint.type = JointType::revolute;
  joint.axis = Vec3::UnitY();
  joint.parent = pin.parent;
  joint.child = pin.child;
  joint.parent_point = pin.parent_point;
  joint.child_point = pin.child_point;
  scene.add(std::move(joint));
}

/// Where circles about a and b (radii ra, rb, plane y = 0) meet, the point on the upper side of a -> b.
Vec3 circle_intersection(const Vec3& a, double ra, const Vec3& b, double rb) {
  const Vec3 ab = b - a;
  const double d = ab.norm();
  const double along = (ra * ra - rb * rb + d * d) / (2 * d);
  const double square = ra * ra - along * along;
  if (!(square > 0)) throw DescriptionError("scene 'four_bar': the bars do not reach each other at this angle");
  return a + along / d * ab + std::sqrt(square) / d * Vec3(-ab.z(), 0, ab.x());
}

}  // namespace

Mechanism four_bar(const FourBar& p) {
  Mechanism scene;
  scene.name = "four-bar";
  scene.time_step = p.time_step;
  const Vec3 y = Vec3::UnitY();
  const Vec3 a = Vec3::Zero(), d(p.ground, 0, 0);
  const Vec3 b = p.crank * Vec3(std::cos(radians(p.angle)), 0, std::sin(radians(p.angle)));
  const Vec3 c = circle_intersection(b, p.coupler, d, p.rocker);
  // v_c = v_b + w_coupler y x (c - b) = w_rocker y x (c - d)
  const Vec3 v_b = p.rate * y.cross(b), by_coupler = y.cross(c - b), by_rocker = y.cross(c - d);
  Eigen::Matrix2d m;
  m << by_rocker.x(), -by_coupler.x(), by_rocker.z(), -by_coupler.z();
  const Eigen::Vector2d rates = m.inverse() * Eigen::Vector2d(v_b.x(), v_b.z());

  const BodyId crank = add_bar(scene, {"crank", a, b, p.rate, Vec3::Zero()});
  const BodyId coupler = add_bar(scene, {"coupler", b, c, rates[1], v_b});
  const BodyId rocker = add_bar(scene, {"rocker", d, c, rates[0], Vec3::Zero()});
  const auto end = [](double length, double side) { return Vec3(0, 0, side * length / 2); };
  add_pin(scene, {"ground-crank", world, crank, a, end(p.crank, -1)});
  add_pin(scene, {"crank-coupler", crank, coupler, end(p.crank, 1), end(p.coupler, -1)});
  add_pin(scene, {"coupler-rocker", coupler, rocker, end(p.coupler, 1), end(p.rocker, 1)});
  add_pin(scene, {"ground-rocker", world, rocker, d, end(p.rocker, -1)});
  return scene;
}

Mechanism pads(const Pads& p) {
  const Vec3 block_size(1, 0.8, 0.4), pad_size(0.1, 0.1, 0.02);
  const double pad_mass = 1;
  Mechanism scene;
  scene.name = "pads";
  scene.time_step = p.time_step;
  Body block = body("block", box(block_size), p.ratio * pad_mass, {0, 0, pad_size.z() + block_size.z() / 2});
  block.velocity = {p.speed, 0, 0};
  const BodyId block_id = scene.add(std::move(block));
  Contact pattern;
  pattern.friction = p.friction;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "pad " + std::to_string(i);
    Joint ankle;
    ankle.name = "ankle " + std::to_string(i);
    ankle.type = JointType::spherical;
    ankle.parent = block_id;
    ankle.child = {i + 1};
    ankle.parent_point = {i < 2 ? 0.4 : -0.4, i % 2 == 0 ? 0.3 : -0.3, -block_size.z() / 2};
    ankle.child_point = {0, 0, pad_size.z() / 2};
    Body pad = body(name, box(pad_size), pad_mass, Vec3::Zero());
    pad.velocity = {p.speed, 0, 0};
    close_joint(scene, ankle, pad);
    const BodyId id = scene.add(std::move(pad));
    scene.add(std::move(ankle));
    add_lower_corners(scene, name + " corner", id, pad_size, pattern);
  }
  return scene;
}

}  // namespace physics::scenes
