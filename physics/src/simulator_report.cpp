#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <set>

#include "rotation.hpp"
#include "simulator_impl.hpp"

/// What a simulator says of its state; nothing here changes it.
namespace physics {

int Simulator::step_index() const { return impl_->step_index; }
double Simulator::time() const { return impl_->time; }
double Simulator::time_step() const { return impl_->dt; }
const Mechanism& Simulator::mechanism() const { return impl_->mechanism; }
double Simulator::start_correction() const { return impl_->start_correction; }
const PhaseTimes& Simulator::phase_times() const { return impl_->times; }
const ProblemSize& Simulator::problem_size() const { return impl_->size; }
double Simulator::smallest_distance() const { return impl_->contacts->smallest_distance(); }

double Simulator::largest_joint_error() const {
  const Impl& s = *impl_;
  double largest = 0;
  for (int j = 0; j < s.joints.size(); ++j) {
    const JointGeometry& g = s.joints.geometry(j);
    largest = std::max(largest, s.joints.error(j, s.bodies.pose_now(g.parent), s.bodies.pose_now(g.child)));
  }
  return largest;
}

double Simulator::energy() const {
  const State& state = impl_->state;
  return 0.5 * (state.previous_kinetic_energy + state.kinetic_energy) + state.potential_energy;
}

Vec3 Simulator::linear_momentum() const {
  const Impl& s = *impl_;
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < s.bodies.size(); ++i) sum += s.bodies.mass[i] * s.state.v[i];
  return sum;
}

Vec3 Simulator::angular_momentum() const {
  const Impl& s = *impl_;
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < s.bodies.size(); ++i) {
    const Vec3 spin = s.state.half_kick ? Vec3(s.bodies.inertia[i] * s.state.w[i])
                                        : momentum_minus(s.bodies.inertia[i], s.state.w[i], s.state.time_step);
    sum += s.state.x[i].cross(s.bodies.mass[i] * s.state.v[i]) + s.state.q[i] * spin;
  }
  return sum;
}

void Simulator::write_record(StepRecord& record) const {
  const Impl& s = *impl_;
  record.step = s.step_index;
  record.time = s.time;
  record.bodies.resize(s.mechanism.bodies.size());
  record.contacts.resize(s.mechanism.contacts.size());
  record.joints.resize(s.mechanism.joints.size());
  for (std::size_t k = 0; k < record.bodies.size(); ++k) {
    const Placement& place = s.assembly.placement[k];
    BodyRecord& body = record.bodies[k];
    if (place.body < 0) {
      body = {place.offset, place.rotation, Vec3::Zero(), Vec3::Zero()};
      continue;
    }
    const int i = place.body;
    body.position = s.state.x[i] + s.state.q[i] * place.offset;
    body.orientation = s.state.q[i] * place.rotation;
    body.angular_velocity = place.rotation.conjugate() * s.state.w[i];
    body.velocity = s.state.v[i];
    if (place.offset.isZero()) continue;
    // The velocity of the step is the difference of its two poses; a member off the centre moves along a chord.
    if (s.state.half_kick || s.impulse_time == 0) {
      body.velocity += s.state.q[i] * s.state.w[i].cross(place.offset);
    } else {
      const Quat before = rotate(s.state.q[i], -s.state.w[i], rotation_scalar(s.state.w[i], s.state.time_step),
                                 s.state.time_step);
      body.velocity += (s.state.q[i] * place.offset - before * place.offset) / s.state.time_step;
    }
  }
  s.contacts->write_record(record.contacts, s.impulse_time);
  for (JointRecord& joint : record.joints) joint = {};
  for (int j = 0; j < s.joints.size(); ++j) {
    const JointGeometry& g = s.joints.geometry(j);
    JointRecord& joint = record.joints[g.source];
    joint.error = s.joints.error(j, s.bodies.pose_now(g.parent), s.bodies.pose_now(g.child));
    if (s.joints.has_motor(j)) joint.effort = 0;
    if (s.impulse_time == 0) continue;
    s.joints.impulse(j, s.unknowns, joint.force, joint.torque);
    joint.force /= s.impulse_time;
    joint.torque /= s.impulse_time;
    if (s.joints.has_motor(j)) joint.effort = s.joints.motor_impulse(j, s.unknowns) / s.impulse_time;
  }
  record.solver.reset();
  if (s.impulse_time == 0) return;
  record.solver = SolverRecord{.status = std::string(graphsolve::name(s.last.status)),
                               .iterations = s.last.iterations,
                               .residual = s.last.residual,
                               .substeps = s.last.substeps,
                               .new_force_direction = s.last.new_force_direction};
}

std::string Simulator::failure_place() const {
  const Impl& s = *impl_;
  const auto& failure = s.failure;
  if (s.last.ok()) return "";
  std::string thing;
  if (failure.worst_node.index >= 0) {
    const bool body = failure.worst_node.index < s.bodies.size();
    thing = fmt::format("{} '{}'", body ? "body" : "joint", s.problem->graph().name(failure.worst_node));
  } else if (const int contact = s.contacts->source(failure.worst_batch, failure.worst_instance); contact >= 0) {
    thing = fmt::format("contact '{}'", s.mechanism.contacts[contact].name);
  }
  return fmt::format("{} (residual {:.2g} m/s)", thing, failure.residual);
}

/// Groups dependent joint rows: two that share a joint belong together.
std::vector<std::string> Simulator::redundancies() const {
  Impl& s = *impl_;
  s.load_state_into_terms(s.dt);
  s.joints.prepare(s.time + s.dt, s.dt);
  const auto& factorization = s.solver->factorize_terms(s.unknowns);
  std::vector<double> y(s.unknowns.size());
  struct Group {
    std::set<int> joints;
    int count = 0;
  };
  std::vector<Group> groups;
  for (const auto& dropped : factorization.dropped_rows()) {
    factorization.dependency(dropped, y);
    double largest = 0;
    for (int j = 0; j < s.joints.size(); ++j)
      for (int r = 0; r < s.joints.rows(j); ++r) largest = std::max(largest, std::abs(y[s.joints.row(j) + r]));
    Group group{.joints = {}, .count = 1};
    for (int j = 0; j < s.joints.size(); ++j)
      for (int r = 0; r < s.joints.rows(j); ++r)
        if (std::abs(y[s.joints.row(j) + r]) > 1e-6 * largest) group.joints.insert(s.joints.geometry(j).source);
    for (auto other = groups.begin(); other != groups.end();) {
      const bool shares = std::any_of(group.joints.begin(), group.joints.end(),
                                      [&](int j) { return other->joints.contains(j); });
      if (!shares) {
        ++other;
        continue;
      }
      group.joints.insert(other->joints.begin(), other->joints.end());
      group.count += other->count;
      other = groups.erase(other);
    }
    groups.push_back(std::move(group));
  }
  std::vector<std::string> sentences;
  for (const Group& group : groups) {
    std::string names;
    for (const int j : group.joints)
      names += (names.empty() ? "'" : ", '") + s.mechanism.joints[j].name + "'";
    sentences.push_back(fmt::format("joints {} over-constrain the mechanism by {}", names, group.count));
  }
  return sentences;
}

}  // namespace physics
