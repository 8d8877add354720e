#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "physics/simulator.hpp"
#include "random_loops.hpp"

/// Chains that hang between walls or drag over the ground, and boxes wedged between walls, at friction coefficients from 1
/// to 2: steps that have no solution near the last one, or none at all.
namespace rubbing {

using namespace physics;
using random_loops::join;
using campaign::direction;
using campaign::Random;

/// What every point touches.
struct Surroundings {
  std::vector<std::pair<Vec3, Vec3>> planes;  ///< normal, point
  Contact pattern;
  void touch(Mechanism& scene, BodyId body, const Vec3& point) const {
    for (const auto& [normal, at] : planes) {
      Contact contact = pattern;
      contact.name = "contact " + std::to_string(scene.contacts.size());
      contact.body = body;
      contact.point = point;
      contact.normal = normal.normalized();
      contact.plane_point = at;
      contact.tangent = contact.normal.unitOrthogonal();
      scene.add(contact);
    }
  }
};

inline void add_chain(Mechanism& scene, Surroundings& around, Random& random) {
  const int links = random.integer(1, 8);
  const double length = random.uniform(0.1, 0.5), gap = random.uniform(0.02, 0.3);
  const bool walls = random.coin();
  if (walls) around.planes.push_back({Vec3(1, 0, random.uniform(-0.2, 0.2)), Vec3(-gap, 0, 0)});
  if (walls && random.coin()) around.planes.push_back({Vec3(-1, 0, random.uniform(-0.2, 0.2)), Vec3(gap, 0, 0)});
  const double floor = random.uniform(0.3, 0.98) * links * length;
  if (!walls || random.coin()) around.planes.push_back({Vec3::UnitZ(), Vec3(0, 0, -floor)});
  if (random.coin()) around.pattern.radius = random.uniform(0.005, 0.02);
  Vec3 upper = Vec3::Zero();
  for (int i = 0; i < links; ++i) {
    const Vec3 slant(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), -1);
    const Vec3 lower = upper + length * (walls ? Vec3(-Vec3::UnitZ()) : Vec3(slant.normalized()));
    Body link = campaign::box("link " + std::to_string(i), {0.03, 0.03, length}, random.logarithmic(0.05, 5));
    link.position = 0.5 * (upper + lower);
    link.orientation = Quat(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), upper - lower));
    const BodyId id = scene.add(link);
    join(scene, random.coin() ? JointType::spherical : JointType::revolute, {i - 1}, id, upper, Vec3::UnitY());
    around.touch(scene, id, {0, 0, -0.5 * length});
    if (random.coin()) around.touch(scene, id, Vec3::Zero());
    upper = lower;
  }
  Body& moved = scene.bodies[random.integer(0, links - 1)];
  moved.velocity = random.uniform(0, 5) * direction(random);
  moved.angular_velocity = random.uniform(0, 10) * direction(random);
  const Vec3 force = random.uniform(0, 30) * direction(random);
  if (random.coin()) scene.add(Load{.body = {links - 1}, .first_step = 1, .last_step = 1000, .force = force});
}

inline void add_boxes(Mechanism& scene, Surroundings& around, Random& random) {
  const double size = random.uniform(0.1, 0.5);
  for (const double side : {1.0, -1.0}) {
    const double slope = random.uniform(-0.3, 0.6), gap = 0.55 * size + random.uniform(0, 0.1);
    around.planes.push_back({Vec3(side * std::cos(slope), 0, std::sin(slope)), Vec3(-side * gap, 0, 0)});
  }
  const int boxes = random.integer(1, 3);
  for (int i = 0; i < boxes; ++i) {
    const Vec3 edges(size, size * random.uniform(0.5, 1), size * random.uniform(0.5, 1));
    Body box = campaign::box("box " + std::to_string(i), edges, random.logarithmic(0.1, 10));
    box.position = {0, 0, (1.2 * i + 0.3) * size};
    box.orientation = Quat(Eigen::AngleAxisd(random.uniform(0, 0.5), direction(random)));
    box.velocity = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-3, 0)};
    const BodyId id = scene.add(box);
    for (int c = 0; c < 8; ++c)
      around.touch(scene, id, 0.5 * edges.cwiseProduct(Vec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1)));
    const Vec3 between = box.position - Vec3(0, 0, 0.6 * size);
    if (i > 0) join(scene, JointType::spherical, {i - 1}, id, between, Vec3::UnitY());
  }
}

/// Scene of a seed; some of them begin inside a plane.
inline Mechanism scene(std::uint64_t seed) {
  Random random(seed * 104729 + 5);
  Mechanism scene;
  scene.name = "rubbing " + std::to_string(seed);
  scene.time_step = random.logarithmic(1e-3, 2e-2);
  Surroundings around;
  around.pattern.friction = random.uniform(1, 2);
  if (random.integer(0, 2) == 0) around.pattern.friction_model = FrictionModel::pyramid;
  if (random.integer(0, 3) == 0) around.pattern.directions = random.coin() ? 6 : 8;
  if (random.integer(0, 2) == 0) add_boxes(scene, around, random);
  else add_chain(scene, around, random);
  return scene;
}

/// Those of the seeds from 0 on that do not begin inside a plane, so many.
inline std::vector<Mechanism> scenes(int count) {
  std::vector<Mechanism> all;
  for (std::uint64_t seed = 0; std::ssize(all) < count; ++seed) {
    Mechanism candidate = scene(seed);
    if (Simulator(candidate).smallest_distance() >= 0) all.push_back(std::move(candidate));
  }
  return all;
}

}  // namespace rubbing
