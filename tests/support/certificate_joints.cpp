#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/certificate_view.hpp"
#include "support/dense.hpp"

namespace certificate {

namespace {

using physics::Joint;
using physics::JointType;

Vec3 across(const Vec3& v, const Vec3& axis) { return v - axis * axis.dot(v); }

/// Child relative to parent: translation of the joint point and rotation from rest, both in the parent's frame.
struct Relative {
  Vec3 shift;
  Turn turn;
};
Relative relative(const Joint& joint, const Placement& parent, const Placement& child) {
  const Vec3 apart = child.x + child.r * joint.child_point - parent.x - parent.r * joint.parent_point;
  Turn q = inverse(parent.q) * child.q * inverse(turn(joint.orientation));
  if (q.w < 0) q = {-q.w, -q.v};
  return {parent.r.transpose() * apart, q};
}

/// The free coordinate [rad or m].
double coordinate(const Joint& joint, const Placement& parent, const Placement& child) {
  const Vec3 axis = joint.axis.normalized();
  const Relative r = relative(joint, parent, child);
  if (joint.type == JointType::prismatic) return axis.dot(r.shift);
  return 2 * std::atan2(axis.dot(r.turn.v), r.turn.w);
}

double target(const physics::Motor& motor, double time) {
  if (const auto* sine = std::get_if<physics::SineTarget>(&motor.target))
    return sine->offset + sine->amplitude * std::sin(2 * std::numbers::pi * sine->frequency * time + sine->phase);
  const auto* table = std::get_if<physics::TableTarget>(&motor.target);
  if (!table) return std::get<double>(motor.target);
  if (table->empty()) return 0;
  if (time <= table->front().first) return table->front().second;
  for (std::size_t i = 1; i < table->size(); ++i) {
    const auto& [t0, y0] = (*table)[i - 1];
    const auto& [t1, y1] = (*table)[i];
    if (time < t1) return y0 + (y1 - y0) * (time - t0) / (t1 - t0);
  }
  return table->back().second;
}

/// The direction at the old pose in which the joint lets its child move. Of a hinge that is open by a small rotation e
/// (at the tolerance all are) it lies half way between the parent's axis and the child's: turning about no other
/// direction keeps the locked components of vec(e), and a constraint pushes along what it locks.
Vec3 world_axis(const Step& step, const Joint& joint) {
  const Placement &parent = step.old_at(joint.parent), &child = step.old_at(joint.child);
  const Vec3 axis = joint.axis.normalized();
  if (joint.type != JointType::revolute) return parent.r * axis;
  const Turn e = relative(joint, parent, child).turn;
  return (parent.r * (axis + matrix(e) * axis)).normalized();
}

/// An impulse on the child at its joint point, at the old pose, and its opposite on the parent: at the parent's own
/// joint point, where the two are locked together (they are apart by the joint's error, which times the force counts
/// for a light body), else at the child's.
void take_off(const Step& step, const Joint& joint, const Momentum& impulse, std::span<Momentum> rest) {
  const Placement &child = step.old_at(joint.child), &parent = step.old_at(joint.parent);
  const Vec3 arm = child.r * joint.child_point;
  rest[joint.child.index].linear -= impulse.linear;
  rest[joint.child.index].angular -= impulse.angular + arm.cross(impulse.linear);
  if (joint.parent.is_world()) return;
  rest[joint.parent.index].linear += impulse.linear;
  const bool locked = joint.type != JointType::prismatic;
  const Vec3 parent_arm = locked ? Vec3(parent.r * joint.parent_point) : Vec3(child.x + arm - parent.x);
  rest[joint.parent.index].angular += impulse.angular + parent_arm.cross(impulse.linear);
}

bool drives(const Joint& joint) {
  return joint.motor && (joint.type == JointType::revolute || joint.type == JointType::prismatic);
}

/// The recorded wrench along the joint's free directions must be the motor's effort, and that its law.
void judge_free_directions(const Step& step, std::size_t index, Certificate& result) {
  const Joint& joint = step.mechanism.joints[index];
  const physics::JointRecord& record = step.after.joints[index];
  const Scale scale = step.scale[joint.child.index];
  const double time = step.force_time;
  double effort = 0;
  if (drives(joint)) {
    const double law = lawful_effort(step, joint, record.effort);
    effort = record.effort.value_or(law);
    // A stiff motor is judged as a spring: by the velocity that would explain the difference.
    const double slope = time * (joint.motor->stiffness * step.dt + joint.motor->damping);
    const double difference = time * std::abs(effort - law);
    const double weight = joint.type == JointType::revolute
                              ? std::max(scale.rotational(), slope / scale.gyration())
                              : std::max(scale.mass, slope);
    result.motor.raise(difference / weight, step.after.step, joint.name);
  }
  const Vec3 axis = world_axis(step, joint);
  double stray = 0;
  if (joint.type == JointType::spherical) stray = largest(record.torque) / scale.rotational();
  if (joint.type == JointType::revolute) stray = std::abs(axis.dot(record.torque) - effort) / scale.rotational();
  if (joint.type == JointType::prismatic) stray = std::abs(axis.dot(record.force) - effort) / scale.mass;
  result.wrench.raise(time * stray, step.after.step, joint.name);
}

/// Directions in which a joint can push: unit impulses on the child.
std::vector<Momentum> locked_directions(const Step& step, const Joint& joint) {
  const Vec3 axis = world_axis(step, joint);
  Vec3 side = axis.cross(Vec3::UnitX());
  if (side.norm() < 0.5) side = axis.cross(Vec3::UnitY());
  side.normalize();
  const Vec3 other = axis.cross(side);
  std::vector<Momentum> all;
  for (const Vec3& d : {side, other, axis}) {
    const bool along = d == axis;  // bitwise: it is the same vector
    if (!(along && joint.type == JointType::prismatic)) all.push_back({d, Vec3::Zero()});
    const bool turns = joint.type == JointType::spherical || (along && joint.type == JointType::revolute);
    if (!turns) all.push_back({Vec3::Zero(), d});
  }
  return all;
}

}  // namespace

double lawful_effort(const Step& step, const Joint& joint, std::optional<double> recorded) {
  const physics::Motor& motor = *joint.motor;
  const double now = coordinate(joint, step.old_at(joint.parent), step.old_at(joint.child));
  double next = coordinate(joint, step.new_at(joint.parent), step.new_at(joint.child));
  double change = next - now;
  if (joint.type == JointType::revolute) {
    constexpr double full_turn = 2 * std::numbers::pi;
    change = std::remainder(change, full_turn);
    if (recorded && motor.stiffness > 0) {
      // A motor follows full turns, two records do not show them: take the number that explains the record best.
      const double deflection = (*recorded + motor.damping * change / step.dt) / motor.stiffness;
      const double seen = target(motor, step.after.time) - deflection;
      next += full_turn * std::round((seen - next) / full_turn);
    }
  }
  const double effort = motor.stiffness * (target(motor, step.after.time) - next) - motor.damping * change / step.dt;
  return std::clamp(effort, -motor.limit, motor.limit);
}

void judge_joint_errors(const Step& step, Certificate& result) {
  for (const Joint& joint : step.mechanism.joints) {
    Relative r = relative(joint, step.new_at(joint.parent), step.new_at(joint.child));
    const Vec3 axis = joint.axis.normalized();
    if (joint.type == JointType::prismatic) r.shift = across(r.shift, axis);
    if (joint.type == JointType::revolute) r.turn.v = across(r.turn.v, axis);
    if (joint.type == JointType::spherical) r.turn.v.setZero();
    const double shift = largest(step.new_at(joint.parent).r * r.shift), angle = 2 * largest(r.turn.v);
    result.joint_error.raise(std::max(shift, angle), step.after.step, joint.name);
    result.joints.raise(shift / step.dt, step.after.step, joint.name);
    result.joints.raise(angle * step.scale[joint.child.index].gyration() / step.dt, step.after.step, joint.name);
  }
}

void judge_joints(const Step& step, std::span<Momentum> rest, Certificate& result) {
  for (std::size_t j = 0; j < step.mechanism.joints.size(); ++j) {
    const Joint& joint = step.mechanism.joints[j];
    Momentum impulse;
    if (step.forces_recorded) {
      impulse = {step.force_time * step.after.joints[j].force, step.force_time * step.after.joints[j].torque};
      judge_free_directions(step, j, result);
    } else if (drives(joint)) {
      const Vec3 push = step.force_time * lawful_effort(step, joint, std::nullopt) * world_axis(step, joint);
      (joint.type == JointType::prismatic ? impulse.linear : impulse.angular) = push;
    }
    take_off(step, joint, impulse, rest);
  }
}

void eliminate_joints(const Step& step, std::span<Momentum> rest) {
  const int n = static_cast<int>(rest.size());
  Eigen::VectorXd weight(6 * n), b(6 * n);
  for (int i = 0; i < n; ++i) {
    weight.segment<3>(6 * i).setConstant(1 / step.scale[i].mass);
    weight.segment<3>(6 * i + 3).setConstant(1 / step.scale[i].rotational());
    b.segment<3>(6 * i) = rest[i].linear;
    b.segment<3>(6 * i + 3) = rest[i].angular;
  }
  std::vector<Eigen::VectorXd> columns;
  for (const Joint& joint : step.mechanism.joints) {
    for (const Momentum& direction : locked_directions(step, joint)) {
      std::vector<Momentum> effect(n);
      take_off(step, joint, direction, effect);
      Eigen::VectorXd column(6 * n);
      for (int i = 0; i < n; ++i) column.segment<6>(6 * i) << effect[i].linear, effect[i].angular;
      columns.push_back(weight.cwiseProduct(column));
    }
  }
  if (columns.empty()) return;
  Eigen::MatrixXd a(6 * n, columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const double length = columns[k].norm();  // equal lengths, so that the rank is judged fairly
    a.col(static_cast<Eigen::Index>(k)) = length > 0 ? Eigen::VectorXd(columns[k] / length) : columns[k];
  }
  const Eigen::VectorXd weighted = weight.cwiseProduct(b);
  const Eigen::VectorXd left = weighted - a * dense::least_squares(a, weighted);
  for (int i = 0; i < n; ++i) {
    rest[i].linear = left.segment<3>(6 * i).cwiseQuotient(weight.segment<3>(6 * i));
    rest[i].angular = left.segment<3>(6 * i + 3).cwiseQuotient(weight.segment<3>(6 * i + 3));
  }
}

}  // namespace certificate
