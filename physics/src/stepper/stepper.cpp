#include "stepper/stepper.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "graphsolve/largest.hpp"
#include "stepper/ladder.hpp"
#include "terms/rotation.hpp"

/// Steps of lanes: attempts, substeps, solves, new states.
namespace physics {

using graphsolve::Status;

void Stepper::step(std::span<const int> stepped) {
  contacts->save(stepped);
  save(stepped);
  for (const int lane : stepped) {
    if (lanes[lane].last.ok()) lanes[lane].before = lanes[lane].last;
    lanes[lane].last = {};
  }
  attempt(stepped, {.parts = 1, .new_direction = false, .more_starts = false});
  const Ladder ladder(settings.max_substeps);
  for (const int lane : stepped) {
    Lane& l = lanes[lane];
    if (!l.last.ok()) {
      const auto again = [&](const Rung& rung) {
        restore(lane);
        attempt({&lane, 1}, rung);
        bodies.forget_missed(lane);  // so that who sums up momenta may begin anew after a step that was not whole
        return l.last.ok();
      };
      ladder.climb(l.before, l.turned_in_a_row, again);
      if (!l.last.ok()) start_anywhere(lane, again);
    }
    if (l.last.ok()) {
      ++l.step_index;
      l.turned_in_a_row = l.last.new_force_direction ? l.turned_in_a_row + 1 : 0;
    } else {
      restore(lane);
      l.last.cause = step_explanation(l.last.status);
      recall(lane);
    }
  }
  bodies.force_at_next = false;
}

/// Where all rungs failed: from more starts. What is told of a step that fails all the same is what the rungs told.
template <class Again>
void Stepper::start_anywhere(int lane, Again&& again) {
  Lane& l = lanes[lane];
  const StepResult told = l.last;
  const graphsolve::ComponentReport failure = l.failure;
  for (int parts = 1; parts <= settings.max_substeps; parts *= 2)
    if (again({.parts = parts, .new_direction = false, .more_starts = true})) return;
  const int iterations = l.last.iterations;
  l.last = told;
  l.last.iterations = iterations;
  l.failure = failure;
}

void Stepper::attempt(std::span<const int> tried, const Rung& rung) {
  bodies.force_at_next = rung.new_direction;
  solver->set_more_starts(rung.more_starts);
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
  const auto started = clock();
  const double h = dt / parts;
  begin(moved, h);
  contacts->look(unknowns);
  for (const int lane : moved) {
    const double smallest_distance = prepare(lane, h, lanes[lane].time(static_cast<double>(part) / parts));
    if (part == 1) lanes[lane].smallest_distance = smallest_distance;
  }
  joints.aim(moved);
  contacts->activate(*solver);
  const auto prepared = clock();
  const double inside = profile.evaluate + profile.factorize + profile.solve;

  solve(moved);
  solved_.assign(moved.begin(), moved.end());
  std::erase_if(solved_, [&](int lane) { return lanes[lane].attempt.status != Status::solved; });
  commit(solved_, h);
  times.prepare += std::chrono::duration<double>(prepared - started).count();
  const double rest = std::chrono::duration<double>(clock() - prepared).count();
  times.finish += rest - (profile.evaluate + profile.factorize + profile.solve - inside);
  times.evaluate = profile.evaluate;
  times.factorize = profile.factorize;
  times.solve = profile.solve;
}

/// After it was begun. Returns the smallest distance of the lane's contacts.
double Stepper::prepare(int lane, double h, double end_time) {
  Lane& l = lanes[lane];
  const double impulse_time = l.state.half_kick ? 0.5 * h : h;
  const double factor = l.state.impulse_time > 0 ? impulse_time / l.state.impulse_time : 1.0;
  apply_loads(lane, impulse_time);
  for (int k = 0; joints.any_motor() && k < joints_per_lane; ++k)
    joints.prepare(joint(lane, k), end_time, impulse_time);
  for (int k = 0; factor != 1 && k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
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
    graphsolve::keep_largest(lane.attempt.residual, report.residual);
    if (report.status == Status::solved) continue;
    lane.attempt.status = report.status;
    lane.failure = report;
  }
  return lane.attempt.status == Status::solved;
}

void Stepper::begin(std::span<const int> begun, double h) {
  bodies.dt = h;
  constexpr double rounding = 8 * 2.2e-16;  // of a distance
  const auto alike = [&](int a, int b) {
    const LaneState &s = lanes[a].state, &t = lanes[b].state;
    return s.time_step == t.time_step && s.half_kick == t.half_kick;
  };
  unsigned beyond = 0;
  for (std::size_t first = 0, end = 0; first < begun.size(); first = end) {
    while (end < begun.size() && alike(begun[first], begun[end])) ++end;
    const LaneState& s = lanes[begun[first]].state;
    beyond |= bodies.begin(begun.subspan(first, end - first), {.dt = h,
                                                               .time_step = s.time_step,
                                                               .impulse_time = s.half_kick ? 0.5 * h : h,
                                                               .half_kick = s.half_kick,
                                                               .most_spin = most_spin(h),
                                                               .most_distance = settings.tolerance * h / rounding});
  }
  for (const int lane : begun) {
    for (const int c : lanes[lane].islands) noise[c] = 0;
    if (beyond & lies_further) note_distances(lane);
    if ((beyond & spins_faster) || !lanes[lane].state.solved_for) begin_with_velocities(lane);
  }
}

void Stepper::begin_with_velocities(int lane) {
  lanes[lane].state.solved_for = false;
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    const Vec3 w = bodies.spin(i);
    double* velocity = unknowns.data() + bodies.row[i];
    Eigen::Map<Vec3>{velocity} = bodies.velocity(i);
    // A step that starts where |w| is too large for its length would have no defined residual.
    const double most = most_spin(bodies.dt), spin = w.norm();
    Eigen::Map<Vec3>{velocity + 3} = spin > most ? Vec3(w * (most / spin)) : w;
  }
}

/// Far from the origin the residual of a joint cannot fall below what rounding leaves of the distance.
void Stepper::note_distances(int lane) {
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    const double of_position = 8 * 2.2e-16 * bodies.position(i).lpNorm<Eigen::Infinity>() / bodies.dt;
    noise[island[i]] = std::max(noise[island[i]], std::min(of_position, lanes[lane].most_noise));
  }
}

/// What is neither gravity nor a joint's or contact's.
void Stepper::apply_loads(int lane, double time_of_impulse) {
  const Lane& l = lanes[lane];
  const int step = l.step_index + 1;
  for (const Load& load : l.mechanism.loads) {
    if (step < load.first_step || step > load.last_step) continue;
    const Placement place = l.place(load.body.index);
    if (place.body < 0) continue;
    const int i = body(lane, place.body);
    // The force acts at the described body's own centre of mass.
    const Vec3 arm = place.offset.cross(bodies.pose_now(i).rotation.transpose() * load.force);
    bodies.add_known(i, time_of_impulse * load.force, time_of_impulse * (place.rotation * load.torque + arm));
  }
}

/// The poses of the converged iterate are those that the residual was measured at.
void Stepper::commit(std::span<const int> moved, double h) {
  if (!bodies.commit(moved, solver->residual()))
    for (const int lane : moved) refuse_without_energy(lane);
  for (const int lane : moved) {
    LaneState& s = lanes[lane].state;
    s.impulse_time = s.half_kick ? 0.5 * h : h;
    s.time_step = h;
    s.half_kick = false;
    s.solved_for = true;
    for (int k = 0; joints.keeps_coordinates() && k < joints_per_lane; ++k) joints.commit(joint(lane, k));
  }
}

/// A body that went so far or so fast that nothing more could be told of it: the equations are solved, and the attempt
/// has failed all the same.
void Stepper::refuse_without_energy(int lane) {
  Lane& l = lanes[lane];
  for (int k = 0; k < bodies_per_lane; ++k) {
    if (bodies.has_energy(body(lane, k), l.mechanism.gravity)) continue;
    l.attempt.status = Status::not_finite;
    l.failure = {};
    l.failure.worst_node = body_node(lane, k);
    l.failure.residual = std::numeric_limits<double>::infinity();
    return;
  }
}

void Stepper::save(std::span<const int> saved) {
  bodies.save();
  for (const int lane : saved) {
    lanes[lane].saved_state = lanes[lane].state;
    const auto of_joints = impulses(lane);
    std::ranges::copy(of_joints, saved_impulses.begin() + lane * std::ssize(of_joints));
    for (int k = 0; joints.keeps_coordinates() && k < joints_per_lane; ++k) joints.save(joint(lane, k));
  }
}

void Stepper::restore(int lane) {
  lanes[lane].state = lanes[lane].saved_state;
  bodies.restore(lane);
  bodies.forget_missed(lane);
  begin_with_velocities(lane);
  const auto of_joints = impulses(lane);
  std::copy_n(saved_impulses.begin() + lane * std::ssize(of_joints), of_joints.size(), of_joints.begin());
  for (int k = 0; k < joints_per_lane; ++k) joints.restore(joint(lane, k));
  contacts->clear(lane);
}

}  // namespace physics
