#pragma once

#include <string>

#include "physics/trajectory.hpp"

/// From the structs to text, in pieces, so that a trajectory can be written while it is computed.
namespace physics::io {

/// A scene, and where the steps of a trajectory go: header, steps joined by `json_step_separator`, footer.
std::string json_scene(const Mechanism& mechanism);
std::string json_header(const Mechanism& mechanism);
std::string json_step(const StepRecord& record);
inline constexpr const char* json_step_separator = ",\n";
inline constexpr const char* json_footer = "\n  ]\n}\n";

std::string csv_header(const Mechanism& mechanism);
std::string csv_row(const StepRecord& record, const Mechanism& mechanism);

}  // namespace physics::io
