#include "joints.hpp"

#include <cmath>
#include <numbers>

#include "motor.hpp"

namespace physics {

Quat relative_rotation(const JointGeometry& g, const Pose& a, const Pose& b) {
  Quat e = a.q.conjugate() * b.q * g.orientation.conjugate();
  if (e.w() < 0) e.coeffs() = -e.coeffs();
  return e;
}

namespace {

/// Two unit vectors that complete `axis` to a right-handed frame, as rows; the axis is the third row.
Mat3 frame_about(const Vec3& axis) {
  Mat3 frame;
  frame.row(0) = axis.unitOrthogonal();
  frame.row(1) = axis.cross(frame.row(0).transpose());
  frame.row(2) = axis;
  return frame;
}

}  // namespace

int Joints::rows_of(const JointGeometry& geometry, const Motor* motor) {
  switch (geometry.type) {
    case JointType::fixed: return 6;
    case JointType::spherical: return 3;
    case JointType::revolute:
    case JointType::prismatic: return motor ? 6 : 5;
  }
  return 0;
}

void Joints::add(const JointGeometry& geometry, const Motor* motor, graphsolve::NodeId node) {
  Joint joint{};
  joint.nodes[0] = node;
  joint.node_count = 1;
  if (geometry.child >= 0) joint.nodes[joint.node_count++] = bodies_.node(geometry.child);
  if (geometry.parent >= 0) joint.nodes[joint.node_count++] = bodies_.node(geometry.parent);
  joints_.push_back(joint);
  set(size() - 1, geometry, motor);
}

void Joints::set(int i, const JointGeometry& geometry, const Motor* motor) {
  Joint& joint = joints_[i];
  joint.geometry = geometry;
  joint.motor = motor;
  joint.translation_rows = geometry.type == JointType::prismatic ? 2 : 3;
  joint.rotation_rows = geometry.type == JointType::spherical ? 0 : geometry.type == JointType::revolute ? 2 : 3;
  joint.rows = rows_of(geometry, motor);
  const Mat3 frame = frame_about(geometry.axis);
  joint.translation = geometry.type == JointType::prismatic ? frame : Mat3::Identity();
  joint.rotation = geometry.type == JointType::revolute ? frame : Mat3::Identity();
}

void Joints::wire(const graphsolve::Wiring& wiring) {
  for (Joint& joint : joints_) {
    const auto own = joint.nodes[0];
    joint.row = wiring.row(own);
    joint.own = wiring.block(own, own);
    const auto connect = [&](int body, int& row, graphsolve::BlockHandle& to, graphsolve::BlockHandle& from,
                             graphsolve::BlockHandle& own_block) {
      if (body < 0) return;
      own_block = wiring.block(bodies_.node(body), bodies_.node(body));
      row = wiring.row(bodies_.node(body));
      to = wiring.block(own, bodies_.node(body));
      from = wiring.block(bodies_.node(body), own);
    };
    connect(joint.geometry.parent, joint.parent_row, joint.to_parent, joint.from_parent, joint.parent_own);
    connect(joint.geometry.child, joint.child_row, joint.to_child, joint.from_child, joint.child_own);
  }
}

void Joints::violation(const Joint& joint, const Pose& a, const Pose& b, double* g) const {
  const JointGeometry& geometry = joint.geometry;
  const Vec3 d = b.x + b.rotation * geometry.child_point - a.x - a.rotation * geometry.parent_point;
  if (joint.translation_rows == 3) {
    for (int i = 0; i < 3; ++i) g[i] = d[i];
  } else {
    const Vec3 local = a.rotation.transpose() * d;
    for (int i = 0; i < joint.translation_rows; ++i) g[i] = joint.translation.row(i).dot(local);
  }
  if (joint.rotation_rows == 0) return;
  const Quat e = relative_rotation(geometry, a, b);
  for (int i = 0; i < joint.rotation_rows; ++i)
    g[joint.translation_rows + i] = 2 * joint.rotation.row(i).dot(e.vec());
}

/// Derivatives by (x, theta) of either body over dt; with turn = I the force directions.
void Joints::jacobian(const Joint& joint, const Pose& a, const Pose& b, Matrix6& parent, Matrix6& child) const {
  const JointGeometry& g = joint.geometry;
  const Mat3 child_lever = -b.rotation * skew(g.child_point);
  const int nt = joint.translation_rows;
  if (nt == 3) {
    child.topLeftCorner<3, 3>().setIdentity();
    child.topRightCorner<3, 3>().noalias() = child_lever * b.turn;
    parent.topLeftCorner<3, 3>() = -Mat3::Identity();
    parent.topRightCorner<3, 3>().noalias() = a.rotation * skew(g.parent_point) * a.turn;
  } else {
    const Mat3 local = joint.translation * a.rotation.transpose();
    const Vec3 arm = a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x);
    child.topLeftCorner(nt, 3) = local.topRows(nt);
    child.topRightCorner(nt, 3) = (local * child_lever * b.turn).topRows(nt);
    parent.topLeftCorner(nt, 3) = -local.topRows(nt);
    parent.topRightCorner(nt, 3) = (joint.translation * skew(arm) * a.turn).topRows(nt);
  }
  const int nr = joint.rotation_rows;
  if (nr > 0) {
    // d(2 vec e) = (w I + [v]x) R_off theta_b = -(w I - [v]x) theta_a
    const Quat e = relative_rotation(g, a, b);
    const Mat3 v = skew(e.vec()), w = e.w() * Mat3::Identity();
    const Mat3 by_child = joint.rotation * (w + v) * g.orientation.toRotationMatrix() * b.turn;
    const Mat3 by_parent = -joint.rotation * (w - v) * a.turn;
    child.block(nt, 0, nr, 3).setZero();
    child.block(nt, 3, nr, 3) = by_child.topRows(nr);
    parent.block(nt, 0, nr, 3).setZero();
    parent.block(nt, 3, nr, 3) = by_parent.topRows(nr);
  }
  if (!joint.motor) return;
  if (g.type == JointType::revolute) {
    // Derivative of 2 atan2(axis . v, w), exact off the hinge's manifold too.
    const Quat e = relative_rotation(g, a, b);
    const double along = g.axis.dot(e.vec()), square = e.w() * e.w() + along * along;
    const Vec3 even = (e.w() * e.w() * g.axis + along * e.vec()) / square, odd = e.w() / square * g.axis.cross(e.vec());
    child.row(5).setZero();
    child.row(5).tail<3>() = (even + odd).transpose() * g.orientation.toRotationMatrix() * b.turn;
    parent.row(5).setZero();
    parent.row(5).tail<3>() = -(even - odd).transpose() * a.turn;
  } else {
    const Vec3 arm = a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x);
    const Eigen::RowVector3d axis = g.axis.transpose() * a.rotation.transpose();
    child.row(5).head<3>() = axis;
    child.row(5).tail<3>() = axis * child_lever * b.turn;
    parent.row(5).head<3>() = -axis;
    parent.row(5).tail<3>() = g.axis.transpose() * skew(arm) * a.turn;
  }
}

double Joints::coordinate(const Joint& joint, const Pose& a, const Pose& b) const {
  const JointGeometry& g = joint.geometry;
  if (g.type == JointType::prismatic)
    return g.axis.dot(a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x) - g.parent_point);
  const Quat e = relative_rotation(g, a, b);
  return 2 * std::atan2(g.axis.dot(e.vec()), e.w());
}

double Joints::motor_residual(Joint& joint, double lambda, double& diagonal) {
  const JointGeometry& g = joint.geometry;
  const Motor& motor = *joint.motor;
  const double dt = bodies_.dt;
  const double raw = coordinate(joint, bodies_.pose_next(g.parent), bodies_.pose_next(g.child));
  double change = raw - joint.coordinate;
  if (g.type == JointType::revolute) change = std::remainder(change, 2 * std::numbers::pi);  // follow full turns
  joint.next_coordinate = joint.coordinate + change;
  const double wanted = motor.stiffness * (joint.target - joint.next_coordinate) - motor.damping * change / dt;
  joint.limited = !(std::abs(wanted) < motor.limit);
  const double effort = joint.limited ? std::copysign(motor.limit, wanted) : wanted;
  diagonal = 1 / (joint.impulse_time * (motor.stiffness * dt + motor.damping));
  return (lambda - joint.impulse_time * effort) * diagonal;
}

void Joints::set_directions(Joint& joint, Pose parent, Pose child) {
  parent.turn = child.turn = Mat3::Identity();
  jacobian(joint, parent, child, joint.parent_force, joint.child_force);
  const JointGeometry& g = joint.geometry;
  const Vec3 point = child.x + child.rotation * g.child_point;
  const Pose& recorded = g.child >= 0 ? child : parent;
  joint.force_rotation = recorded.rotation;
  joint.force_arm = point - recorded.x;
}

/// With directions at `next` the torque p x R^T impulse turns with the body. (Of the rows in all three axes of the
/// world only; the others are left to converge as they do without it.)
void Joints::add_direction_derivative(const Joint& joint, const Vec3& impulse, double* values) const {
  if (joint.translation_rows != 3) return;
  const auto add = [&](int body, const graphsolve::BlockHandle& block, const Vec3& point, double sign) {
    if (body < 0) return;
    const Pose& pose = bodies_.next[body];
    const Vec3 local = pose.rotation.transpose() * impulse;
    Eigen::Map<Eigen::Matrix<double, 6, 6>>(values + block.offset).bottomRightCorner<3, 3>() -=
        sign * bodies_.dt * skew(point) * skew(local) * pose.turn;
  };
  add(joint.geometry.child, joint.child_own, joint.geometry.child_point, 1);
  add(joint.geometry.parent, joint.parent_own, joint.geometry.parent_point, -1);
}

void Joints::prepare(int i, double end_time, double impulse_time) {
  Joint& joint = joints_[i];
  joint.impulse_time = impulse_time;
  set_directions(joint, bodies_.pose_now(joint.geometry.parent), bodies_.pose_now(joint.geometry.child));
  if (joint.motor) joint.target = motor_target(*joint.motor, end_time);
}

void Joints::reset_coordinate(int i) {
  Joint& joint = joints_[i];
  if (!joint.motor) return;
  joint.coordinate =
      coordinate(joint, bodies_.pose_now(joint.geometry.parent), bodies_.pose_now(joint.geometry.child));
}

namespace {

/// residual -= force^T lambda, rows of one body
template <int N>
void push(double* residual, const Joints::Matrix6& force, const double* lambda) {
  for (int j = 0; j < 6; ++j) {
    double sum = 0;
    for (int i = 0; i < N; ++i) sum += force(i, j) * lambda[i];
    residual[j] -= sum;
  }
}

/// Blocks (joint, body) += derivative and (body, joint) -= force^T
template <int N>
void write(double* down, double* across, const Joints::Matrix6& derivative, const Joints::Matrix6& force) {
  for (int j = 0; j < 6; ++j)
    for (int i = 0; i < N; ++i) down[j * N + i] += derivative(i, j);
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < 6; ++j) across[i * 6 + j] -= force(i, j);
}

}  // namespace

void Joints::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  for (const int k : instances.index) {
    Joint& joint = joints_[k];
    switch (joint.rows) {
      case 3: evaluate_one<3>(joint, x, residual, values); break;
      case 5: evaluate_one<5>(joint, x, residual, values); break;
      default: evaluate_one<6>(joint, x, residual, values);
    }
  }
}

template <int N>
void Joints::evaluate_one(Joint& joint, std::span<const double> x, std::span<double> residual, double* values) {
  const Pose &a = bodies_.pose_next(joint.geometry.parent), &b = bodies_.pose_next(joint.geometry.child);
  if (bodies_.force_at_next) set_directions(joint, a, b);
  double g[6];
  violation(joint, a, b, g);
  const double rate = 1 / bodies_.dt;
  for (int i = 0; i < joint.translation_rows + joint.rotation_rows; ++i) residual[joint.row + i] += g[i] * rate;
  double diagonal = 0;
  if (joint.motor) residual[joint.row + 5] += motor_residual(joint, x[joint.row + 5], diagonal);
  const double* lambda = x.data() + joint.row;
  if (joint.child_row >= 0) push<N>(residual.data() + joint.child_row, joint.child_force, lambda);
  if (joint.parent_row >= 0) push<N>(residual.data() + joint.parent_row, joint.parent_force, lambda);
  if (!values) return;
  Matrix6 parent, child;
  jacobian(joint, a, b, parent, child);
  if (bodies_.force_at_next) add_direction_derivative(joint, Eigen::Map<const Vec3>(lambda), values);
  if (joint.motor) {
    values[joint.own.offset + 5 * 6 + 5] += diagonal;
    if (joint.limited) {  // the effort no longer answers to the velocity
      parent.row(5).setZero();
      child.row(5).setZero();
    }
  }
  if (joint.child_row >= 0)
    write<N>(values + joint.to_child.offset, values + joint.from_child.offset, child, joint.child_force);
  if (joint.parent_row >= 0)
    write<N>(values + joint.to_parent.offset, values + joint.from_parent.offset, parent, joint.parent_force);
}

double Joints::error(int i, const Pose& parent, const Pose& child) const {
  const Joint& joint = joints_[i];
  double g[6], largest = 0;
  violation(joint, parent, child, g);
  for (int r = 0; r < joint.translation_rows + joint.rotation_rows; ++r) largest = std::max(largest, std::abs(g[r]));
  return largest;
}

void Joints::impulse(int i, std::span<const double> x, Vec3& linear, Vec3& angular) const {
  const Joint& joint = joints_[i];
  const bool on_child = joint.geometry.child >= 0;
  const Matrix6& force = on_child ? joint.child_force : joint.parent_force;
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  for (int r = 0; r < joint.rows; ++r) wrench += force.row(r).transpose() * x[joint.row + r];
  linear = wrench.head<3>();
  angular = joint.force_rotation * wrench.tail<3>() - joint.force_arm.cross(linear);
  if (!on_child) linear = -linear, angular = -angular;
}

double Joints::motor_impulse(int i, std::span<const double> x) const { return x[joints_[i].row + 5]; }

double Joints::opening_rate(int i, std::span<const double> x) const {
  const Joint& joint = joints_[i];
  double largest = 0;
  for (int r = 0; r < joint.translation_rows + joint.rotation_rows; ++r) {
    double rate = 0;
    for (int j = 0; j < 6; ++j) {
      if (joint.child_row >= 0) rate += joint.child_force(r, j) * x[joint.child_row + j];
      if (joint.parent_row >= 0) rate += joint.parent_force(r, j) * x[joint.parent_row + j];
    }
    largest = std::max(largest, std::abs(rate));
  }
  return largest;
}

}  // namespace physics
