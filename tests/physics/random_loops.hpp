#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "physics/mechanism.hpp"
#include "support/campaign.hpp"

/// Links in a closed loop in space, free or held at the world by one more joint, some of them with velocities that the
/// loop cannot have. With few ball joints among four or five links the loop is over-constrained.
namespace random_loops {

using namespace physics;
using campaign::direction;
using campaign::Random;

/// Joins bodies where they are; the axis in the world.
inline void join(Mechanism& scene, JointType type, BodyId parent, BodyId child, const Vec3& at, const Vec3& axis) {
  const auto pose = [&](BodyId id) {
    return id.is_world() ? std::pair(Vec3(Vec3::Zero()), Quat(Quat::Identity()))
                         : std::pair(scene.bodies[id.index].position, scene.bodies[id.index].orientation);
  };
  const auto [xa, qa] = pose(parent);
  const auto [xb, qb] = pose(child);
  Joint joint;
  joint.name = "joint " + std::to_string(scene.joints.size());
  joint.type = type;
  joint.parent = parent;
  joint.child = child;
  joint.parent_point = qa.conjugate() * (at - xa);
  joint.child_point = qb.conjugate() * (at - xb);
  joint.axis = qa.conjugate() * axis;
  joint.orientation = qa.conjugate() * qb;
  scene.add(joint);
}

struct Motion {
  double speed = 20, spin = 50;  ///< of a link, at most [m/s], [rad/s]
};

inline Mechanism loop(std::uint64_t seed, const Motion& most = {}) {
  Random random(seed * 7919 + 17);
  Mechanism scene;
  scene.name = "loop " + std::to_string(seed);
  const int links = random.integer(4, 12);
  std::vector<Vec3> corner(links);
  for (int i = 0; i < links; ++i) {
    const double angle = 2 * std::numbers::pi * i / links, radius = random.uniform(0.6, 1.2);
    corner[i] = {radius * std::cos(angle), radius * std::sin(angle), random.uniform(-0.4, 0.4)};
  }
  for (int i = 0; i < links; ++i) {
    const Vec3 from = corner[i], to = corner[(i + 1) % links];
    Body link;
    link.name = "link " + std::to_string(i);
    link.mass = random.logarithmic(0.1, 10);
    link.shape.type = Shape::Type::box;
    link.shape.size = {0.1, 0.1, (to - from).norm()};
    link.inertia = shape_inertia(link.shape, link.mass);
    link.position = 0.5 * (from + to);
    link.orientation = Quat(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), to - from));
    scene.add(link);
  }
  const double hinges = random.coin() ? 0 : random.uniform(0, 1);
  const auto type = [&] { return random.uniform(0, 1) < hinges ? JointType::revolute : JointType::spherical; };
  for (int i = 0; i < links; ++i) join(scene, type(), {(i + links - 1) % links}, {i}, corner[i], direction(random));
  if (random.coin()) join(scene, type(), world, {0}, corner[0], direction(random));
  const int moving = random.coin() ? 1 : random.integer(1, links);
  for (int i = 0; i < moving; ++i) {
    Body& link = scene.bodies[random.integer(0, links - 1)];
    link.velocity = random.uniform(0, most.speed) * direction(random);
    link.angular_velocity = random.uniform(0, most.spin) * direction(random);
  }
  scene.time_step = random.logarithmic(1e-3, 2e-2);
  if (random.coin()) scene.start = Start::standard;
  return scene;
}

}  // namespace random_loops
