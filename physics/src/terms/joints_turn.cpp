#include <cmath>
#include <numbers>

#include "terms/joints.hpp"
#include "terms/motor.hpp"

namespace physics {

/// Poses tell the angle of a hinge but for full turns; the effort of its spring and damper tells these.
void Joints::find_turn(int i, double effort, double time, std::span<const double> x) {
  Joint& joint = joints_[i];
  const JointGeometry& g = joint.geometry;
  if (!joint.motor || g.type != JointType::revolute || !(joint.motor->stiffness > 0)) return;
  const auto spin = [&](int row) { return row < 0 ? Vec3(Vec3::Zero()) : Vec3(x[row + 3], x[row + 4], x[row + 5]); };
  const Mat3 to_parent = bodies_.pose_now(g.parent).rotation.transpose() * bodies_.pose_now(g.child).rotation;
  const double rate = g.axis.dot(to_parent * spin(joint.child_row) - spin(joint.parent_row));
  const Motor& motor = *joint.motor;
  const double angle = motor_target(motor, time) - (effort + motor.damping * rate) / motor.stiffness;
  const double turns = (angle - joint.coordinate) / (2 * std::numbers::pi);
  // At its limit the effort only tells a bound of the angle: the turn next to it is taken.
  const bool limited = std::abs(effort) > motor.limit * (1 - 1e-9);
  joint.coordinate += 2 * std::numbers::pi * (!limited ? std::round(turns) : effort > 0 ? std::floor(turns) : std::ceil(turns));
}

}  // namespace physics
