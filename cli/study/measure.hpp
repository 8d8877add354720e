#pragma once

#include <vector>

#include "physics/simulator.hpp"

/// How long things take: CPU time of this thread, so that a busy machine counts less.
namespace cli::study {

/// Of equal measurements.
struct Spread {
  double best = 0, median = 0, worst = 0;
};
/// At least one value (asserted).
Spread spread(std::vector<double> values);

/// Makes these steps and nothing else; ends at the first that fails.
struct Run {
  double seconds = 0;  ///< CPU time of the steps; building the simulator is not in it
  int steps = 0;       ///< solved
  long long iterations = 0;
  int helped_steps = 0;  ///< needed substeps, another start or the force direction at the new configuration
};
Run timed_run(physics::Simulator& simulator, int steps);

}  // namespace cli::study
