#pragma once

#include <string>

#include "physics/trajectory.hpp"

/// Where a scene comes from: a file or the built-in ones.
namespace cli {

struct SceneSource {
  physics::Trajectory trajectory;  ///< without steps, unless a file holds some
  double duration = 1;             ///< how long to simulate when nobody says [s]
};

/// A name that ends in .json or .toml, or contains a slash, is a file; anything else is a built-in scene.
bool is_scene_file(const std::string& name);

/// Throws DescriptionError.
SceneSource load_scene(const std::string& name);

/// What a step of the scene is accepted at where this tolerance was asked for [m/s]. Says on the standard error where that
/// is less.
double tolerance_used(double asked, const physics::Mechanism& scene);

/// The record of that step. Throws DescriptionError that says which there are, or that its numbers are wrong.
const physics::StepRecord& find_record(const physics::Trajectory& trajectory, int step, const std::string& name);

}  // namespace cli
