#include "physics/simulator.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "rotation.hpp"
#include "simulator_impl.hpp"

namespace physics {

using graphsolve::Status;

namespace {

constexpr int more_when_turned = 16;  ///< the last resort may take this many times more substeps

}  // namespace

Simulator::Simulator(Mechanism mechanism, const SimulatorSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(mechanism), settings)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

/// One step; where that fails, more and shorter ones; where these fail too, with the force directions at the
/// new configuration. A failed step leaves the state as it was.
StepResult Simulator::step() {
  Impl& s = *impl_;
  StepResult result;
  s.save();
  for (const bool new_direction : {false, true}) {
    s.bodies.force_at_next = new_direction;
    result.new_force_direction = new_direction;
    const int most = (new_direction ? more_when_turned : 1) * s.settings.max_substeps;
    for (int count = 1; count <= most; count *= 2) {
      const Impl::Attempt attempt = s.substeps(count);
      result.status = attempt.status;
      result.iterations += attempt.iterations;
      result.restarts += attempt.restarts + (count > 1 ? 1 : 0);
      result.culling_repeats += attempt.culling_repeats;
      result.residual = attempt.residual;
      result.substeps = count;
      if (result.ok()) break;
      s.restore();
    }
    if (result.ok()) break;
  }
  s.bodies.force_at_next = false;
  if (result.ok()) {
    ++s.step_index;
    s.time += s.dt;
  } else {
    result.cause = graphsolve::explanation(result.status);
  }
  s.last = result;
  return result;
}

void Simulator::Impl::save() {
  saved_state = state;  // equal sizes: copies, allocates nothing
  saved_unknowns = unknowns;
}

void Simulator::Impl::restore() {
  state = saved_state;
  unknowns = saved_unknowns;
  contacts->clear();
}

Simulator::Impl::Attempt Simulator::Impl::substeps(int count) {
  Attempt total;
  for (int i = 1; i <= count; ++i) {
    const Attempt attempt = advance(dt / count, time + dt * i / count);
    total.iterations += attempt.iterations;
    total.restarts += attempt.restarts;
    total.culling_repeats += attempt.culling_repeats;
    total.residual = std::max(total.residual, attempt.residual);
    total.status = attempt.status;
    if (attempt.status != Status::solved) break;
  }
  return total;
}

/// One step of the integrator (eq. 24) of length h.
Simulator::Impl::Attempt Simulator::Impl::advance(double h, double to_time) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const double new_impulse_time = state.half_kick ? 0.5 * h : h;
  load_state_into_terms(h);
  apply_loads(new_impulse_time);
  joints.prepare(to_time, new_impulse_time);
  contacts->prepare(unknowns, h, mechanism.gravity, settings.cull_contacts, *solver);
  size.contact_steps += contacts->size();
  size.culled_contacts += contacts->size() - contacts->active();
  if (contacts->active() == 0) ++size.newton_steps;
  const double factor = impulse_time > 0 ? new_impulse_time / impulse_time : 1.0;
  for (int i = 0; i < joints.size(); ++i)
    for (int r = 0; r < joints.rows(i); ++r) unknowns[joints.row(i) + r] *= factor;
  const auto prepared = Clock::now();
  const double inside = profile.evaluate + profile.factorize + profile.solve;

  Attempt attempt = solve();
  if (attempt.status == Status::solved) {
    impulse_time = new_impulse_time;
    commit(h);
  }
  times.prepare += std::chrono::duration<double>(prepared - begin).count();
  const double rest = std::chrono::duration<double>(Clock::now() - prepared).count();
  times.finish += rest - (profile.evaluate + profile.factorize + profile.solve - inside);
  times.evaluate = profile.evaluate;
  times.factorize = profile.factorize;
  times.solve = profile.solve;
  return attempt;
}

/// Solves with the contacts that can be reached; puts back those that the result breaks through.
Simulator::Impl::Attempt Simulator::Impl::solve() {
  Attempt attempt;
  double factor = impulse_time > 0 ? (state.half_kick ? 0.5 : 1.0) * bodies.dt / impulse_time : 1.0;
  while (true) {
    attempt.status = solver->solve(unknowns, factor, noise);
    for (const auto& report : solver->reports()) {
      attempt.iterations += report.iterations;
      attempt.restarts += report.attempts - 1;
      attempt.residual = std::max(attempt.residual, report.residual);
      if (report.status != Status::solved) failure = report;
    }
    if (attempt.status != Status::solved || contacts->put_back(*solver) == 0) return attempt;
    ++attempt.culling_repeats;
    factor = 1;
  }
}

void Simulator::Impl::load_state_into_terms(double h) {
  bodies.dt = h;
  std::fill(noise.begin(), noise.end(), 0.0);
  for (int i = 0; i < bodies.size(); ++i) {
    Pose& pose = bodies.now[i];
    pose.x = state.x[i];
    pose.q = state.q[i];
    pose.rotation = pose.q.toRotationMatrix();
    bodies.known_linear[i] = bodies.mass[i] * state.v[i];
    bodies.known_angular[i] = state.half_kick ? Vec3(bodies.inertia[i] * state.w[i])
                                              : momentum_minus(bodies.inertia[i], state.w[i], state.time_step);
    double* velocity = unknowns.data() + bodies.row[i];
    Eigen::Map<Vec3>{velocity} = state.v[i];
    // A step that starts where |w| is too large for its length would have no defined residual.
    const double bound = 0.95 * Bodies::largest_turn / h, spin = state.w[i].norm();
    Eigen::Map<Vec3>{velocity + 3} = spin > bound ? Vec3(state.w[i] * (bound / spin)) : state.w[i];
    noise[island[i]] = std::max(noise[island[i]], 8 * 2.2e-16 * state.x[i].lpNorm<Eigen::Infinity>() / h);
  }
}

void Simulator::Impl::apply_loads(double time_of_impulse) {
  for (int i = 0; i < bodies.size(); ++i)
    bodies.known_linear[i] += time_of_impulse * bodies.mass[i] * mechanism.gravity;
  const int step = step_index + 1;
  for (const Load& load : mechanism.loads) {
    if (step < load.first_step || step > load.last_step) continue;
    const Placement& place = assembly.placement[load.body.index];
    if (place.body < 0) continue;
    const Pose& pose = bodies.now[place.body];
    bodies.known_linear[place.body] += time_of_impulse * load.force;
    // The force acts at the described body's own centre of mass.
    const Vec3 arm = place.offset.cross(pose.rotation.transpose() * load.force);
    bodies.known_angular[place.body] += time_of_impulse * (place.rotation * load.torque + arm);
  }
}

void Simulator::Impl::commit(double h) {
  state.potential_energy = potential_energy();
  state.previous_kinetic_energy = state.kinetic_energy;
  for (int i = 0; i < bodies.size(); ++i) {
    const double* velocity = unknowns.data() + bodies.row[i];
    state.v[i] = Eigen::Map<const Vec3>(velocity);
    state.w[i] = Eigen::Map<const Vec3>(velocity + 3);
    // The poses of the converged iterate are those that the residual was measured at.
    state.x[i] = bodies.next[i].x;
    state.q[i] = bodies.next[i].q;
    bodies.now[i] = bodies.next[i];
    bodies.now[i].turn.setIdentity();
  }
  state.kinetic_energy = kinetic_energy();
  state.time_step = h;
  state.half_kick = false;
  joints.commit();
}

double Simulator::Impl::kinetic_energy() const {
  double sum = 0;
  for (int i = 0; i < bodies.size(); ++i)
    sum += 0.5 * (bodies.mass[i] * state.v[i].squaredNorm() + state.w[i].dot(bodies.inertia[i] * state.w[i]));
  return sum;
}

double Simulator::Impl::potential_energy() const {
  double sum = 0;
  for (int i = 0; i < bodies.size(); ++i) sum -= bodies.mass[i] * mechanism.gravity.dot(state.x[i]);
  return sum;
}

}  // namespace physics
