#include <algorithm>
#include <cmath>
#include <limits>

#include "stepper/stepper.hpp"
#include "terms/rotation.hpp"

/// Start velocities that joints forbid, and the impulses of joints that make them agree (docs/algorithm.md).
namespace physics {

namespace {

/// A `standard` start that steps led to obeys the joints along its chord, within what steps are accepted at [m/s].
constexpr double led_here = 1e-6;
/// Takes out a dependence of rows that a pose open by largest_start_error hides: as a square that is 1e-10.
constexpr double shift = 1e-8;
constexpr int most_sweeps = 8;  ///< each leaves the shift over what a row adds of what the one before left

Vec3 chord(const Quat& q, const Vec3& w, const Vec3& arm, double h) {
  return (q * arm - rotate(q, -w, rotation_scalar(w, h), h) * arm) / h;
}

double largest(const Vec3& v) { return v.lpNorm<Eigen::Infinity>(); }

}  // namespace

/// Largest rate at which velocities among the unknowns open a joint of the lane.
double Stepper::opening(int lane, std::span<const double> x) const {
  double rate = 0;
  for (int k = 0; k < joints_per_lane; ++k) rate = std::max(rate, joints.opening_rate(joint(lane, k), x));
  return rate;
}

void Stepper::put_velocities(int lane, std::span<double> x) const {
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    Eigen::Map<Vec3>{x.data() + bodies.row[i]} = bodies.velocity(i);
    Eigen::Map<Vec3>{x.data() + bodies.row[i] + 3} = bodies.spin(i);
  }
}

/// Did a step with these velocities lead here?
bool Stepper::led_by_a_step(int lane) const {
  const double h = lanes[lane].state.time_step;
  const auto before = [&](int i) {
    Pose pose = bodies.pose_now(i);
    if (i < 0) return pose;
    const Vec3 w = bodies.spin(i);
    pose.x -= h * bodies.velocity(i);
    pose.q = rotate(pose.q, -w, rotation_scalar(w, h), h);
    pose.rotation = pose.q.toRotationMatrix();
    return pose;
  };
  for (int k = 0; k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
    const JointGeometry& g = joints.geometry(j);
    if (!(joints.error(j, before(g.parent), before(g.child)).largest() <= led_here * h)) return false;
  }
  return true;
}

/// How far the bodies of a description are from moving as the rigid ones do that fixed joints make of them [m/s,
/// rad/s].
double Stepper::slack_of_members(int lane) const {
  const Lane& l = lanes[lane];
  double rigid = 0, along_chord = 0;
  for (std::size_t k = 0; k < l.placement.size(); ++k) {
    const Placement& place = l.placement[k];
    const Body& member = l.mechanism.bodies[k];
    if (place.body < 0) {
      rigid = along_chord = std::max({rigid, along_chord, largest(member.velocity), largest(member.angular_velocity)});
      continue;
    }
    const int i = body(lane, place.body);
    const Vec3 w = bodies.spin(i), v = member.velocity - bodies.velocity(i);
    const Quat q = bodies.orientation(i);
    const double spin = largest(place.rotation * member.angular_velocity - w);
    rigid = std::max({rigid, spin, largest(v - q * w.cross(place.offset))});
    if (!l.state.half_kick) along_chord = std::max({along_chord, spin, largest(v - chord(q, w, place.offset, dt))});
  }
  return l.state.half_kick || along_chord > led_here ? rigid : 0;
}

/// The momenta of the members are those of the rigid bodies.
void Stepper::join_members(int lane) {
  const Lane& l = lanes[lane];
  std::vector<Vec3> momentum(bodies_per_lane, Vec3::Zero());
  for (std::size_t k = 0; k < l.placement.size(); ++k) {
    const Placement& place = l.placement[k];
    if (place.body < 0) continue;
    const Body& member = l.mechanism.bodies[k];
    const int i = body(lane, place.body);
    const Vec3 v = bodies.orientation(i).conjugate() * (member.velocity - bodies.velocity(i));
    momentum[place.body] += place.rotation * (member.inertia * member.angular_velocity);
    momentum[place.body] += member.mass * place.offset.cross(v);
  }
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    bodies.set_velocity(i, bodies.velocity(i), bodies.inertia(i).ldlt().solve(momentum[k]));
  }
}

/// min (v - v0)^T M (v - v0) subject to J v = 0: M and J are what the terms write at rest, where z_{k+2} is z_{k+1}.
/// False where the matrix is singular.
bool Stepper::project(int lane, std::span<double> v) {
  std::vector<int> some_bodies(bodies_per_lane), some_joints(joints_per_lane);
  for (int k = 0; k < bodies_per_lane; ++k) some_bodies[k] = body(lane, k);
  for (int k = 0; k < joints_per_lane; ++k) some_joints[k] = joint(lane, k);
  graphsolve::Factorization matrix(plan);
  matrix.set_saddle_shift(shift);
  matrix.set_zero();
  std::vector<double> step(v.size(), 0.0), residual(v.size(), 0.0);
  for (int k = 0; joints.any_motor() && k < joints_per_lane; ++k) joints.release(joint(lane, k));
  bodies.evaluate({some_bodies, {}, 0}, step, residual, matrix.values().data());
  joints.evaluate({some_joints, {}, 0}, step, residual, matrix.values().data());
  for (int k = 0; joints.any_motor() && k < joints_per_lane; ++k) joints.prepare(joint(lane, k), 0, dt);
  const auto& islands = lanes[lane].islands;
  const auto outcomes = matrix.factorize(islands);
  if (std::ranges::any_of(islands, [&](int c) { return !outcomes[c].ok(); })) return false;
  double open = opening(lane, v);
  for (int sweep = 0; sweep < most_sweeps && open > 0; ++sweep) {
    std::ranges::fill(step, 0.0);
    for (int k = 0; k < joints_per_lane; ++k) joints.subtract_opening(joint(lane, k), v, step);
    matrix.solve_components(step, islands);
    for (std::size_t i = 0; i < v.size(); ++i) step[i] += v[i];
    const double rest = opening(lane, step);
    if (!(rest < open)) break;
    std::ranges::copy(step, v.begin());
    if (rest > 0.5 * open) break;
    open = rest;
  }
  return true;
}

/// Once the state is that of the description: velocities that joints forbid become the nearest that they allow.
void Stepper::agree_with_joints(int lane) {
  Lane& l = lanes[lane];
  l.start_energy_loss = 0;
  const double slack = slack_of_members(lane);
  const bool apart = slack > settings.tolerance;
  if (apart) join_members(lane);
  std::vector<double> v;
  double open = l.start_correction;
  if (apart || open > settings.tolerance) {
    v.assign(unknowns.size(), 0.0);
    put_velocities(lane, v);
    open = opening(lane, v);
  }
  if (!apart && !(open > settings.tolerance)) return;
  l.start_correction = std::max(slack, open);
  const double fastest = l.state.half_kick ? std::numeric_limits<double>::infinity() : most_spin(dt);
  const auto spin = [&](int i) { return Eigen::Map<const Vec3>(v.data() + bodies.row[i] + 3); };
  // Else the first step is left to do the same.
  bool taken = open > settings.tolerance && project(lane, v);
  for (int k = 0; k < bodies_per_lane; ++k) taken = taken && spin(body(lane, k)).norm() < fastest;
  for (int k = 0; taken && k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    bodies.set_velocity(i, Eigen::Map<const Vec3>(v.data() + bodies.row[i]), spin(i));
  }
  begin({&lane, 1}, dt);
  for (const Body& b : l.mechanism.bodies) {
    l.start_energy_loss += 0.5 * b.mass * b.velocity.squaredNorm();
    l.start_energy_loss += 0.5 * b.angular_velocity.dot(b.inertia * b.angular_velocity);
  }
  for (int k = 0; k < bodies_per_lane; ++k) l.start_energy_loss -= bodies.kinetic_energy(body(lane, k));
}

}  // namespace physics
