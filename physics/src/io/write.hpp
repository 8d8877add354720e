#pragma once

#include <string>

#include "physics/trajectory.hpp"

/// From the structs to text, in pieces, so that a trajectory can be written while it is computed.
namespace physics::io {

/// A scene, and where the steps of a trajectory go: header, steps joined by `json_step_separator`, end.
std::string json_scene(const Mechanism& mechanism);
std::string json_header(const Mechanism& mechanism);
std::string json_step(const StepRecord& record);
inline constexpr const char* json_step_separator = ",\n";
std::string json_end(const std::optional<FailureRecord>& failure);

std::string csv_header(const Mechanism& mechanism);
std::string csv_row(const StepRecord& record, const Mechanism& mechanism);
std::string csv_end(const std::optional<FailureRecord>& failure, const Mechanism& mechanism);

}  // namespace physics::io
