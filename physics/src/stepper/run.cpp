#include "physics/run.hpp"

#include <algorithm>
#include <cmath>
#include <chrono>

namespace physics {

namespace {

PhaseTimes operator-(const PhaseTimes& a, const PhaseTimes& b) {
  return {a.prepare - b.prepare, a.evaluate - b.evaluate, a.factorize - b.factorize, a.solve - b.solve,
          a.finish - b.finish};
}

void count(RunSummary& summary, graphsolve::Status status) {
  auto& statuses = summary.statuses;
  const auto known = std::find_if(statuses.begin(), statuses.end(), [&](const auto& s) { return s.first == status; });
  known == statuses.end() ? void(statuses.emplace_back(status, 1)) : void(++known->second);
}

/// Written so that NaN replaces anything and stays: it must not hide.
void raise(Extreme& extreme, double value, int step) {
  if (value > extreme.value || std::isnan(value)) extreme = {value, step};
}
void lower(Extreme& extreme, double value, int step) {
  if (value < extreme.value || std::isnan(value)) extreme = {value, step};
}

void begin(RunSummary& summary, const Simulator& simulator) {
  const int step = simulator.step_index();
  summary.first_step = step;
  summary.residual = {0, step};
  summary.distance = {simulator.smallest_distance(), step};
  summary.joint_error = {simulator.largest_joint_error(), step};
  summary.energy_start = simulator.energy();
  summary.momentum_start = simulator.linear_momentum();
  summary.angular_momentum_start = simulator.angular_momentum();
  summary.start_correction = simulator.start_correction();
  summary.start_energy_loss = simulator.start_energy_loss();
  summary.redundancies = simulator.redundancies();
}

void add(RunSummary& summary, const Simulator& simulator, const StepResult& result) {
  const int step = simulator.step_index();
  ++summary.steps;
  summary.iterations += result.iterations;
  summary.most_iterations = std::max(summary.most_iterations, result.iterations);
  summary.substepped_steps += result.substeps > 1;
  summary.restarted_steps += result.restarts > 0;
  summary.turned_steps += result.new_force_direction;
  summary.culling_repeats += result.culling_repeats;
  raise(summary.residual, result.residual, step);
  lower(summary.distance, simulator.smallest_distance(), step);
  raise(summary.joint_error, simulator.largest_joint_error(), step);
}

void end(RunSummary& summary, const Simulator& simulator) {
  summary.energy_end = simulator.energy();
  summary.momentum_end = simulator.linear_momentum();
  summary.angular_momentum_end = simulator.angular_momentum();
  summary.size = simulator.problem_size();
}

}  // namespace

RunResult run(Simulator& simulator, int steps, const RunOptions& options) {
  using Clock = std::chrono::steady_clock;
  RunResult result;
  RunSummary& summary = result.summary;
  begin(summary, simulator);
  const PhaseTimes phases_before = simulator.phase_times();
  const double time_before = simulator.time();
  const auto clock_before = Clock::now();
  StepRecord record;  // one for all steps, so that its lists are allocated once
  const auto write_record = [&] {
    if (!options.record) return;
    simulator.write_record(record);
    options.record(record);
  };
  write_record();
  while (summary.steps < steps && !result.stopped) {
    result.last = simulator.step();
    count(summary, result.last.status);
    if (!result.last.ok()) {
      result.failure = FailureRecord{.step = simulator.step_index() + 1,
                                     .status = std::string(graphsolve::name(result.last.status)),
                                     .place = simulator.failure_place(),
                                     .cause = std::string(result.last.cause)};
      break;
    }
    add(summary, simulator, result.last);
    write_record();
    result.stopped = options.on_step && !options.on_step(simulator, result.last);
  }
  summary.wall_time = std::chrono::duration<double>(Clock::now() - clock_before).count();
  summary.simulated_time = simulator.time() - time_before;
  summary.phases = simulator.phase_times() - phases_before;
  end(summary, simulator);
  return result;
}

}  // namespace physics
