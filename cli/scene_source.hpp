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

/// The same error said of this scene, with the line of the wrong value where a file holds it: "scene.toml:7: body 'box':
/// mass -1 kg is not > 0".
physics::DescriptionError about_scene(const std::string& name, const physics::DescriptionError& error);

/// What a step of the scene is accepted at where this tolerance was asked for [m/s]. Says on the standard error where that
/// is less.
double tolerance_used(double asked, const physics::Mechanism& scene);

/// Says on the standard error where the time step is long for what the scene does in one: gravity alone would move bodies
/// by more than their own size, or one starts by turning more than a tenth of a turn. Such steps are solved all the same.
void note_coarse_step(const physics::Mechanism& scene);

/// The record of that step. Throws DescriptionError that says which there are, or that its numbers are wrong.
const physics::StepRecord& find_record(const physics::Trajectory& trajectory, int step, const std::string& name);

}  // namespace cli
