#pragma once

#include <string>
#include <vector>

#include "physics/trajectory.hpp"

/// The trajectories of tests/data/reference: made by an independent dense oracle (two solvers of different kind
/// agreeing to 1e-9).
namespace reference {

/// All names, "pendulum", "cylinder_c8", ...
const std::vector<std::string>& names();

/// Reads one; throws when it is missing or says something unexpected.
physics::Trajectory read(const std::string& name);

}  // namespace reference
