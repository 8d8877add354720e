#include <cmath>
#include <numbers>

#include "terms/joints.hpp"
#include "terms/motor.hpp"
#include "terms/rotation.hpp"

/// Coordinates of joints along their free axes, and how often hinges have turned.
namespace physics {

namespace {

constexpr double turn = 2 * std::numbers::pi;

/// An angle but for full turns, from -pi to pi.
double without_turns(double angle) { return angle - turn * std::round(angle / turn); }

}  // namespace

double Joints::coordinate(const Joint& joint, const Pose& a, const Pose& b) const {
  const JointGeometry& g = joint.geometry;
  if (g.type == JointType::prismatic)
    return g.axis.dot(a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x) - g.parent_point);
  const Quat e = relative_rotation(g, a, b);
  return 2 * std::atan2(g.axis.dot(e.vec()), e.w());
}

double Joints::coordinate(int i) const {
  const Joint& joint = joints_[i];
  const double now = coordinate(joint, bodies_.pose_now(joint.geometry.parent), bodies_.pose_now(joint.geometry.child));
  return counts_turns(joint) ? joint.coordinate + without_turns(now - joint.coordinate) : now;
}

double Joints::rate(int i, double h) const {
  const Joint& joint = joints_[i];
  const JointGeometry& g = joint.geometry;
  bool can_tell = h > 0;
  const auto before = [&](int body) {
    const Pose now = bodies_.pose_now(body);
    if (body < 0 || !can_tell) return now;
    const Vec3 w = bodies_.spin(body);
    can_tell = w.norm() * h < 2;  // after any step; a record may say more
    if (!can_tell) return now;
    const Quat q = rotate(now.q, -w, rotation_scalar(w, h), h);
    return Pose{now.x - h * bodies_.velocity(body), q, q.toRotationMatrix()};
  };
  const Pose parent = before(g.parent), child = before(g.child);
  if (!can_tell) return rate_of_velocities(g);
  const double change =
      coordinate(joint, bodies_.pose_now(g.parent), bodies_.pose_now(g.child)) - coordinate(joint, parent, child);
  return (g.type == JointType::revolute ? without_turns(change) : change) / h;
}

double Joints::rate_of_velocities(const JointGeometry& g) const {
  const Pose a = bodies_.pose_now(g.parent), b = bodies_.pose_now(g.child);
  const auto spin = [&](int body) { return body < 0 ? Vec3(Vec3::Zero()) : bodies_.spin(body); };
  const auto velocity = [&](int body) { return body < 0 ? Vec3(Vec3::Zero()) : bodies_.velocity(body); };
  if (g.type == JointType::revolute)
    return g.axis.dot(a.rotation.transpose() * (b.rotation * spin(g.child)) - spin(g.parent));
  const Vec3 of_child = velocity(g.child) + b.rotation * spin(g.child).cross(g.child_point);
  const Vec3 arm = a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x);
  return g.axis.dot(a.rotation.transpose() * (of_child - velocity(g.parent)) - spin(g.parent).cross(arm));
}

void Joints::reset_coordinate(int i) {
  Joint& joint = joints_[i];
  if (joint.motor || counts_turns(joint))
    joint.coordinate =
        coordinate(joint, bodies_.pose_now(joint.geometry.parent), bodies_.pose_now(joint.geometry.child));
}

void Joints::set_turn(int i, double told) {
  Joint& joint = joints_[i];
  if (counts_turns(joint)) joint.coordinate += turn * std::round((told - joint.coordinate) / turn);
}

/// Poses tell the angle of a hinge but for full turns; the effort of its spring and damper tells these.
void Joints::find_turn(int i, double effort, double time) {
  Joint& joint = joints_[i];
  const JointGeometry& g = joint.geometry;
  if (!joint.motor || g.type != JointType::revolute || !(joint.motor->stiffness > 0)) return;
  const Motor& motor = *joint.motor;
  const double angle = motor_target(motor, time) - (effort + motor.damping * rate_of_velocities(g)) / motor.stiffness;
  const double turns = (angle - joint.coordinate) / turn;
  // At its limit the effort only tells a bound of the angle: the turn next to it is taken.
  const bool limited = std::abs(effort) > motor.limit * (1 - 1e-9);
  joint.coordinate += turn * (!limited ? std::round(turns) : effort > 0 ? std::floor(turns) : std::ceil(turns));
}

}  // namespace physics
