#include "terms/joints.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "terms/motor.hpp"

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

JointRows rows_kind(const JointGeometry& geometry, const Motor* motor) {
  switch (geometry.type) {
    case JointType::fixed: break;
    case JointType::spherical: return JointRows::spherical;
    case JointType::revolute: return motor ? JointRows::revolute_motor : JointRows::revolute;
    case JointType::prismatic: return motor ? JointRows::prismatic_motor : JointRows::prismatic;
  }
  return JointRows::fixed;
}

void set_lane(const JointGeometry& geometry, JointPoints& points, int lane) {
  for (int k = 0; k < 3; ++k) {
    points.child[k][lane] = geometry.child_point[k];
    points.parent[k][lane] = geometry.parent_point[k];
  }
}

void set_lane(const JointGeometry& geometry, JointFrames& frames, int lane) {
  const Mat3 frame = frame_about(geometry.axis), orientation = geometry.orientation.toRotationMatrix();
  for (int k = 0; k < 3; ++k) {
    frames.axis[k][lane] = geometry.axis[k];
    for (int side = 0; side < 2; ++side) frames.side[side][k][lane] = frame(side, k);
  }
  for (int k = 0; k < 4; ++k) frames.orientation[k][lane] = geometry.orientation.coeffs()[k];
  for (int k = 0; k < 9; ++k) frames.orientation_matrix[k][lane] = orientation.data()[k];
}

/// Rows x 6 of one lane.
Joints::Matrix6 rows_at(const Octet* entries, int rows, int lane) {
  Joints::Matrix6 m = Joints::Matrix6::Zero();
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < 6; ++c) m(r, c) = entries[6 * r + c][lane];
  return m;
}

}  // namespace

int Joints::rows_of(const JointGeometry& geometry, const Motor* motor) {
  return physics::rows_of(rows_kind(geometry, motor));
}

Mat3 Joints::locked_translations(const JointGeometry& geometry) {
  return geometry.type == JointType::prismatic ? frame_about(geometry.axis) : Mat3::Identity();
}

Mat3 Joints::locked_rotations(const JointGeometry& geometry) {
  return geometry.type == JointType::revolute ? frame_about(geometry.axis) : Mat3::Identity();
}

void Joints::reserve(int joints) {
  joints_.reserve(joints);
}

void Joints::add(const JointGeometry& geometry, const Motor* motor, graphsolve::NodeId node) {
  Joint joint{
      .geometry = geometry, .motor = motor, .kind = rows_kind(geometry, motor), .nodes = {node}, .node_count = 1};
  if (geometry.child >= 0) joint.nodes[joint.node_count++] = bodies_.node(geometry.child);
  if (geometry.parent >= 0) joint.nodes[joint.node_count++] = bodies_.node(geometry.parent);
  joints_.push_back(joint);
}

void Joints::set(int i, const JointGeometry& geometry, const Motor* motor) {
  Joint& joint = joints_[i];
  joint.geometry = geometry;
  joint.motor = motor;
  joint.kind = rows_kind(geometry, motor);
  if (joint.place < 0) return;
  const int octet = octet_of(joint.place), lane = lane_of(joint.place), frames = octets_[octet].frames;
  set_lane(geometry, points_[octet], lane);
  if (frames >= 0) set_lane(geometry, frames_[frames], lane);
}

void Joints::violation(const Joint& joint, const Pose& a, const Pose& b, double* g) const {
  const JointGeometry& geometry = joint.geometry;
  const Vec3 d = b.x + b.rotation * geometry.child_point - a.x - a.rotation * geometry.parent_point;
  const int translations = physics::translations(joint.kind);
  if (translations == 3) {
    for (int i = 0; i < 3; ++i) g[i] = d[i];
  } else {
    const Mat3 locked = locked_translations(geometry);
    const Vec3 local = a.rotation.transpose() * d;
    for (int i = 0; i < translations; ++i) g[i] = locked.row(i).dot(local);
  }
  if (rotations(joint.kind) == 0) return;
  const Mat3 locked = locked_rotations(geometry);
  const Quat e = relative_rotation(geometry, a, b);
  for (int i = 0; i < rotations(joint.kind); ++i) g[translations + i] = 2 * locked.row(i).dot(e.vec());
}

void Joints::directions(const JointGeometry& geometry, const Motor* motor, const Pose& a, const Pose& b,
                        Matrix6& parent, Matrix6& child) {
  JointPoints points;
  JointFrames frames;
  Octet forces[2][36], stands[7], poses[2][16];
  set_lane(geometry, points, 0);
  set_lane(geometry, frames, 0);
  JointTask task;
  task.kind = rows_kind(geometry, motor);
  task.points = &points;
  task.frames = &frames;
  task.child_force = forces[0];
  task.parent_force = forces[1];
  task.stands = stands;
  task.used = 1;
  for (int k = 0; k < 16; ++k) {
    poses[0][k][0] = a.x.data()[k];
    poses[1][k][0] = b.x.data()[k];
  }
  task.parents = poses[0];
  task.children = poses[1];
  joint_kernels().aim(task);
  for (int r = 0; translations(task.kind) == 3 && r < 3; ++r) {
    forces[0][7 * r][0] = 1;
    forces[1][7 * r][0] = -1;
  }
  parent = rows_at(forces[1], 6, 0);
  child = rows_at(forces[0], 6, 0);
}

Joints::Matrix6 Joints::parent_force(const Joint& joint) const {
  const int rows = physics::rows_of(joint.kind);
  return rows_at(&forces_[octets_[octet_of(joint.place)].forces + 6 * rows], rows, lane_of(joint.place));
}

Joints::Matrix6 Joints::child_force(const Joint& joint) const {
  return rows_at(&forces_[octets_[octet_of(joint.place)].forces], physics::rows_of(joint.kind), lane_of(joint.place));
}

void Joints::prepare(int i, double end_time, double impulse_time) {
  const Joint& joint = joints_[i];
  if (!joint.motor) return;
  MotorOctet& m = motor_octet(joint);
  const int lane = lane_of(joint.place);
  m.stiffness[lane] = joint.motor->stiffness;
  m.damping[lane] = joint.motor->damping;
  m.limit[lane] = joint.motor->limit;
  m.target[lane] = motor_target(*joint.motor, end_time);
  m.coordinate[lane] = joint.coordinate;
  m.impulse_time[lane] = impulse_time;
}

JointError Joints::error(int i, const Pose& parent, const Pose& child) const {
  const Joint& joint = joints_[i];
  double g[6];
  JointError error;
  violation(joint, parent, child, g);
  for (int r = 0; r < constraints(joint.kind); ++r) {
    double& largest = r < translations(joint.kind) ? error.distance : error.angle;
    largest = std::max(largest, std::abs(g[r]));
  }
  return error;
}

void Joints::impulse(int i, std::span<const double> x, Vec3& linear, Vec3& angular) const {
  const Joint& joint = joints_[i];
  const bool on_child = joint.geometry.child >= 0;
  const Matrix6 force = on_child ? child_force(joint) : parent_force(joint);
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  for (int r = 0; r < rows(i); ++r) wrench += force.row(r).transpose() * x[joint.row + r];
  linear = wrench.head<3>();
  const Octet* stands = wrenches_[octet_of(joint.place)].stands;
  const auto number = [&](int k) { return stands[k][lane_of(joint.place)]; };
  const Quat orientation(number(3), number(0), number(1), number(2));
  angular = orientation * wrench.tail<3>() - Vec3(number(4), number(5), number(6)).cross(linear);
  if (!on_child) linear = -linear, angular = -angular;
}

double Joints::motor_impulse(int i, std::span<const double> x) const { return x[joints_[i].row + 5]; }

double Joints::opening_rate(int i, std::span<const double> x) const {
  const Joint& joint = joints_[i];
  const Rows rates = opening(joint, x);
  double largest = 0;
  for (int r = 0; r < constraints(joint.kind); ++r) largest = std::max(largest, std::abs(rates[r]));
  return largest;
}

void Joints::subtract_opening(int i, std::span<const double> x, std::span<double> r) const {
  const Joint& joint = joints_[i];
  const Rows rates = opening(joint, x);
  for (int k = 0; k < constraints(joint.kind); ++k) r[joint.row + k] -= rates[k];
}

Joints::Rows Joints::opening(const Joint& joint, std::span<const double> x) const {
  const Matrix6 on_child = child_force(joint), on_parent = parent_force(joint);
  Rows rates{};
  for (int r = 0; r < constraints(joint.kind); ++r)
    for (int j = 0; j < 6; ++j) {
      if (joint.child_row >= 0) rates[r] += on_child(r, j) * x[joint.child_row + j];
      if (joint.parent_row >= 0) rates[r] += on_parent(r, j) * x[joint.parent_row + j];
    }
  return rates;
}

}  // namespace physics
