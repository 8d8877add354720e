#include "mechanism/start_pose.hpp"

#include <algorithm>

namespace physics {

RigidMotion start_motion(const Mechanism& mechanism, BodyId body) {
  if (body.is_world()) return {};
  const Body& b = mechanism.bodies[body.index];
  return {b.position, b.velocity, b.orientation * b.angular_velocity};
}

double gap(const Joint& joint, const Frame& parent, const Frame& child) {
  const Vec3 apart = child.position + child.orientation * joint.child_point - parent.position - parent.orientation * joint.parent_point;
  if (joint.type != JointType::prismatic) return apart.stableNorm();
  const Vec3 axis = parent.orientation * joint.axis.normalized();
  return (apart - axis * axis.dot(apart)).stableNorm();
}

double bend(const Joint& joint, const Frame& parent, const Frame& child) {
  if (joint.type == JointType::spherical) return 0;
  const Quat relative = joint.orientation.conjugate() * parent.orientation.conjugate() * child.orientation;
  if (joint.type != JointType::revolute) return 2 * std::atan2(relative.vec().norm(), std::abs(relative.w()));
  const Vec3 axis = joint.orientation.conjugate() * joint.axis.normalized(), turned = relative * axis;
  return std::atan2(axis.cross(turned).norm(), axis.dot(turned));
}

double start_gap(const Mechanism& mechanism, const Joint& joint) {
  const auto frame = [&](BodyId id) {
    return id.is_world() ? Frame{} : Frame{mechanism.bodies[id.index].position, mechanism.bodies[id.index].orientation};
  };
  return gap(joint, frame(joint.parent), frame(joint.child));
}

bool Side::has(BodyId body) const {
  return body.is_world() ? held : std::find(bodies.begin(), bodies.end(), body.index) != bodies.end();
}

Side side_of(const Mechanism& mechanism, BodyId body, int without_joint) {
  Side side;
  if (body.is_world()) return {.bodies = {}, .held = true};
  std::vector<std::vector<BodyId>> neighbours(mechanism.bodies.size());
  for (int j = 0; j < static_cast<int>(mechanism.joints.size()); ++j) {
    const Joint& joint = mechanism.joints[j];
    if (j == without_joint) continue;
    neighbours[joint.child.index].push_back(joint.parent);
    if (!joint.parent.is_world()) neighbours[joint.parent.index].push_back(joint.child);
  }
  std::vector<bool> seen(mechanism.bodies.size());
  seen[body.index] = true;
  side.bodies.push_back(body.index);
  for (std::size_t i = 0; i < side.bodies.size(); ++i)
    for (const BodyId next : neighbours[side.bodies[i]]) {
      if (next.is_world()) {
        side.held = true;
      } else if (!seen[next.index]) {
        seen[next.index] = true;
        side.bodies.push_back(next.index);
      }
    }
  return side;
}

void displace(Mechanism& mechanism, const std::vector<int>& bodies, const Displacement& by, const RigidMotion& frame) {
  for (const int i : bodies) {
    Body& body = mechanism.bodies[i];
    const Vec3 relative_velocity = body.velocity - frame.at(body.position);
    const Vec3 relative_spin = body.orientation * body.angular_velocity - frame.angular_velocity;
    body.position = by.pivot + by.turn * (body.position - by.pivot) + by.shift;
    body.orientation = (by.turn * body.orientation).normalized();
    body.velocity = frame.at(body.position) + by.turn * relative_velocity;
    body.angular_velocity = body.orientation.conjugate() * (frame.angular_velocity + by.turn * relative_spin);
  }
}

void add_motion(Mechanism& mechanism, const std::vector<int>& bodies, const RigidMotion& motion) {
  for (const int i : bodies) {
    Body& body = mechanism.bodies[i];
    body.velocity += motion.at(body.position);
    body.angular_velocity += body.orientation.conjugate() * motion.angular_velocity;
  }
}

}  // namespace physics
