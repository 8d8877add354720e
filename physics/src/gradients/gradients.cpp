#include "physics/gradients.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <stdexcept>

#include "gradients/gradients_impl.hpp"
#include "graphsolve/overlap.hpp"

/// The interface, and the linearisation of a step. What is made of it: gradients_products.cpp.
namespace physics {

namespace {

/// Bound on z/s of contact pairs over the largest mass of their island. A contact held by a stiffness of w gives way
/// by m/w of what presses on it; rounding costs 2e-16 w of the lightest mass that a contact shows at its point. Where
/// that is a part r of the island's, 1e7 sqrt(r) is fair to both.
double stiffness_of(const Mechanism& mechanism, const Assembly& assembly) {
  double lightest = 1;
  for (const Contact& contact : mechanism.contacts) {
    const Placement& place = assembly.placement[contact.body.index];
    if (place.body < 0) continue;
    const RigidBody& body = assembly.bodies[place.body];
    const double arm = (place.offset + place.rotation * contact.point).norm();
    const double shown = 1 / (1 / body.mass + arm * arm / body.smallest_inertia);
    lightest = std::min(lightest, shown / body.island_mass);
  }
  return 1e7 * std::sqrt(lightest);
}

constexpr int only = 0;  ///< the lane of a simulator

}  // namespace

std::string_view explanation(GradientStatus status) {
  switch (status) {
    case GradientStatus::ready: return "";
    case GradientStatus::no_step:
      return "there is no step to differentiate: none was taken since the start or a restart, or the last one failed";
    case GradientStatus::substeps:
      return "the step was taken in substeps, whose states are gone; use a smaller time step";
    case GradientStatus::new_force_direction:
      return "the step took its force directions at the new configuration; use a smaller time step";
    case GradientStatus::singular: return "the linearisation has a singular block; look for redundant constraints";
    case GradientStatus::not_centred:
      return "the central path at this smoothing was not reached; use another smoothing";
  }
  return "";
}

StepGradient::Impl::Impl(Simulator::Impl& owner, const GradientSettings& options)
    : simulator(owner),
      settings(options),
      matrix(owner.solver->factorization().twin()),
      sensitivity(owner.bodies.size(), owner.joints.size(), owner.contacts->size_of_lane()),
      x(owner.unknowns),
      unknowns(owner.unknowns),
      next(owner.bodies.size()),
      row(owner.bodies.row),
      adjoint(owner.unknowns),
      scratch(owner.unknowns),
      solutions(static_cast<Eigen::Index>(owner.unknowns.size()), pass_columns),
      transposed(pass_columns, solutions.rows()),
      product(pass_columns, 0) {
  if (!(settings.smoothing >= 0 && std::isfinite(settings.smoothing)))
    throw std::invalid_argument(fmt::format("smoothing {} is not a finite number >= 0", settings.smoothing));
  matrix.set_saddle_shift(0);  // nothing takes it out again here
  const Assembly assembly = owner.assembly(only);
  stiffness = stiffness_of(lane().mechanism, assembly);
  for (const RigidBody& body : assembly.bodies) gyration.push_back(std::sqrt(body.smallest_inertia / body.mass));
  int widest = 0;
  for (const StepInput input : {StepInput::state, StepInput::load, StepInput::effort, StepInput::friction,
                                StepInput::mass, StepInput::inertia})
    widest = std::max(widest, columns(input));
  product.resize(pass_columns, widest);
}

StepGradient::Impl::Rewound::Rewound(Impl& owner) : owner_(owner) {
  Simulator::Impl& s = owner_.simulator;
  owner_.unknowns = s.unknowns;
  exchange();
  --owner_.lane().step_index;
  s.begin({&only, 1}, s.dt);
  s.apply_loads(only, owner_.impulse_time);
  for (int j = 0; j < s.joints.size(); ++j) s.joints.prepare(j, owner_.lane().time(1), owner_.impulse_time);
  s.joints.aim({&only, 1});
  s.unknowns = owner_.unknowns;
}

StepGradient::Impl::Rewound::~Rewound() {
  ++owner_.lane().step_index;
  exchange();
}

void StepGradient::Impl::Rewound::exchange() {
  Simulator::Impl& s = owner_.simulator;
  s.bodies.exchange_with_saved();
  std::swap(owner_.lane().state, owner_.lane().saved_state);
  for (int j = 0; j < s.joints.size(); ++j) s.joints.exchange_coordinate(j);
}

GradientStatus StepGradient::Impl::evaluate() {
  ready = false;
  Simulator::Impl& s = simulator;
  const Lane& l = lane();
  if (l.state.impulse_time == 0 || !l.last.ok()) return GradientStatus::no_step;
  if (l.last.substeps > 1) return GradientStatus::substeps;
  if (l.last.new_force_direction) return GradientStatus::new_force_direction;
  dt = s.dt;
  impulse_time = l.state.impulse_time;
  const Rewound rewound(*this);
  x = s.unknowns;
  const graphsolve::Status status = s.solver->linearize(x, settings.smoothing, stiffness, matrix);
  if (status == graphsolve::Status::solved) {
    const StepStart start{.time_step = l.state.time_step, .half_kick = l.state.half_kick, .impulse_time = impulse_time,
                          .gravity = l.mechanism.gravity};
    sensitivity.clear();
    s.bodies.differentiate(x, start, sensitivity);
    add_load_arms();
    s.joints.differentiate(x, start, sensitivity);
    s.contacts->differentiate(only, x, settings.friction_basis == FrictionBasis::following, stiffness, sensitivity);
    find_yielding_normals();
    for (int i = 0; i < s.bodies.size(); ++i) next[i] = s.bodies.pose_next(i);
    ready = true;
  }
  s.solver->restore_laws();
  if (ready) return GradientStatus::ready;
  return status == graphsolve::Status::singular ? GradientStatus::singular : GradientStatus::not_centred;
}

/// A force on a described body that is not at the centre of its moving body: torque h offset x R^T F.
void StepGradient::Impl::add_load_arms() {
  const Lane& l = lane();
  const int step = l.step_index + 1;
  for (const Load& load : l.mechanism.loads) {
    if (step < load.first_step || step > load.last_step) continue;
    const Placement place = l.place(load.body.index);
    if (place.body < 0 || place.offset.isZero()) continue;
    const Vec3 local = simulator.bodies.pose_now(place.body).rotation.transpose() * load.force;
    sensitivity.pose[place.body].bottomRightCorner<3, 3>() -= impulse_time * skew(place.offset) * skew(local);
  }
}

/// Asked by an adjoint of velocities in general position, angular ones on the radius of gyration.
void StepGradient::Impl::find_yielding_normals() {
  std::fill(adjoint.begin(), adjoint.end(), 0.0);
  double number = 0;
  for (int i = 0; i < bodies(); ++i) {
    for (int k = 0; k < 6; ++k) {
      number = std::fmod(number + std::numbers::phi, 1.0);
      const double general = number < 0.5 ? 0.5 + number : -number;  // 1/2 to 1, of either sign
      adjoint[row[i] + k] = general * (k < 3 ? 1 : gyration[i]);
    }
  }
  normals.find(matrix, sensitivity, adjoint, scratch);
}

int StepGradient::Impl::columns(StepInput input) const {
  switch (input) {
    case StepInput::state: return 12 * bodies();
    case StepInput::load:
    case StepInput::inertia: return 6 * bodies();
    case StepInput::mass: return bodies();
    case StepInput::effort: return static_cast<int>(lane().mechanism.joints.size());
    case StepInput::friction: return static_cast<int>(lane().mechanism.contacts.size());
  }
  return 0;
}

int StepGradient::Impl::offset(StepInput input) const {
  int sum = 0;
  for (int k = 0; k < static_cast<int>(input); ++k) sum += columns(static_cast<StepInput>(k));
  return sum;
}

void StepGradient::Impl::check(std::string_view name, std::size_t given, int wanted) const {
  if (!ready) throw std::logic_error("a step gradient was asked before evaluate() returned `ready`");
  if (given != static_cast<std::size_t>(wanted))
    throw std::invalid_argument(fmt::format("{} has {} numbers instead of {}", name, given, wanted));
}

StepGradient::StepGradient(Simulator& simulator, const GradientSettings& settings)
    : impl_(std::make_unique<Impl>(*simulator.impl_, settings)) {}
StepGradient::~StepGradient() = default;
StepGradient::StepGradient(StepGradient&&) noexcept = default;
StepGradient& StepGradient::operator=(StepGradient&&) noexcept = default;

GradientStatus StepGradient::evaluate() { return impl_->evaluate(); }
int StepGradient::moving_bodies() const { return impl_->bodies(); }
int StepGradient::moving_body(BodyId body) const {
  if (body.is_world()) return -1;
  const Lane& l = impl_->lane();
  if (body.index >= std::ssize(l.mechanism.bodies))
    throw std::out_of_range(fmt::format("there is no body {}", body.index));
  return l.place(body.index).body;
}
int StepGradient::state_size() const { return impl_->columns(StepInput::state); }
int StepGradient::columns(StepInput input) const { return impl_->columns(input); }
int StepGradient::offset(StepInput input) const { return impl_->offset(input); }
int StepGradient::gradient_size() const {
  return impl_->offset(StepInput::inertia) + impl_->columns(StepInput::inertia);
}

void StepGradient::vector_jacobian(std::span<const double> adjoint, std::span<double> gradient) {
  impl_->check("the adjoint", adjoint.size(), state_size());
  impl_->check("the gradient", gradient.size(), gradient_size());
  for (std::size_t i = 0; i < adjoint.size(); ++i)
    if (!std::isfinite(adjoint[i])) throw std::invalid_argument(fmt::format("the adjoint has {} at {}", adjoint[i], i));
  graphsolve::check_apart("vector_jacobian", adjoint, gradient);
  impl_->vector_jacobian(adjoint, gradient);
}

void StepGradient::jacobian(StepInput input, std::span<double> jacobian) {
  impl_->check("the Jacobian", jacobian.size(), state_size() * columns(input));
  impl_->jacobian(input, jacobian);
}

std::span<const double> StepGradient::velocity(int body) const {
  return std::span(impl_->x).subspan(impl_->row.at(body), 6);
}
const Vec3& StepGradient::position(int body) const { return impl_->next.at(body).x; }
const Quat& StepGradient::orientation(int body) const { return impl_->next.at(body).q; }

}  // namespace physics
