#pragma once

#include <optional>
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
  physics::StepRecord start, end;
};

/// Of the first body of the scene, over the run.
struct Motion {
  std::string body;
  physics::Vec3 moved;  ///< [m], in the world
  double turned;        ///< about one axis [rad], 0 .. 2 pi; a turn more is not seen
};
/// None where there is no body.
std::optional<Motion> motion(const Report& report);

std::string for_people(const Report& report);
std::string as_json(const Report& report);

}  // namespace cli
