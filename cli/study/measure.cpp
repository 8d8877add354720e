#include "study/measure.hpp"

#include <algorithm>
#include <cassert>

#include "timing.hpp"

namespace cli::study {

Spread spread(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  const double median = values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
  return {values.front(), median, values.back()};
}

Run timed_run(physics::Simulator& simulator, int steps) {
  Run run;
  const double begin = timing::thread_time();
  for (; run.steps < steps; ++run.steps) {
    const physics::StepResult result = simulator.step();
    if (!result.ok()) break;
    run.iterations += result.iterations;
    run.helped_steps += result.substeps > 1 || result.restarts > 0 || result.new_force_direction;
  }
  run.seconds = timing::thread_time() - begin;
  return run;
}

}  // namespace cli::study
