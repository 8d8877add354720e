#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/scenes.hpp"
#include "support/campaign_parts.hpp"

namespace campaign {

using namespace physics;

namespace {

Vec3 along_ground(Random& random, double least, double most) {
  const double heading = random.uniform(0, 2 * std::numbers::pi), speed = random.uniform(least, most);
  return {speed * std::cos(heading), speed * std::sin(heading), 0};
}

Mechanism tumbling(Random& random, double friction, double spin) {
  Mechanism scene;
  Body body = box("box", {random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1)}, random.logarithmic(0.1, 10));
  body.position = {0, 0, 0.5 * body.shape.size.norm() + random.uniform(0, 0.2)};
  body.orientation = any_rotation(random);
  body.velocity = along_ground(random, 0, 3) + Vec3(0, 0, random.uniform(-2, 0));
  body.angular_velocity = spin * direction(random);
  add_corners(scene, scene.add(std::move(body)), friction, 8);
  return scene;
}

/// Boxes on top of each other, hinged at the middle of their faces; lands, leans, slides.
Mechanism stack(Random& random) {
  Mechanism scene;
  const int boxes = random.integer(2, 5);
  const double friction = random.uniform(0.1, 1);
  double z = random.uniform(0, 0.05);
  for (int i = 0; i < boxes; ++i) {
    const double edge = random.uniform(0.1, 0.3);
    Body body = box("box " + std::to_string(i), {edge, edge, edge}, random.logarithmic(1e-3, 1e3));
    body.position = {0, 0, z + edge / 2};
    const BodyId id = scene.add(std::move(body));
    if (i == 0) add_corners(scene, id, friction, 4);
    else join(scene, random.coin() ? JointType::spherical : JointType::revolute, {i - 1}, id, {0, 0, z});
    z += edge;
  }
  set_velocity(scene, along_ground(random, 0, 1));
  return scene;
}

Mechanism mass_ratio(Random& random) {
  Mechanism scene;
  switch (random.integer(0, 2)) {
    case 0: scene = stack(random); break;
    case 1: {
      const double mass = random.logarithmic(1e-3, 1e3);
      const Vec3 along(random.uniform(0.3, 1), random.uniform(-0.3, 0.3), random.uniform(-0.02, 0.02));
      add_chain(scene, random.integer(2, 8), {0, 0, random.uniform(0.2, 0.4)}, along, random.uniform(0.1, 1),
                [&](int) { return mass * random.logarithmic(1e-3, 1e3); });
      set_velocity(scene, along_ground(random, 0, 1));
      break;
    }
    default:
      scene = scenes::pads({.ratio = random.logarithmic(1e-6, 1e6), .speed = random.uniform(0, 1),
                            .friction = random.uniform(0.1, 1)});
  }
  scene.time_step = random.logarithmic(1e-3, 1e-2);
  vary(scene, random);
  return scene;
}

Mechanism friction(Random& random) {
  const double coefficient = random.logarithmic(1e-6, 10);
  Mechanism scene;
  if (random.coin()) {
    scene = tumbling(random, coefficient, random.uniform(0, 5));
  } else {
    const Vec3 along(random.uniform(0.3, 1), random.uniform(-0.3, 0.3), random.uniform(-0.02, 0.02));
    add_chain(scene, random.integer(1, 6), {0, 0, random.uniform(0.2, 0.4)}, along, coefficient, [](int) { return 1.0; });
    set_velocity(scene, along_ground(random, 0, 2));
  }
  scene.time_step = random.logarithmic(1e-3, 1e-2);
  vary(scene, random);
  return scene;
}

Mechanism time_step(Random& random) {
  Mechanism scene;
  switch (random.integer(0, 3)) {
    case 0: scene = tumbling(random, random.uniform(0.1, 1), random.uniform(0, 5)); break;
    case 1: scene = scenes::four_bar({.angle = random.uniform(40, 100), .rate = random.uniform(0, 3)}); break;
    case 2: scene = scenes::pendulum({.links = random.integer(1, 3), .angle = random.uniform(5, 90)}); break;
    default: {
      const Vec3 along(random.uniform(0.3, 1), random.uniform(-0.3, 0.3), random.uniform(-0.02, 0.02));
      add_chain(scene, random.integer(1, 6), {0, 0, random.uniform(0.05, 0.2)}, along, random.uniform(0.1, 1),
                [](int) { return 1.0; });
      set_velocity(scene, along_ground(random, 0, 2));
    }
  }
  scene.time_step = random.logarithmic(1e-5, 0.1);
  vary(scene, random);
  return scene;
}

Mechanism coplanar(Random& random) {
  Mechanism scene = scenes::disc({.contacts = 100, .friction = random.uniform(0.05, 1), .height = random.uniform(0, 0.1),
                                  .speed = random.uniform(0, 3), .spin = random.uniform(-10, 10)});
  scene.time_step = random.logarithmic(1e-3, 1e-2);
  vary(scene, random);
  return scene;
}

Mechanism spin(Random& random) {
  const double rate = random.logarithmic(10, 1000);
  Mechanism scene = tumbling(random, random.uniform(0.05, 1), rate);
  scene.time_step = random.uniform(0.05, 1.85) / rate;
  vary(scene, random);
  return scene;
}

/// A rod, or two hinged ones, sliding at an angle into its own friction.
Mechanism wedging(Random& random) {
  Mechanism scene;
  const double coefficient = random.uniform(1.5, 10);
  const double angle = random.uniform(0.2, 1.4), height = random.uniform(0, 0.05);
  const Vec3 along(std::cos(angle), 0, -std::sin(angle));
  Vec3 upper(0, 0, std::sin(angle) + height);
  add_chain(scene, 1, upper, along, coefficient, [](int) { return 1.0; });
  if (random.coin()) {
    const BodyId second = scene.add(bar("second", upper, upper + Vec3(-std::cos(angle), 0, -std::sin(angle)), 0.1,
                                        random.logarithmic(0.1, 10)));
    scene.add(ground("second end", second, {0, 0, -0.5}, coefficient));
    join(scene, JointType::revolute, {0}, second, upper);
  }
  set_velocity(scene, Vec3(random.uniform(-5, 5), random.uniform(-0.5, 0.5), random.uniform(-1, 0)));
  scene.time_step = random.logarithmic(1e-3, 1e-2);
  vary(scene, random);
  return scene;
}

/// Fast bodies whose contacts are left out at first and reached in the middle of a step.
Mechanism far_contact(Random& random) {
  const double speed = random.logarithmic(10, 200);
  Mechanism scene;
  if (random.coin()) {
    scene = tumbling(random, random.uniform(0.1, 1), random.uniform(0, 20));
  } else {  // a long rod that turns its end down onto the ground
    add_chain(scene, random.integer(1, 3), {0, 0, 1}, {1, 0, 0}, random.uniform(0.1, 1), [](int) { return 1.0; });
    if (scene.bodies.size() == 1) scene.bodies[0].angular_velocity = {0, random.uniform(-30, 30), 0};
  }
  const double height = random.logarithmic(0.1, 1) * speed * 0.5;
  for (Body& body : scene.bodies) {
    body.position.z() += height;
    body.velocity = Vec3(random.uniform(-1, 1), 0, 0) - speed * Vec3::UnitZ();
  }
  const Vec3 together = scene.bodies[0].velocity;
  set_velocity(scene, together);
  scene.time_step = random.logarithmic(1e-3, 2e-2);
  vary(scene, random);
  return scene;
}

/// Four bars closed to a ring in the plane y = 0, with extra ones across; hinges about y: redundant rows.
Mechanism parallelogram(Random& random) {
  Mechanism scene;
  const bool free_body = random.coin();
  const double width = random.uniform(0.5, 1.5), angle = random.uniform(0.5, 2.6), length = random.uniform(0.3, 0.8);
  const double z = free_body ? length + random.uniform(0, 0.2) : 0;
  const int cranks = random.integer(2, 4);
  const Vec3 down(length * std::cos(angle), 0, -length * std::sin(angle)), right(width, 0, 0), corner(0, 0, z);
  const double friction = random.uniform(0.1, 1);
  if (free_body) scene.add(bar("ground bar", corner, corner + right, 0.05, random.logarithmic(0.1, 10)));
  const BodyId top = free_body ? BodyId{0} : world;
  const BodyId coupler = scene.add(bar("coupler", corner + down, corner + down + right, 0.05, random.logarithmic(0.1, 10)));
  for (int i = 0; i < cranks; ++i) {
    const Vec3 at = corner + i * right / (cranks - 1);
    const BodyId crank = scene.add(bar("crank " + std::to_string(i), at, at + down, 0.05, 1));
    join(scene, JointType::revolute, top, crank, at);
    join(scene, JointType::revolute, crank, coupler, at + down);
  }
  if (free_body) {
    for (const double end : {-0.5, 0.5})
      for (const BodyId id : {top, coupler})
        scene.add(ground(scene.bodies[id.index].name + (end < 0 ? " right" : " left"), id, {0, 0, end * width}, friction));
    set_velocity(scene, {random.uniform(-1, 1), 0, random.uniform(-1, 0)});
  }
  return scene;
}

Mechanism redundant(Random& random) {
  Mechanism scene = random.integer(0, 3) == 0
                        ? scenes::four_bar({.angle = random.uniform(40, 100), .rate = random.uniform(0, 3)})
                        : parallelogram(random);
  scene.time_step = random.logarithmic(1e-3, 1e-2);
  vary(scene, random);
  return scene;
}

/// A slack, folded light chain with a bob of up to 1e4 times its mass, which falls and pulls it taut.
Mechanism snapping(Random& random) {
  Mechanism scene;
  const int links = random.integer(2, 10);
  const double length = 0.2, fold = random.uniform(0.2, 0.95), mass = random.logarithmic(1e-2, 1);
  Vec3 upper = Vec3::Zero();
  for (int i = 0; i < links; ++i) {
    const Vec3 lower = upper + length * Vec3((i % 2 ? -1 : 1) * fold, 0, -std::sqrt(1 - fold * fold));
    const BodyId id = scene.add(bar("link " + std::to_string(i), upper, lower, 0.02, mass));
    join(scene, JointType::spherical, {i - 1}, id, upper);
    upper = lower;
  }
  Body bob = box("bob", {0.3, 0.3, 0.3}, mass * links * random.logarithmic(1e2, 1e4));
  bob.position = upper - Vec3(0, 0, 0.15);
  join(scene, JointType::spherical, {links - 1}, scene.add(std::move(bob)), upper);
  scene.time_step = random.logarithmic(1e-3, 1e-2);
  vary(scene, random);
  return scene;
}

}  // namespace

const std::vector<Family>& families() {
  static const std::vector<Family> all{
      {"mass_ratio", "neighbours' masses 1e-6..1e6", mass_ratio},
      {"friction", "coefficient 1e-6..10", friction},
      {"time_step", "dt 1e-5..0.1 s", time_step},
      {"coplanar", "100 contacts in one plane", coplanar},
      {"spin", "10..1000 rad/s, |w| dt to 1.85", spin},
      {"wedging", "rods sliding at friction 1.5..10", wedging},
      {"far_contact", "10..200 m/s towards a culled contact", far_contact},
      {"redundant", "planar loops in space", redundant},
      {"snapping", "bob of 1e2..1e4 chain masses pulls it taut", snapping},
  };
  return all;
}

Mechanism scene(const Family& family, std::uint64_t seed, int index) {
  std::uint64_t mixed = seed;
  for (const char c : family.name) mixed = mixed * 1099511628211U + static_cast<unsigned char>(c);
  Random random(mixed * 0x9e3779b97f4a7c15U + static_cast<std::uint64_t>(index));
  Mechanism result = family.make(random);
  result.name = family.name + " " + std::to_string(index);
  return result;
}

}  // namespace campaign
