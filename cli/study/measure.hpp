#pragma once

#include <vector>

#include "physics/simulator.hpp"

/// How long things take: CPU time of this thread, so that a busy machine counts less.
namespace cli::study {

double thread_cpu_seconds();

/// Of equal measurements.
struct Spread {
  double best = 0, median = 0, worst = 0;
};
/// At least one value (asserted).
Spread spread(std::vector<double> values);

/// The unit in which machines are compared: one Eigen::LDLT of a 6x6 matrix plus one solve, fixed size, over 256
/// different matrices [ns].
double unit_nanoseconds();

/// Makes these steps and nothing else; ends at the first that fails.
struct Run {
  double seconds = 0;  ///< CPU time of the steps; building the simulator is not in it
  int steps = 0;       ///< solved
  long long iterations = 0;
  int helped_steps = 0;  ///< needed substeps, another start or the force direction at the new configuration
};
Run timed_run(physics::Simulator& simulator, int steps);

}  // namespace cli::study
