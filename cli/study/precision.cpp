#include "study/precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "study/measure.hpp"

namespace cli::study {

physics::StepRecord run_sample(physics::Mechanism scene, int steps, Sample& sample) {
  constexpr double enough = 0.01;  // seconds of CPU time in which a clock is exact and noise averages out
  constexpr int most_runs = 20;
  scene.time_step = sample.time_step;
  scene.start = sample.start;
  physics::SimulatorSettings settings;
  settings.tolerance = sample.tolerance;
  settings.friction_model = sample.model;
  physics::StepRecord record;
  double spent = 0, best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_runs && (i < 3 || spent < enough); ++i) {
    physics::Simulator simulator(scene, settings);
    const Run run = timed_run(simulator, steps);
    spent += run.seconds;
    best = std::min(best, run.seconds);
    if (i > 0) continue;
    sample.steps = run.steps;
    sample.failed = steps - run.steps;
    sample.helped = run.helped_steps;
    sample.iterations = static_cast<double>(run.iterations) / std::max(1, run.steps);
    simulator.write_record(record);
    if (sample.failed)
      for (physics::BodyRecord& body : record.bodies) body.position.setConstant(NAN);
  }
  sample.milliseconds = 1e3 * best;
  return record;
}

std::string name(physics::Start start) { return start == physics::Start::half_kick ? "half_kick" : "standard"; }
std::string name(physics::FrictionModel model) {
  return model == physics::FrictionModel::aligned ? "aligned" : "pyramid";
}

Json to_json(const Sample& s, const char* error) {
  return {{"time_step_s", s.time_step}, {"tolerance_m_per_s", s.tolerance},
          {"start", name(s.start)},     {"friction_model", name(s.model)},
          {"heading_deg", s.heading},   {error, s.error},  // NaN becomes null: a step failed
          {"cpu_ms", s.milliseconds},   {"iterations_mean", s.iterations},
          {"steps_solved", s.steps},    {"failed_steps", s.failed},
          {"helped_steps", s.helped}};
}

Outcome precision(const Conditions& conditions, const OnProgress& progress) {
  const Extent extent = conditions.extent;
  const int total = pendulum_ticks(extent) + block_ticks(extent);
  int done = 0;
  const auto tick = [&] { progress(++done, total); };
  progress(0, total);
  const Outcome pendulum = pendulum_precision(extent, tick), block = block_precision(extent, tick);
  Outcome both{.text = pendulum.text + "\n" + block.text,
               .data = {{"pendulum", pendulum.data}, {"sliding_block", block.data}},
               .pictures = pendulum.pictures,
               .failed_steps = pendulum.failed_steps + block.failed_steps};
  both.pictures.insert(both.pictures.end(), block.pictures.begin(), block.pictures.end());
  return both;
}

}  // namespace cli::study
