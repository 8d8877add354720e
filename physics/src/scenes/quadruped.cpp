#include <array>
#include <cmath>

#include "physics/scenes.hpp"
#include "scenes/parts.hpp"

namespace physics::scenes {

namespace {

// Figures of the Unitree A1 from the maker's published description (unitree_ros, a1_description), SI units.
// Links held by fixed joints are merged, inertias moved by the parallel-axis rule: trunk + imu, calf + foot; the
// thigh shoulder has no mass. Frames sit at the joints. front = +1 or -1 (rear), side = +1 (left) or -1 (right).

struct Part {
  double mass;
  Vec3 centre;                  // of mass, in the link's frame
  double xx, xy, xz, yy, yz, zz;  // about the centre of mass
};

Part trunk_part() {
  return {6.001, {0, 0.004099316780536578, -0.0004999166805532411}, 0.01595331705715714, -3.66e-05, -6.11e-05,
          0.03789990024995834, -2.7497950341609733e-05, 0.0457542168071988};
}
Part hip_part(double front, double side) {
  return {0.696, {-0.003311 * front, 0.000635 * side, 3.1e-05}, 0.000469246, -9.409e-06 * front * side,
          -3.42e-07 * front, 0.00080749, -4.66e-07 * side, 0.000552929};
}
Part thigh_part(double side) {
  return {1.013, {-0.003237, -0.022327 * side, -0.027326}, 0.005529065, 4.825e-06 * side, 0.000343869,
          0.005139339, 2.2448e-05 * side, 0.001367788};
}
Part calf_part() {
  return {0.226, {0.004726592920353982, 0, -0.13197525663716814}, 0.003385566451939115, 0,
          -0.00016742735341238938, 0.003403441389465664, 0, 4.385093752654867e-05};
}

const Vec3 hip_point(double front, double side) { return {0.1805 * front, 0.047 * side, 0}; }  // in the trunk
const Vec3 thigh_point(double side) { return {0, 0.0838 * side, 0}; }                          // in the hip
constexpr double segment_length = 0.2;  // thigh to calf, and calf to foot [m]
constexpr double foot_radius = 0.02;
constexpr double effort_limit = 33.5;  // [N m]

// Our own choice of stance, gait and drives.
constexpr double thigh_angle = 0.8, calf_angle = -1.6;  // the foot under the hip [rad]
constexpr double clearance = 5e-4;                      // of the feet at the start [m]
constexpr double stiffness = 120, damping = 3;          // [N m/rad], [N m s/rad]

Body part_body(std::string name, const Part& part, const Shape& shape) {
  Body body;
  body.name = std::move(name);
  body.mass = part.mass;
  body.inertia << part.xx, part.xy, part.xz, part.xy, part.yy, part.yz, part.xz, part.yz, part.zz;
  body.shape = shape;
  return body;
}

struct Leg {
  std::string name;
  double front, side;
  double phase;  // of the gait [rad]
};

/// Targets of thigh and calf: the foot moves on the ellipse x = -stride cos(phase), z = lift sin(phase) to first
/// order. About the stance a turn of the calf alone lifts the foot, and thigh and calf together carry it along x.
struct LegTargets {
  SineTarget thigh, calf;
};
LegTargets leg_targets(const Quadruped& p, double phase) {
  const double run = segment_length * std::cos(thigh_angle), rise = segment_length * std::sin(thigh_angle);
  LegTargets targets;
  const double calf = p.lift / rise;             // calf = calf_angle - calf sin(phase)
  const double cosine = p.stride / (2 * run);    // thigh = thigh_angle + cosine cos + sine sin
  const double sine = calf / 2;
  targets.thigh = {thigh_angle, std::hypot(cosine, sine), p.frequency, phase + std::atan2(cosine, sine)};
  targets.calf = {calf_angle, -calf, p.frequency, phase};
  if (p.frequency <= 0) targets = {{thigh_angle, 0, 0, 0}, {calf_angle, 0, 0, 0}};
  return targets;
}

double value_at_start(const SineTarget& target) {
  return target.offset + target.amplitude * std::sin(target.phase);
}

/// Adds one link behind a revolute joint, turned to the joint's target at the start.
struct Segment {
  std::string name;
  Part part;
  Shape shape;
  BodyId parent;
  Vec3 parent_point;  // from the parent's centre of mass
  Vec3 axis;
  SineTarget target;
};
BodyId add_segment(Mechanism& scene, const Segment& segment) {
  Joint joint;
  joint.name = segment.name + " joint";
  joint.type = JointType::revolute;
  joint.parent = segment.parent;
  joint.child = {static_cast<int>(scene.bodies.size())};
  joint.parent_point = segment.parent_point;
  joint.child_point = -segment.part.centre;
  joint.axis = segment.axis;
  Motor motor;
  motor.stiffness = stiffness;
  motor.damping = damping;
  motor.limit = effort_limit;
  if (segment.target.amplitude == 0) {
    motor.target = segment.target.offset;
  } else {
    motor.target = segment.target;
  }
  joint.motor = motor;
  Body body = part_body(segment.name, segment.part, segment.shape);
  body.orientation = (scene.bodies[segment.parent.index].orientation *
                      rotation(segment.axis, value_at_start(segment.target))).normalized();
  close_joint(scene, joint, body);
  scene.add(std::move(joint));
  return scene.add(std::move(body));
}

void add_leg(Mechanism& scene, const Leg& leg, const Quadruped& p) {
  const LegTargets targets = leg_targets(p, leg.phase);
  const Part trunk = trunk_part(), hip = hip_part(leg.front, leg.side), thigh = thigh_part(leg.side),
             calf = calf_part();
  const BodyId hip_id = add_segment(scene, {leg.name + " hip", hip, cylinder(0.046, 0.04), {0},
                                            hip_point(leg.front, leg.side) - trunk.centre, Vec3::UnitX(), {}});
  const BodyId thigh_id = add_segment(scene, {leg.name + " thigh", thigh, box({0.034, 0.0245, segment_length}), hip_id,
                                              thigh_point(leg.side) - hip.centre, Vec3::UnitY(), targets.thigh});
  const BodyId calf_id = add_segment(scene, {leg.name + " calf", calf, box({0.016, 0.016, segment_length}), thigh_id,
                                             Vec3(0, 0, -segment_length) - thigh.centre, Vec3::UnitY(), targets.calf});
  Contact foot = ground_contact(leg.name + " foot", calf_id, Vec3(0, 0, -segment_length) - calf.centre, p.friction);
  foot.radius = foot_radius;
  scene.add(std::move(foot));
}

}  // namespace

Mechanism quadruped(const Quadruped& p) {
  Mechanism scene;
  scene.name = "quadruped";
  scene.time_step = p.time_step;
  scene.add(part_body("trunk", trunk_part(), box({0.267, 0.194, 0.114})));
  const double half = std::numbers::pi;
  const std::array<Leg, 4> legs{Leg{"front right", 1, -1, 0}, Leg{"front left", 1, 1, half},
                                Leg{"rear right", -1, -1, half}, Leg{"rear left", -1, 1, 0}};
  for (const Leg& leg : legs) add_leg(scene, leg, p);

  double lowest = 0;  // of the feet, with the trunk at the origin
  for (const Contact& foot : scene.contacts) {
    const Body& calf = scene.bodies[foot.body.index];
    lowest = std::min(lowest, (calf.position + calf.orientation * foot.point).z() - foot.radius);
  }
  for (Body& body : scene.bodies) body.position.z() += clearance - lowest;
  return scene;
}

}  // namespace physics::scenes
