#include <cmath>

#include "physics/scenes.hpp"
#include "scenes/parts.hpp"

namespace physics::scenes {

namespace {

const Link paper_link;  // 1 kg, 1 m, radius 0.05 m: paper, IV-A.2

Joint chain_joint(int index, BodyId parent, BodyId child, double length) {
  Joint joint;
  joint.name = "joint " + std::to_string(index);
  joint.type = JointType::spherical;
  joint.parent = parent;
  joint.child = child;
  joint.child_point = {0, 0, length / 2};
  if (!parent.is_world()) joint.parent_point = {0, 0, -length / 2};
  return joint;
}

}  // namespace

Mechanism snake(const Snake& p) {
  Mechanism scene;
  scene.name = "snake";
  scene.time_step = p.time_step;
  const Vec3 end(0, 0, paper_link.length / 2);
  // The heading winds about x by 30 degrees over 12 links, the height by 2 cm over 7 links: no two landings alike.
  const auto height = [&](int i) { return p.height + 0.01 * (1 - std::cos(2 * std::numbers::pi * i / 7)); };
  Vec3 upper(0, 0, height(0));
  for (int i = 0; i < p.links; ++i) {
    const double heading = 0.5 * std::sin(2 * std::numbers::pi * (i + 0.5) / 12);
    const double rise = height(i + 1) - height(i);
    const double run = std::sqrt(paper_link.length * paper_link.length - rise * rise);
    const Vec3 lower = upper + Vec3(run * std::cos(heading), run * std::sin(heading), rise);
    Body body = link("link " + std::to_string(i), paper_link, upper, lower);
    body.velocity = {0.2 * p.speed, p.speed, 0};
    const BodyId child{i};
    if (i == 0) {
      scene.add(ground_contact("upper end", child, end, p.friction));
    } else {
      Joint joint = chain_joint(i - 1, {i - 1}, child, paper_link.length);
      close_joint(scene, joint, body);
      scene.add(std::move(joint));
    }
    scene.add(std::move(body));
    scene.add(ground_contact("lower end " + std::to_string(i), child, -end, p.friction));
    upper = lower;
  }
  return scene;
}

Mechanism pendulum(const Pendulum& p) {
  Mechanism scene;
  scene.name = "pendulum";
  scene.time_step = p.time_step;
  Link part = paper_link;
  part.length = p.length;
  part.radius = 0.05 * p.length;
  const double angle = radians(p.angle);
  const Vec3 down(std::sin(angle), 0, -std::cos(angle));
  for (int i = 0; i < p.links; ++i) {
    Body body = planar_link("link " + std::to_string(i), part, i * p.length * down, (i + 1) * p.length * down);
    Joint joint = chain_joint(i, {i - 1}, {i}, p.length);
    if (p.joint == Hinge::revolute) {
      joint.type = JointType::revolute;
      joint.axis = Vec3::UnitY();
    }
    close_joint(scene, joint, body);
    scene.add(std::move(body));
    scene.add(std::move(joint));
  }
  return scene;
}

Mechanism hanging_bob(const HangingBob& p) {
  const double radius = 0.3;
  Pendulum chain;
  chain.links = p.links;
  chain.angle = p.angle;
  chain.length = 0.2;
  chain.time_step = p.time_step;
  Mechanism scene = pendulum(chain);
  scene.name = "hanging bob";
  Body bob = body("bob", sphere(radius), p.ratio * paper_link.mass, Vec3::Zero());
  bob.orientation = scene.bodies.back().orientation;
  Joint joint = chain_joint(p.links, {p.links - 1}, {p.links}, chain.length);
  joint.child_point = {0, 0, radius};
  close_joint(scene, joint, bob);
  scene.add(std::move(bob));
  scene.add(std::move(joint));
  return scene;
}

Mechanism loop(const Loop& p) {
  Mechanism scene;
  scene.name = "loop";
  scene.time_step = p.time_step;
  const double step = 2 * std::numbers::pi / p.links;
  const double radius = paper_link.length / (2 * std::sin(step / 2));
  const auto corner = [&](int i) -> Vec3 {
    const double angle = std::numbers::pi / 2 + step / 2 - step * i;
    return radius * Vec3(std::cos(angle), 0, std::sin(angle) - std::cos(step / 2));
  };
  for (int i = 0; i < p.links; ++i) {
    Body body = planar_link("link " + std::to_string(i), paper_link, corner(i), corner(i + 1));
    if (i > 0) {  // the rest turns as one about the top link, which lies on the x axis
      const Vec3 spin(p.swing, 0, 0);
      body.velocity = spin.cross(body.position);
      body.angular_velocity = body.orientation.conjugate() * spin;
    }
    scene.add(std::move(body));
  }
  Joint hold;
  hold.name = "hold";
  hold.type = JointType::fixed;
  hold.child = {0};
  hold.parent_point = scene.bodies[0].position;
  hold.orientation = scene.bodies[0].orientation;
  scene.add(std::move(hold));
  for (int i = 0; i < p.links; ++i) {
    scene.add(chain_joint(i, {i}, {(i + 1) % p.links}, paper_link.length));
  }
  return scene;
}

Mechanism stiff_hinge(const StiffHinge& p) {
  Pendulum bar;
  bar.joint = Hinge::revolute;
  bar.angle = -p.bend * 180 / std::numbers::pi;  // turning by +bend about y moves the lower end to -x
  bar.time_step = p.time_step;
  Mechanism scene = pendulum(bar);
  scene.name = "stiff hinge";
  Motor spring;
  spring.stiffness = p.stiffness;
  scene.joints[0].motor = spring;
  return scene;
}

}  // namespace physics::scenes
