#pragma once

#include "io/values.hpp"
#include "physics/trajectory.hpp"

/// From the tree to the structs. Throw ReadError.
namespace physics::io {

/// Takes the keys of a scene from the file's outermost object, all but `steps`.
void read_mechanism(Object& file, Mechanism& mechanism);

std::vector<StepRecord> read_steps(const Json& steps, const Mechanism& mechanism);

/// Of a run with these records.
FailureRecord read_failure(const Json& json, const std::vector<StepRecord>& steps);

}  // namespace physics::io
