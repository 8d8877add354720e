#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <ranges>
#include <stdexcept>

#include "terms/rotation.hpp"
#include "stepper/stepper.hpp"

/// What is said of a lane; nothing here changes it.
namespace physics {

std::string_view step_explanation(graphsolve::Status status) {
  using graphsolve::Status;
  switch (status) {
    case Status::solved: return "";
    case Status::max_iterations:
      return "the iterations ran out before the residual reached the tolerance; take a shorter time step or a larger "
             "tolerance";
    case Status::stalled:
      return "no start that was tried led to a motion that all contacts and joints allow, and there may be none near "
             "here; take a shorter time step";
    case Status::singular:
      return "a pivot block is singular; look for joints that contradict each other, and for masses far below all "
             "others";
    case Status::not_finite:
      return "a value became NaN or infinite, or a motion so large that its energy is no number; look for such input, or "
             "take a shorter time step";
    case Status::step_bound: return "a body would turn farther than a step can say; take a shorter time step";
  }
  return "";
}

/// Of the middle of the last step, where its velocity is the body's: a fall keeps just that.
double Stepper::energy(int lane) const {
  const Vec3& gravity = lanes[lane].mechanism.gravity;
  const double back = 0.5 * step_before(lane);
  double kinetic = 0, potential = 0;
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    kinetic += bodies.kinetic_energy(i);
    potential -= bodies.mass(i) * gravity.dot(bodies.position(i) - back * bodies.velocity(i));
  }
  return kinetic + potential;
}

double Stepper::largest_joint_error(int lane) const {
  double largest = 0;
  for (int k = 0; k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
    const JointGeometry& g = joints.geometry(j);
    largest = std::max(largest, joints.error(j, bodies.pose_now(g.parent), bodies.pose_now(g.child)).largest());
  }
  return largest;
}

Vec3 Stepper::linear_momentum(int lane) const {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    sum += bodies.mass(i) * bodies.velocity(i);
  }
  return sum;
}

Vec3 Stepper::angular_momentum(int lane) const {
  const LaneState& s = lanes[lane].state;
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    const Vec3 spin = s.half_kick ? Vec3(bodies.inertia(i) * bodies.spin(i))
                                  : momentum_minus(bodies.inertia(i), bodies.spin(i), s.time_step);
    sum += bodies.position(i).cross(bodies.mass(i) * bodies.velocity(i)) + bodies.orientation(i) * spin;
  }
  return sum;
}

/// More than what a record may leave out?
bool Stepper::misses(int i) const {
  constexpr double worth_telling = 1e-4;  // of the tolerance
  const double mass = bodies.mass(i), least = worth_telling * settings.tolerance;
  const double rotational = mass * bodies.inertia(i).diagonal().minCoeff();  // (angular momentum / velocity)^2
  return bodies.missed(i).norm() > least * mass || bodies.missed_angular(i).squaredNorm() > least * least * rotational;
}

void Stepper::write_bodies(int lane, std::span<BodyRecord> records) const {
  const Lane& l = lanes[lane];
  for (std::size_t k = 0; k < records.size(); ++k) {
    const Placement place = l.place(static_cast<int>(k));
    BodyRecord& record = records[k];
    if (place.body < 0) {
      record = {place.offset, place.rotation, Vec3::Zero(), Vec3::Zero()};
      continue;
    }
    const int i = body(lane, place.body);
    record.missed = record.missed_angular = Vec3::Zero();
    if (place.leads && misses(i)) {
      record.missed = bodies.missed(i);
      record.missed_angular = place.rotation.conjugate() * bodies.missed_angular(i);
    }
    const Vec3 w = bodies.spin(i);
    const Quat q = bodies.orientation(i);
    record.position = bodies.position(i) + q * place.offset;
    record.orientation = q * place.rotation;
    record.angular_velocity = place.rotation.conjugate() * w;
    record.velocity = bodies.velocity(i);
    if (place.offset.isZero()) continue;
    // The velocity of the step is the difference of its two poses; a member off the centre moves along a chord.
    if (l.state.half_kick || l.state.impulse_time == 0) {
      record.velocity += q * w.cross(place.offset);
    } else {
      const double h = l.state.time_step;
      const Quat before = rotate(q, -w, rotation_scalar(w, h), h);
      record.velocity += (q * place.offset - before * place.offset) / h;
    }
  }
}

/// Of the last step, or 0 where the velocities are those at the pose.
double Stepper::step_before(int lane) const { return lanes[lane].state.half_kick ? 0 : lanes[lane].state.time_step; }

/// Of the lane's joints the one that a described joint became; empty where it has no coordinate.
std::optional<int> Stepper::find_coordinate(int lane, int described) const {
  const int count = static_cast<int>(lanes[lane].mechanism.joints.size());
  if (described < 0 || described >= count)
    throw std::out_of_range(fmt::format("there is no joint {}, the scene has {}", described, count));
  const auto all = std::views::iota(0, joints_per_lane);  // in the order of the description
  const auto source = [&](int k) { return joints.geometry(joint(lane, k)).source; };
  const auto found = std::ranges::lower_bound(all, described, {}, source);
  if (found == all.end() || source(*found) != described) return {};
  const int j = joint(lane, *found);
  return joints.has_coordinate(j) ? std::optional(j) : std::nullopt;
}

std::optional<double> Stepper::joint_coordinate(int lane, int described) const {
  const auto j = find_coordinate(lane, described);
  return j ? std::optional(joints.coordinate(*j)) : std::nullopt;
}

std::optional<double> Stepper::joint_rate(int lane, int described) const {
  const auto j = find_coordinate(lane, described);
  return j ? std::optional(joints.rate(*j, step_before(lane))) : std::nullopt;
}

void Stepper::write_joints(int lane, std::span<JointRecord> records) const {
  const double impulse_time = lanes[lane].state.impulse_time;
  for (JointRecord& record : records) record = {};
  for (int k = 0; k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
    const JointGeometry& g = joints.geometry(j);
    JointRecord& record = records[g.source];
    record.error = joints.error(j, bodies.pose_now(g.parent), bodies.pose_now(g.child)).largest();
    if (joints.has_coordinate(j)) {
      record.coordinate = joints.coordinate(j);
      record.rate = joints.rate(j, step_before(lane));
    }
    if (joints.has_motor(j)) record.effort = 0;
    if (impulse_time == 0) continue;
    joints.impulse(j, unknowns, record.force, record.torque);
    record.force /= impulse_time;
    record.torque /= impulse_time;
    if (joints.has_motor(j)) record.effort = joints.motor_impulse(j, unknowns) / impulse_time;
  }
}

void Stepper::write_record(int lane, StepRecord& record) const {
  const Lane& l = lanes[lane];
  record.step = l.step_index;
  record.time = l.time();
  record.bodies.resize(l.mechanism.bodies.size());
  record.contacts.resize(l.mechanism.contacts.size());
  record.joints.resize(l.mechanism.joints.size());
  write_bodies(lane, record.bodies);
  contacts->write_record(lane, record.contacts, l.state.impulse_time);
  write_joints(lane, record.joints);
  record.solver.reset();
  if (l.state.impulse_time == 0) return;
  const StepResult& result = l.last.ok() ? l.last : l.before;  // of the step that led here
  record.solver = SolverRecord{.status = std::string(graphsolve::name(result.status)),
                               .iterations = result.iterations,
                               .residual = result.residual,
                               .substeps = result.substeps,
                               .new_force_direction = result.new_force_direction};
}

std::string Stepper::failure_place(int lane) const {
  const Lane& l = lanes[lane];
  if (l.last.ok()) return "";
  const graphsolve::ComponentReport& failure = l.failure;
  std::string thing;
  if (const int node = failure.worst_node.index - body_node(lane, 0).index; failure.worst_node.index >= 0) {
    if (node < bodies_per_lane) {
      int k = 0;
      while (!l.place(k).leads || l.place(k).body != node) ++k;
      thing = fmt::format("body '{}'", l.mechanism.bodies[k].name);
    } else {
      const int source = joints.geometry(joint(lane, node - bodies_per_lane)).source;
      thing = fmt::format("joint '{}'", l.mechanism.joints[source].name);
    }
  } else if (const int contact = contacts->source(lane, failure.worst_batch, failure.worst_instance); contact >= 0) {
    thing = fmt::format("contact '{}'", l.mechanism.contacts[contact].name);
  }
  if (std::isinf(failure.residual)) return thing + " (beyond the largest number)";
  return fmt::format("{} (residual {:.2g} m/s)", thing, failure.residual);
}

}  // namespace physics
