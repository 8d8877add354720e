#pragma once

#include <string>

#include "physics/run.hpp"

/// A run's summary, for people and for programs.
namespace cli {

struct Report {
  std::string scene;  ///< as named on the command line
  int steps_wanted = 0;
  double tolerance = 0;  ///< [m/s]
  int signal = 0;        ///< that stopped the run, 0: none
  const physics::Mechanism& mechanism;
  const physics::RunResult& result;
};

std::string for_people(const Report& report);
std::string as_json(const Report& report);

}  // namespace cli
