#include "terms/joints.hpp"
#include "terms/sensitivity.hpp"

namespace physics {

namespace {

/// A derivative of a unit quaternion (w, v): dw = scalar theta, dv = vector theta.
struct QuaternionRate {
  Eigen::RowVector3d scalar;
  Mat3 vector;
};

/// Derivative of  even +- odd,  the direction of a hinge's motor (joint_kernels.cpp), at e.
Mat3 hinge_direction_derivative(const Vec3& axis, const Quat& e, const QuaternionRate& by, double sign) {
  const Vec3 v = e.vec(), cross = axis.cross(v);
  const double w = e.w(), along = axis.dot(v), square = w * w + along * along;
  const Vec3 direction = (w * w * axis + along * v + sign * w * cross) / square;
  const Eigen::RowVector3d by_along = axis.transpose() * by.vector;
  Mat3 d =
      (2 * w * axis + sign * cross) * by.scalar + v * by_along + along * by.vector + sign * w * skew(axis) * by.vector;
  d -= direction * (2 * w * by.scalar + 2 * along * by_along);
  return d / square;
}

}  // namespace

/// Derivatives of the wrenches  force^T lambda  by the poses that the directions are taken at.
struct Joints::DirectionDerivative {
  Matrix6 child_by_child = Matrix6::Zero(), child_by_parent = Matrix6::Zero(), parent_by_child = Matrix6::Zero(),
          parent_by_parent = Matrix6::Zero();
  bool crossed = false;  ///< the two bodies' poses enter each other's wrench
};

/// World axes: torques p x R^T f. Axes of the parent: f = R_a c, on the child's point, against the parent's frame.
void Joints::differentiate_translation(const Joint& joint, std::span<const double> lambda,
                                       DirectionDerivative& d) const {
  const JointGeometry& g = joint.geometry;
  const Pose a = bodies_.pose_now(g.parent), b = bodies_.pose_now(g.child);
  if (translations(joint.kind) == 3) {
    const Vec3 f(lambda[0], lambda[1], lambda[2]);
    d.child_by_child.bottomRightCorner<3, 3>() += skew(g.child_point) * skew(b.rotation.transpose() * f);
    d.parent_by_parent.bottomRightCorner<3, 3>() -= skew(g.parent_point) * skew(a.rotation.transpose() * f);
    return;
  }
  const Mat3 locked = locked_translations(g);
  Vec3 c = locked.row(0).transpose() * lambda[0] + locked.row(1).transpose() * lambda[1];
  if (joint.motor) c += g.axis * lambda[5];
  const Vec3 arm = a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x);
  const Mat3 force_by_turn = -a.rotation * skew(c), to_parent = skew(c) * a.rotation.transpose();
  d.crossed = true;
  d.child_by_parent.topRightCorner<3, 3>() += force_by_turn;
  d.child_by_parent.bottomRightCorner<3, 3>() += skew(g.child_point) * b.rotation.transpose() * force_by_turn;
  d.child_by_child.bottomRightCorner<3, 3>() += skew(g.child_point) * skew(b.rotation.transpose() * (a.rotation * c));
  d.parent_by_parent.topRightCorner<3, 3>() -= force_by_turn;
  d.parent_by_parent.bottomLeftCorner<3, 3>() -= to_parent;
  d.parent_by_parent.bottomRightCorner<3, 3>() += skew(c) * skew(arm);
  d.parent_by_child.bottomLeftCorner<3, 3>() += to_parent;
  d.parent_by_child.bottomRightCorner<3, 3>() -= to_parent * b.rotation * skew(g.child_point);
}

/// Torques R_off^T (w r - v x r) on the child, -(w r + v x r) on the parent, with e = (w, v) between the two.
void Joints::differentiate_rotation(const Joint& joint, std::span<const double> lambda, DirectionDerivative& d) const {
  const JointGeometry& g = joint.geometry;
  const bool hinge_motor = joint.motor && g.type == JointType::revolute;
  if (rotations(joint.kind) == 0) return;
  const Quat e = relative_rotation(g, bodies_.pose_now(g.parent), bodies_.pose_now(g.child));
  const Mat3 offset = g.orientation.toRotationMatrix(), v = skew(e.vec()), w = e.w() * Mat3::Identity();
  const QuaternionRate by_child{-0.5 * e.vec().transpose() * offset, 0.5 * (w + v) * offset};
  const QuaternionRate by_parent{0.5 * e.vec().transpose(), -0.5 * (w - v)};
  const Mat3 locked = locked_rotations(g);
  Vec3 r = Vec3::Zero();
  for (int i = 0; i < rotations(joint.kind); ++i) r += locked.row(i).transpose() * lambda[translations(joint.kind) + i];
  const auto on_child = [&](const QuaternionRate& by) -> Mat3 {
    Mat3 m = r * by.scalar + skew(r) * by.vector;
    if (hinge_motor) m += lambda[5] * hinge_direction_derivative(g.axis, e, by, 1);
    return offset.transpose() * m;
  };
  const auto on_parent = [&](const QuaternionRate& by) -> Mat3 {
    Mat3 m = skew(r) * by.vector - r * by.scalar;
    if (hinge_motor) m -= lambda[5] * hinge_direction_derivative(g.axis, e, by, -1);
    return m;
  };
  d.crossed = true;
  d.child_by_child.bottomRightCorner<3, 3>() += on_child(by_child);
  d.child_by_parent.bottomRightCorner<3, 3>() += on_child(by_parent);
  d.parent_by_child.bottomRightCorner<3, 3>() += on_parent(by_child);
  d.parent_by_parent.bottomRightCorner<3, 3>() += on_parent(by_parent);
}

/// The joint's own rows: g(z2) / dt, and a motor that also knows its coordinate at z1.
void Joints::differentiate_rows(const Joint& joint, Sensitivity& out) const {
  const JointGeometry& g = joint.geometry;
  const int rows = physics::rows_of(joint.kind);
  Matrix6 parent, child;
  directions(g, joint.motor, bodies_.pose_next(g.parent), bodies_.pose_next(g.child), parent, child);
  const double damped =
      joint.motor ? joint.motor->damping / (joint.motor->stiffness * bodies_.dt + joint.motor->damping) : 0;
  const auto push = [&](int body, Matrix6& by_next, const Matrix6& force) {
    if (body < 0) return;
    by_next.topRightCorner(rows, 3) *= out.carry[body];
    if (joint.motor) by_next.row(5) -= damped * force.row(5);
    if (limited(joint)) by_next.row(5).setZero();
    out.across.push_back({joint.row, rows, body, by_next / bodies_.dt});
  };
  push(g.parent, parent, parent_force(joint));
  push(g.child, child, child_force(joint));
}

/// An effort on the free coordinate: added to what the motor wants, or along the axis of a joint without one.
void Joints::differentiate_effort(const Joint& joint, double impulse_time, Sensitivity& out) const {
  const JointGeometry& g = joint.geometry;
  if (g.type != JointType::revolute && g.type != JointType::prismatic) return;
  if (joint.motor) {
    Vector6 value = Vector6::Zero();
    if (!limited(joint)) value[0] = -1 / (joint.motor->stiffness * bodies_.dt + joint.motor->damping);
    out.effort.push_back({g.source, joint.row + 5, 1, value});
    return;
  }
  static const Motor any;  // for its direction
  Matrix6 parent, child;
  directions(g, &any, bodies_.pose_now(g.parent), bodies_.pose_now(g.child), parent, child);
  const auto push = [&](int body, int row, const Matrix6& force) {
    if (body >= 0) out.effort.push_back({g.source, row, 6, -impulse_time * force.row(5).transpose()});
  };
  push(g.parent, joint.parent_row, parent);
  push(g.child, joint.child_row, child);
}

void Joints::differentiate(std::span<const double> x, const StepStart& start, Sensitivity& out) const {
  for (const Joint& joint : joints_) {
    differentiate_rows(joint, out);
    differentiate_effort(joint, start.impulse_time, out);
    const std::span<const double> lambda = x.subspan(joint.row, physics::rows_of(joint.kind));
    DirectionDerivative d;
    differentiate_translation(joint, lambda, d);
    differentiate_rotation(joint, lambda, d);
    const int a = joint.geometry.parent, b = joint.geometry.child;
    if (a >= 0) out.pose[a] -= d.parent_by_parent;
    if (b >= 0) out.pose[b] -= d.child_by_child;
    if (!d.crossed || a < 0 || b < 0) continue;
    out.across.push_back({joint.child_row, 6, a, -d.child_by_parent});
    out.across.push_back({joint.parent_row, 6, b, -d.parent_by_child});
  }
}

}  // namespace physics
