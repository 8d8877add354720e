#include "joints.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "motor.hpp"
#include "simd/placement.hpp"

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

void set_octet(const JointGeometry& geometry, const Mat3& frame, JointOctet& octet, int lane) {
  const Mat3 orientation = geometry.orientation.toRotationMatrix();
  for (int k = 0; k < 3; ++k) {
    octet.child_point[k][lane] = geometry.child_point[k];
    octet.parent_point[k][lane] = geometry.parent_point[k];
    octet.axis[k][lane] = geometry.axis[k];
    for (int side = 0; side < 2; ++side) octet.side[side][k][lane] = frame(side, k);
  }
  for (int k = 0; k < 4; ++k) octet.orientation[k][lane] = geometry.orientation.coeffs()[k];
  for (int k = 0; k < 9; ++k) octet.orientation_matrix[k][lane] = orientation.data()[k];
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
  to_aim_.reserve(joints_.size());
  wrenches_.emplace_back();
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
  if (joint.place >= 0) set_octet(geometry, frame, octets_[octet_of(joint.place)], lane_of(joint.place));
}

void Joints::wire(const graphsolve::Wiring& wiring) {
  if (joints_.empty()) return;
  for (Joint& joint : joints_) {
    const auto own = joint.nodes[0];
    joint.row = wiring.row(own);
    joint.own = wiring.block(own, own);
    const auto connect = [&](int body, int& row, graphsolve::BlockHandle& to, graphsolve::BlockHandle& from,
                             graphsolve::BlockHandle& own_block) {
      if (body < 0) return;
      own_block = wiring.block(bodies_.node(body), bodies_.node(body));
      row = wiring.row(bodies_.node(body));
      to = wiring.claim(own, bodies_.node(body));
      from = wiring.claim(bodies_.node(body), own);
    };
    connect(joint.geometry.parent, joint.parent_row, joint.to_parent, joint.from_parent, joint.parent_own);
    connect(joint.geometry.child, joint.child_row, joint.to_child, joint.from_child, joint.child_own);
  }
  place_in_octets();
}

void Joints::place_in_octets() {
  std::vector<Placed> placed;
  for (const Joint& joint : joints_) placed.push_back({static_cast<int>(rows_kind(joint.geometry, joint.motor)), joint.own});
  const std::vector<int> places = places_in_octets(placed);
  const int octets = octets_for(1 + *std::max_element(places.begin(), places.end()));
  const std::vector<JointOctet> before = std::exchange(octets_, std::vector<JointOctet>(octets));
  const std::vector<MotorOctet> motors_before = std::exchange(motors_, std::vector<MotorOctet>(octets));
  octet_rows_.assign(octets, {});
  kernels_ = joint_kernels();
  blocks_.assign(octets, {});
  joint_at_.assign(octets * graphsolve::simd::lanes, -1);
  groups_.resize(octets);
  for (int i = 0; i < size(); ++i) {
    Joint& joint = joints_[i];
    const int octet = octet_of(places[i]), lane = lane_of(places[i]);
    if (joint.place >= 0) {
      copy_lane(before[octet_of(joint.place)], lane_of(joint.place), octets_[octet], lane);
      copy_lane(motors_before[octet_of(joint.place)], lane_of(joint.place), motors_[octet], lane);
    }
    joint.place = places[i];
    joint_at_[joint.place] = i;
    octet_rows_[octet] = static_cast<JointRows>(placed[i].kind);
    set(i, joint.geometry, joint.motor);
    JointBlocks& blocks = blocks_[octet];
    blocks.own.set(lane, joint.own);
    const auto& g = joint.geometry;
    if (g.child >= 0) blocks.to_child.set(lane, joint.to_child), blocks.from_child.set(lane, joint.from_child);
    if (g.parent >= 0) blocks.to_parent.set(lane, joint.to_parent), blocks.from_parent.set(lane, joint.from_parent);
  }
  for (JointBlocks& blocks : blocks_)
    for (auto* some : {&blocks.own, &blocks.to_child, &blocks.from_child, &blocks.to_parent, &blocks.from_parent}) some->finish();
  find_neighbours();
}

/// Octets of bodies that lie in the lanes of their joints.
void Joints::find_neighbours() {
  neighbours_.assign(octets_.size(), {});
  for (int octet = 0; octet < static_cast<int>(octets_.size()); ++octet) {
    constexpr int lanes = graphsolve::simd::lanes;
    std::array<int, lanes> parent, child;
    for (int l = 0; l < lanes; ++l) {
      const int i = joint_at_[octet * lanes + l];
      parent[l] = i < 0 ? Bodies::nothing : joints_[i].geometry.parent;
      child[l] = i < 0 ? Bodies::nothing : joints_[i].geometry.child;
    }
    neighbours_[octet] = {bodies_.octet_of_all(parent), bodies_.octet_of_all(child)};
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

void Joints::directions(const JointGeometry& geometry, const Motor* motor, const Pose& a, const Pose& b,
                        Matrix6& parent, Matrix6& child) {
  JointOctet octet;
  set_octet(geometry, frame_about(geometry.axis), octet, 0);
  JointTask task;
  task.rows = rows_kind(geometry, motor);
  task.octet = &octet;
  task.used = 1;
  std::fill_n(task.parent, 8, a.x.data());
  std::fill_n(task.child, 8, b.x.data());
  joint_kernels().aim(task);
  parent = rows_at(octet.parent_force, 6, 0);
  child = rows_at(octet.child_force, 6, 0);
}

Joints::Matrix6 Joints::parent_force(const Joint& joint) const {
  return rows_at(octets_[octet_of(joint.place)].parent_force, joint.rows, lane_of(joint.place));
}

Joints::Matrix6 Joints::child_force(const Joint& joint) const {
  return rows_at(octets_[octet_of(joint.place)].child_force, joint.rows, lane_of(joint.place));
}

double Joints::coordinate(const Joint& joint, const Pose& a, const Pose& b) const {
  const JointGeometry& g = joint.geometry;
  if (g.type == JointType::prismatic)
    return g.axis.dot(a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x) - g.parent_point);
  const Quat e = relative_rotation(g, a, b);
  return 2 * std::atan2(g.axis.dot(e.vec()), e.w());
}

void Joints::prepare(int i, double end_time, double impulse_time) {
  Joint& joint = joints_[i];
  joint.impulse_time = impulse_time;
  to_aim_.push_back(i);
  if (!joint.motor) return;
  MotorOctet& m = motors_[octet_of(joint.place)];
  const int lane = lane_of(joint.place);
  m.stiffness[lane] = joint.motor->stiffness;
  m.damping[lane] = joint.motor->damping;
  m.limit[lane] = joint.motor->limit;
  m.target[lane] = motor_target(*joint.motor, end_time);
  m.coordinate[lane] = joint.coordinate;
  m.impulse_time[lane] = impulse_time;
}

void Joints::aim() {
  aim(to_aim_, false);
  to_aim_.clear();
}

void Joints::aim(std::span<const int> joints, bool at_next) {
  const auto pose = [&](int body) -> const Pose& { return at_next ? bodies_.pose_next(body) : bodies_.pose_now(body); };
  groups_.each(joints, 0, [&](int i) { return joints_[i].place; }, [&](int octet, unsigned used) {
    JointTask task;
    task.rows = octet_rows_[octet];
    task.octet = &octets_[octet];
    task.used = used;
    each_lane(octet, used, [&](int lane, int place) {
      const JointGeometry& g = joints_[joint_at_[place]].geometry;
      task.parent[lane] = pose(g.parent).x.data();
      task.child[lane] = pose(g.child).x.data();
    });
    kernels_.aim(task);
  });
  for (const int i : joints) {
    Joint& joint = joints_[i];
    const JointGeometry& g = joint.geometry;
    const Pose &child = pose(g.child), &recorded = g.child >= 0 ? child : pose(g.parent);
    joint.force_rotation = recorded.rotation;
    joint.force_arm = child.x + child.rotation * g.child_point - recorded.x;
  }
}

void Joints::reset_coordinate(int i) {
  Joint& joint = joints_[i];
  if (!joint.motor) return;
  joint.coordinate =
      coordinate(joint, bodies_.pose_now(joint.geometry.parent), bodies_.pose_now(joint.geometry.child));
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
  const Matrix6 force = on_child ? child_force(joint) : parent_force(joint);
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  for (int r = 0; r < joint.rows; ++r) wrench += force.row(r).transpose() * x[joint.row + r];
  linear = wrench.head<3>();
  angular = joint.force_rotation * wrench.tail<3>() - joint.force_arm.cross(linear);
  if (!on_child) linear = -linear, angular = -angular;
}

double Joints::motor_impulse(int i, std::span<const double> x) const { return x[joints_[i].row + 5]; }

double Joints::opening_rate(int i, std::span<const double> x) const {
  const Joint& joint = joints_[i];
  const Matrix6 on_child = child_force(joint), on_parent = parent_force(joint);
  double largest = 0;
  for (int r = 0; r < joint.translation_rows + joint.rotation_rows; ++r) {
    double rate = 0;
    for (int j = 0; j < 6; ++j) {
      if (joint.child_row >= 0) rate += on_child(r, j) * x[joint.child_row + j];
      if (joint.parent_row >= 0) rate += on_parent(r, j) * x[joint.parent_row + j];
    }
    largest = std::max(largest, std::abs(rate));
  }
  return largest;
}

}  // namespace physics
