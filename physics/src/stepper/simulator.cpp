#include "physics/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "mechanism/limits.hpp"
#include "mechanism/start_pose.hpp"
#include "stepper/stepper.hpp"

namespace physics {

PhaseTimes& PhaseTimes::operator+=(const PhaseTimes& other) {
  for (auto part :
       {&PhaseTimes::prepare, &PhaseTimes::evaluate, &PhaseTimes::factorize, &PhaseTimes::solve, &PhaseTimes::finish})
    this->*part += other.*part;
  return *this;
}

ProblemSize& ProblemSize::operator+=(const ProblemSize& other) {
  for (auto part : {&ProblemSize::body_nodes, &ProblemSize::joint_nodes, &ProblemSize::rows, &ProblemSize::islands,
                    &ProblemSize::merged_bodies, &ProblemSize::frictionless_contacts})
    this->*part += other.*part;
  for (auto part : {&ProblemSize::culled_contacts, &ProblemSize::contact_steps, &ProblemSize::newton_steps,
                    &ProblemSize::operations, &ProblemSize::fill_blocks, &ProblemSize::stored_scalars})
    this->*part += other.*part;
  return *this;
}

namespace {

constexpr int only = 0;  ///< the lane of a simulator

/// Forces of a record are where the next step starts; its tangent is the friction basis itself.
void check_contact(const StepRecord& record, const Contact& contact, const ContactRecord& c) {
  const auto fail = [&](const char* what) {
    throw DescriptionError(fmt::format("record {}: contact '{}': {}", record.step, contact.name, what));
  };
  const auto is_force = [](double force) { return force >= 0 && std::isfinite(force); };
  if (!is_force(c.normal_force)) fail("its normal force is not a number >= 0");
  if (!std::all_of(c.facet_forces.begin(), c.facet_forces.end(), is_force)) fail("a facet force is not a number >= 0");
  constexpr double rounding = 1e-9;
  if (c.tangent && !(std::abs(c.tangent->norm() - 1) < rounding && std::abs(c.tangent->dot(contact.normal)) < rounding))
    fail("its tangent is not a unit vector along the plane");
}

/// What tells how often a hinge has turned, and what is told with it.
void check_joint(const StepRecord& record, const Joint& joint, const JointRecord& j) {
  const auto check = [&](const char* what, const std::optional<double>& value) {
    if (value && !std::isfinite(*value))
      throw DescriptionError(fmt::format("record {}: joint '{}': its {} is not finite", record.step, joint.name, what));
  };
  check("coordinate", j.coordinate);
  check("rate", j.rate);
  check("effort", j.effort);
}

/// A record that a run has written has bodies whose energy is a number.
void check_energy(const StepRecord& record, const Mechanism& mechanism, std::size_t k) {
  const Body& body = mechanism.bodies[k];
  const BodyRecord& b = record.bodies[k];
  const double speed = b.velocity.stableNorm(), distance = b.position.stableNorm();
  const double turning = b.angular_velocity.dot(body.inertia * b.angular_velocity);
  const double told = body.mass * (speed * (speed + distance) + mechanism.gravity.stableNorm() * distance) + turning;
  if (!(told <= largest_energy))
    throw DescriptionError(fmt::format("record {}: body '{}' moves so fast or lies so far away that its energy is no number",
                                       record.step, body.name));
}

/// And joints that hold what they hold.
void check_closed(const Mechanism& mechanism, const StepRecord& record) {
  const auto frame = [&](BodyId id) {
    return id.is_world() ? Frame{} : Frame{record.bodies[id.index].position, record.bodies[id.index].orientation};
  };
  for (const Joint& joint : mechanism.joints) {
    const Frame parent = frame(joint.parent), child = frame(joint.child);
    if (const double angle = bend(joint, parent, child); !(angle <= largest_start_error))
      throw DescriptionError(fmt::format("record {}: the bodies of joint '{}' are {:.3g} rad off their orientation",
                                         record.step, joint.name, angle));
    const double rounding = 1e-14 * std::max(parent.position.stableNorm(), child.position.stableNorm());
    if (const double apart = gap(joint, parent, child); !(apart <= largest_start_error + rounding))
      throw DescriptionError(fmt::format("record {}: the points of joint '{}' are {:.3g} m apart", record.step, joint.name, apart));
  }
}

void check_record(const Mechanism& mechanism, const StepRecord& record, double time_step) {
  constexpr int last = 1 << 30;  // from where a billion steps more have numbers
  if (record.step < 0 || record.step > last)
    throw DescriptionError(fmt::format("record {}: a step has a number from 0 to {}", record.step, last));
  if (!std::isfinite(record.time))
    throw DescriptionError(fmt::format("record {}: its time is not finite", record.step));
  if (record.bodies.size() != mechanism.bodies.size())
    throw DescriptionError(fmt::format("record {}: {} bodies, the scene has {}", record.step, record.bodies.size(),
                                       mechanism.bodies.size()));
  for (std::size_t k = 0; k < record.bodies.size(); ++k) {
    const BodyRecord& body = record.bodies[k];
    const bool finite = body.position.allFinite() && body.velocity.allFinite() && body.angular_velocity.allFinite() &&
                        body.missed.allFinite() && body.missed_angular.allFinite();
    if (!finite || !(std::abs(body.orientation.norm() - 1) < 1e-6))
      throw DescriptionError(fmt::format("record {}: body '{}' has a value that is not finite or a quaternion that is "
                                         "not a unit one", record.step, mechanism.bodies[k].name));
    if (const double turn = body.angular_velocity.norm() * time_step; !(turn < Bodies::largest_turn))
      throw DescriptionError(fmt::format("record {}: body '{}' spins too fast: |w| dt = {:.3g} must be < {}", record.step,
                                         mechanism.bodies[k].name, turn, Bodies::largest_turn));
    check_energy(record, mechanism, k);
  }
  check_closed(mechanism, record);
  for (std::size_t k = 0; record.joints.size() == mechanism.joints.size() && k < record.joints.size(); ++k)
    check_joint(record, mechanism.joints[k], record.joints[k]);
  if (record.contacts.size() != mechanism.contacts.size()) return;
  for (std::size_t k = 0; k < record.contacts.size(); ++k)
    check_contact(record, mechanism.contacts[k], record.contacts[k]);
}

}  // namespace

Simulator::Simulator(Mechanism mechanism, const SimulatorSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(mechanism), settings)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

StepResult Simulator::step() {
  impl_->step({&only, 1});
  return impl_->lanes[only].last;
}

void Simulator::restart_from(const StepRecord& record) {
  Impl& s = *impl_;
  Lane& lane = s.lanes[only];
  const int substeps = record.solver ? std::max(1, record.solver->substeps) : 1;
  check_record(lane.mechanism, record, s.dt / substeps);
  // Velocities of the start are what the scene says they are; no step led there.
  const bool half_kick = record.step == 0 && !record.solver && lane.mechanism.start == Start::half_kick;
  s.set_state(only, record.bodies, {.time_step = s.dt / substeps, .half_kick = half_kick});
  s.contacts->set(only, lane.mechanism, s.assembly(only));  // bases of the scene, where the record has none
  // Forces of the record make the start warm and keep the friction basis; a start without them is only colder.
  if (record.contacts.size() == lane.mechanism.contacts.size())
    s.contacts->load_record(only, record.contacts, lane.state.time_step);
  for (int k = 0; record.joints.size() == lane.mechanism.joints.size() && k < s.joints_per_lane; ++k) {
    const int j = s.joint(only, k);
    const JointRecord& joint = record.joints[s.joints.geometry(j).source];
    if (joint.coordinate) s.joints.set_turn(j, *joint.coordinate);
    else if (joint.effort) s.joints.find_turn(j, *joint.effort, record.time);
  }
  lane.set_time(record.step, record.time);
  lane.last = {};
}

void Simulator::write_record(StepRecord& record) const { impl_->write_record(only, record); }
std::string Simulator::failure_place() const { return impl_->failure_place(only); }

int Simulator::step_index() const { return impl_->lanes[only].step_index; }
double Simulator::time() const { return impl_->lanes[only].time(); }
double Simulator::time_step() const { return impl_->dt; }
const Mechanism& Simulator::mechanism() const { return impl_->lanes[only].mechanism; }
double Simulator::start_correction() const { return impl_->lanes[only].start_correction; }
double Simulator::start_energy_loss() const { return impl_->lanes[only].start_energy_loss; }
double Simulator::smallest_distance() const { return impl_->contacts->smallest_distance(only); }
double Simulator::largest_joint_error() const { return impl_->largest_joint_error(only); }
std::optional<double> Simulator::joint_coordinate(int joint) const { return impl_->joint_coordinate(only, joint); }
std::optional<double> Simulator::joint_rate(int joint) const { return impl_->joint_rate(only, joint); }
double Simulator::energy() const { return impl_->energy(only); }
Vec3 Simulator::linear_momentum() const { return impl_->linear_momentum(only); }
Vec3 Simulator::angular_momentum() const { return impl_->angular_momentum(only); }
const PhaseTimes& Simulator::phase_times() const { return impl_->times; }
const ProblemSize& Simulator::problem_size() const { return impl_->size; }
const graphsolve::BlockGraph& Simulator::graph() const { return impl_->problem->graph(); }

}  // namespace physics
