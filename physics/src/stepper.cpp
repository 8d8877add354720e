#include "stepper.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "rotation.hpp"

/// Steps of lanes: attempts, substeps, solves, new states.
namespace physics {

using graphsolve::Status;

namespace {

constexpr int more_when_turned = 16;  ///< the last resort may take this many times more substeps

/// Where a step fails, more and shorter ones; where these fail too, with the force directions at the new configuration.
bool next_rung(Stepper::Rung& rung, int max_substeps) {
  rung.parts *= 2;
  if (rung.parts <= (rung.new_direction ? more_when_turned : 1) * max_substeps) return true;
  if (rung.new_direction) return false;
  rung = {1, true};
  return true;
}

}  // namespace

void Stepper::step(std::span<const int> stepped) {
  contacts->save(stepped);
  for (const int lane : stepped) {
    save(lane);
    if (lanes[lane].last.ok()) lanes[lane].before = lanes[lane].last;
    lanes[lane].last = {};
  }
  attempt(stepped, {1, false});
  for (const int lane : stepped) {
    Lane& l = lanes[lane];
    Rung rung{1, false};
    while (!l.last.ok()) {
      restore(lane);
      if (!next_rung(rung, settings.max_substeps)) break;
      attempt({&lane, 1}, rung);
    }
    if (l.last.ok()) {
      ++l.step_index;
      l.time += dt;
    } else {
      l.last.cause = graphsolve::explanation(l.last.status);
      recall(lane);
    }
  }
  bodies.force_at_next = false;
}

void Stepper::attempt(std::span<const int> tried, const Rung& rung) {
  bodies.force_at_next = rung.new_direction;
  for (const int lane : tried) lanes[lane].attempt = {};
  going_.assign(tried.begin(), tried.end());
  for (int part = 1; part <= rung.parts && !going_.empty(); ++part) {
    advance(going_, part, rung.parts);
    std::erase_if(going_, [&](int lane) { return lanes[lane].attempt.status != Status::solved; });
  }
  for (const int lane : tried) {
    const Lane::Attempt& attempt = lanes[lane].attempt;
    StepResult& result = lanes[lane].last;
    result.status = attempt.status;
    result.iterations += attempt.iterations;
    result.restarts += attempt.restarts + (rung.parts > 1 ? 1 : 0);
    result.culling_repeats += attempt.culling_repeats;
    result.residual = attempt.residual;
    result.substeps = rung.parts;
    result.new_force_direction = rung.new_direction;
  }
}

/// One step of the integrator (eq. 24): part of `parts` equal ones.
void Stepper::advance(std::span<const int> moved, int part, int parts) {
  using Clock = std::chrono::steady_clock;
  const auto clock = [&] { return settings.time_phases ? Clock::now() : Clock::time_point(); };
  const auto begin = clock();
  const double h = dt / parts;
  for (const int lane : moved) load_state_into_terms(lane, h);
  contacts->look(unknowns);
  for (const int lane : moved) {
    const double smallest_distance = prepare(lane, h, lanes[lane].time + dt * part / parts);
    if (part == 1) lanes[lane].smallest_distance = smallest_distance;
  }
  joints.aim();
  contacts->activate(*solver);
  const auto prepared = clock();
  const double inside = profile.evaluate + profile.factorize + profile.solve;

  solve(moved);
  for (const int lane : moved)
    if (lanes[lane].attempt.status == Status::solved) commit(lane, h);
  times.prepare += std::chrono::duration<double>(prepared - begin).count();
  const double rest = std::chrono::duration<double>(clock() - prepared).count();
  times.finish += rest - (profile.evaluate + profile.factorize + profile.solve - inside);
  times.evaluate = profile.evaluate;
  times.factorize = profile.factorize;
  times.solve = profile.solve;
}

/// After its state was loaded. Returns the smallest distance of the lane's contacts.
double Stepper::prepare(int lane, double h, double end_time) {
  Lane& l = lanes[lane];
  const double impulse_time = l.state.half_kick ? 0.5 * h : h;
  const double factor = l.state.impulse_time > 0 ? impulse_time / l.state.impulse_time : 1.0;
  apply_loads(lane, impulse_time);
  for (int k = 0; k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
    joints.prepare(j, end_time, impulse_time);
    if (factor != 1)
      for (int r = 0; r < joints.rows(j); ++r) unknowns[joints.row(j) + r] *= factor;
  }
  const Contacts::Reach reach = contacts->prepare(lane, unknowns,
                                                  {.dt = h,
                                                   .gravity = l.mechanism.gravity,
                                                   .force_factor = factor,
                                                   .cull = settings.cull_contacts});
  size.contact_steps += contacts->size_of_lane();
  size.culled_contacts += contacts->size_of_lane() - reach.active;
  if (reach.active == 0) ++size.newton_steps;
  return reach.smallest_distance;
}

/// Solves with the contacts that can be reached; puts back those that the result breaks through.
void Stepper::solve(std::span<const int> solved) {
  solving_.assign(solved.begin(), solved.end());
  while (true) {
    select(solving_);
    (void)solver->solve(unknowns, 1, noise);
    std::erase_if(solving_, [&](int lane) {
      if (!take_reports(lanes[lane]) || contacts->put_back(lane) == 0) return true;
      ++lanes[lane].attempt.culling_repeats;
      return false;
    });
    if (solving_.empty()) return;
    contacts->activate(*solver);
  }
}

void Stepper::select(std::span<const int> selected) {
  components_.clear();
  for (const int lane : selected)
    components_.insert(components_.end(), lanes[lane].islands.begin(), lanes[lane].islands.end());
  std::sort(components_.begin(), components_.end());
  solver->select(components_);
}

bool Stepper::take_reports(Lane& lane) {
  for (const int c : lane.islands) {
    const graphsolve::ComponentReport& report = solver->reports()[c];
    lane.attempt.iterations += report.iterations;
    lane.attempt.restarts += report.attempts - 1;
    lane.attempt.residual = std::max(lane.attempt.residual, report.residual);
    if (report.status == Status::solved) continue;
    lane.attempt.status = report.status;
    lane.failure = report;
  }
  return lane.attempt.status == Status::solved;
}

void Stepper::load_state_into_terms(int lane, double h) {
  const LaneState& s = lanes[lane].state;
  bodies.dt = h;
  for (const int c : lanes[lane].islands) noise[c] = 0;
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    bodies.place(i, state.x[i], state.q[i]);
    bodies.known_linear[i] = bodies.mass[i] * state.v[i];
    bodies.known_angular[i] = s.half_kick ? Vec3(bodies.inertia[i] * state.w[i])
                                          : momentum_minus(bodies.inertia[i], state.w[i], s.time_step);
    double* velocity = unknowns.data() + bodies.row[i];
    Eigen::Map<Vec3>{velocity} = state.v[i];
    // A step that starts where |w| is too large for its length would have no defined residual.
    const double bound = 0.95 * Bodies::largest_turn / h, spin = state.w[i].norm();
    Eigen::Map<Vec3>{velocity + 3} = spin > bound ? Vec3(state.w[i] * (bound / spin)) : state.w[i];
    noise[island[i]] = std::max(noise[island[i]], 8 * 2.2e-16 * state.x[i].lpNorm<Eigen::Infinity>() / h);
  }
}

void Stepper::apply_loads(int lane, double time_of_impulse) {
  const Lane& l = lanes[lane];
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    bodies.known_linear[i] += time_of_impulse * bodies.mass[i] * l.mechanism.gravity;
  }
  const int step = l.step_index + 1;
  for (const Load& load : l.mechanism.loads) {
    if (step < load.first_step || step > load.last_step) continue;
    const Placement& place = l.placement[load.body.index];
    if (place.body < 0) continue;
    const int i = body(lane, place.body);
    bodies.known_linear[i] += time_of_impulse * load.force;
    // The force acts at the described body's own centre of mass.
    const Vec3 arm = place.offset.cross(bodies.now[i].rotation.transpose() * load.force);
    bodies.known_angular[i] += time_of_impulse * (place.rotation * load.torque + arm);
  }
}

void Stepper::commit(int lane, double h) {
  LaneState& s = lanes[lane].state;
  s.impulse_time = s.half_kick ? 0.5 * h : h;
  s.potential_energy = potential_energy(lane);
  s.previous_kinetic_energy = s.kinetic_energy;
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    const double* velocity = unknowns.data() + bodies.row[i];
    state.v[i] = Eigen::Map<const Vec3>(velocity);
    state.w[i] = Eigen::Map<const Vec3>(velocity + 3);
    // The poses of the converged iterate are those that the residual was measured at.
    bodies.commit(i);
    state.x[i] = bodies.now[i].x;
    state.q[i] = bodies.now[i].q;
  }
  s.kinetic_energy = kinetic_energy(lane);
  s.time_step = h;
  s.half_kick = false;
  if (!joints.any_motor()) return;
  for (int k = 0; k < joints_per_lane; ++k) joints.commit(joint(lane, k));
}

namespace {

void copy_body(const State& from, State& to, int i) {
  to.x[i] = from.x[i];
  to.q[i] = from.q[i];
  to.v[i] = from.v[i];
  to.w[i] = from.w[i];
}

}  // namespace

void Stepper::save(int lane) {
  lanes[lane].saved_state = lanes[lane].state;
  const int rows = rows_per_lane();
  std::copy_n(unknowns.data() + lane * rows, rows, saved_unknowns.data() + lane * rows);
  for (int k = 0; k < bodies_per_lane; ++k) copy_body(state, saved_state, body(lane, k));
  if (!joints.any_motor()) return;
  for (int k = 0; k < joints_per_lane; ++k) joints.save(joint(lane, k));
}

void Stepper::restore(int lane) {
  lanes[lane].state = lanes[lane].saved_state;
  const int rows = rows_per_lane();
  std::copy_n(saved_unknowns.data() + lane * rows, rows, unknowns.data() + lane * rows);
  for (int k = 0; k < bodies_per_lane; ++k) copy_body(saved_state, state, body(lane, k));
  for (int k = 0; k < joints_per_lane; ++k) joints.restore(joint(lane, k));
  contacts->clear(lane);
}

}  // namespace physics
