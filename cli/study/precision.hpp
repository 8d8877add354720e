#pragma once

#include <functional>
#include <string>
#include <vector>

#include "physics/simulator.hpp"
#include "study/study.hpp"

/// What the two experiments of the precision study share.
namespace cli::study {

/// One run: what was asked for, what it cost, how wrong it was.
struct Sample {
  double time_step = 0;  ///< [s]
  double tolerance = 0;  ///< [m/s]
  physics::Start start = physics::Start::half_kick;
  physics::FrictionModel model = physics::FrictionModel::aligned;
  double heading = 0;       ///< [deg]
  double error = 0;         ///< [m], or a fraction of the exact distance
  double milliseconds = 0;  ///< CPU time of the run, best of several
  double iterations = 0;    ///< mean per step
  int steps = 0, failed = 0, helped = 0;
};

/// Runs the scene from the start for `steps` steps of the sample's time step, a few times, and fills in all but the
/// error. Returns the last record of the first run; NaN positions when a step failed.
physics::StepRecord run_sample(physics::Mechanism scene, int steps, Sample& sample);

std::string name(physics::Start start);
std::string name(physics::FrictionModel model);
/// `error`: its key in the data, which names the unit.
Json to_json(const Sample& sample, const char* error);

Outcome pendulum_precision(Extent extent, const std::function<void()>& tick);
Outcome block_precision(Extent extent, const std::function<void()>& tick);

/// How often each calls `tick`.
int pendulum_ticks(Extent extent);
int block_ticks(Extent extent);

}  // namespace cli::study
