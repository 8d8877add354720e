#include <cmath>

#include "physics/scenes.hpp"
#include "scenes/parts.hpp"

namespace physics::scenes {

Mechanism disc(const Disc& p) {
  constexpr double mass = 1, radius = 0.5, height = 0.1;  // paper, IV-A.1
  Mechanism scene;
  scene.name = "disc";
  scene.time_step = p.time_step;
  Body disc = body("disc", cylinder(radius, height), mass, {0, 0, p.height + height / 2});
  disc.velocity = {p.speed, 0.4 * p.speed, 0};
  disc.angular_velocity = {0, 0, p.spin};
  const BodyId id = scene.add(std::move(disc));
  for (int i = 0; i < p.contacts; ++i) {
    const double angle = 2 * std::numbers::pi * i / p.contacts;
    const Vec3 point(radius * std::cos(angle), radius * std::sin(angle), -height / 2);
    scene.add(ground_contact("rim " + std::to_string(i), id, point, p.friction));
  }
  return scene;
}

Mechanism box_on_slope(const BoxOnSlope& p) {
  const Vec3 size(0.4, 0.4, 0.1);
  const double angle = p.angle < 0 ? std::atan(p.fraction * p.friction) : radians(p.angle);
  Mechanism scene;
  scene.name = "box on slope";
  scene.time_step = p.time_step;
  const Vec3 normal(std::sin(angle), 0, std::cos(angle));
  Body block = body("box", box(size), 1, 0.5 * size.z() * normal);
  block.orientation = rotation(Vec3::UnitY(), angle);
  const BodyId id = scene.add(std::move(block));
  Contact pattern;
  pattern.normal = normal;
  pattern.friction = p.friction;
  pattern.tangent = Vec3(std::cos(angle), 0, -std::sin(angle));
  add_lower_corners(scene, "corner", id, size, pattern);
  return scene;
}

Mechanism sliding_box(const SlidingBox& p) {
  const Vec3 size(0.4, 0.4, 0.1);
  Mechanism scene;
  scene.name = "sliding box";
  scene.time_step = p.time_step;
  Body block = body("box", box(size), 1, {0, 0, 0.5 * size.z()});
  block.velocity = p.speed * Vec3(std::cos(radians(p.heading)), std::sin(radians(p.heading)), 0);
  const BodyId id = scene.add(std::move(block));
  Contact pattern;
  pattern.friction = p.friction;
  add_lower_corners(scene, "corner", id, size, pattern);
  return scene;
}

Mechanism tumbling_box(const TumblingBox& p) {
  const double edge = 0.4;
  Mechanism scene;
  scene.name = "tumbling box";
  scene.time_step = p.time_step;
  Body block = body("box", box(Vec3::Constant(edge)), 1, {0, 0, p.height});
  block.orientation = rotation(Vec3(5, 2, 0).normalized(), 0.35);
  block.velocity = {1, 0.3, 0};
  block.angular_velocity = {0.6, -1.2, 0.8};
  const BodyId id = scene.add(std::move(block));
  for (int i = 0; i < 8; ++i) {
    const Vec3 sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    scene.add(ground_contact("corner " + std::to_string(i), id, edge / 2 * sign, p.friction));
  }
  return scene;
}

Mechanism spinning_sphere(const SpinningSphere& p) {
  Mechanism scene;
  scene.name = "spinning sphere";
  scene.time_step = p.time_step;
  Body ball = body("ball", sphere(p.radius), 1, {0, 0, p.radius});
  ball.angular_velocity = {0, p.spin, 0};
  const BodyId id = scene.add(std::move(ball));
  Contact contact = ground_contact("surface", id, Vec3::Zero(), p.friction);
  contact.radius = p.radius;
  scene.add(std::move(contact));
  return scene;
}

Mechanism free_top(const FreeTop& p) {
  Mechanism scene;
  scene.name = "free top";
  scene.time_step = p.time_step;
  scene.gravity.setZero();
  Body top;
  top.name = "top";
  top.mass = 1;
  top.inertia = Vec3(1, 2, 3).asDiagonal();
  top.angular_velocity = p.spin * Vec3(0.02, 1, 0.02);
  scene.add(std::move(top));
  return scene;
}

Mechanism spinning_top(const SpinningTop& p) {
  const double radius = 0.05, height = 0.02, stem = 0.06;
  Mechanism scene;
  scene.name = "spinning top";
  scene.time_step = p.time_step;
  Body top = body("top", cylinder(radius, height), 0.3, Vec3::Zero());
  top.orientation = rotation(Vec3::UnitY(), radians(p.tilt));
  top.angular_velocity = {0, 0, p.spin};
  Joint tip;
  tip.name = "tip";
  tip.type = JointType::spherical;
  tip.child = {0};
  tip.child_point = {0, 0, -stem};
  close_joint(scene, tip, top);
  scene.add(std::move(top));
  scene.add(std::move(tip));
  return scene;
}

Mechanism free_box(const FreeBox& p) {
  Mechanism scene;
  scene.name = "free box";
  scene.time_step = p.time_step;
  Body block = body("box", box({0.2, 0.3, 0.5}), 1, {0, 0, 1});
  block.velocity = {0.4 * p.speed, 0, p.speed};
  block.angular_velocity = p.spin * Vec3(0.3, 1, 0.2);
  scene.add(std::move(block));
  return scene;
}

}  // namespace physics::scenes
