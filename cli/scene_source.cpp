#include "scene_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

/// The record must satisfy what the start of a scene must.
void check_record(const physics::Trajectory& trajectory, const physics::StepRecord& record) {
  physics::Mechanism scene = trajectory.mechanism;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const physics::BodyRecord& body = record.bodies[i];
    scene.bodies[i].position = body.position;
    scene.bodies[i].orientation = body.orientation;
    scene.bodies[i].velocity = body.velocity;
    scene.bodies[i].angular_velocity = body.angular_velocity;
  }
  physics::validate(scene);
}

}  // namespace

bool is_scene_file(const std::string& name) {
  if (name.ends_with(".json") || name.ends_with(".toml") || name.find('/') != std::string::npos) return true;
  // What is there, or looks like a file, is one, and gets the sentence that says how scene files end.
  const std::string short_name = name.substr(0, name.find(':'));
  const auto& known = physics::built_in_scenes();
  if (std::ranges::any_of(known, [&](const auto& info) { return info.name == short_name; })) return false;
  return short_name.find('.') != std::string::npos || std::filesystem::exists(name);
}

SceneSource load_scene(const std::string& name) {
  if (is_scene_file(name)) return {physics::read_scene(name)};
  SceneSource source{{physics::built_in_scene(name), {}}};
  const std::string short_name = name.substr(0, name.find(':'));
  for (const auto& info : physics::built_in_scenes())
    if (info.name == short_name) source.duration = info.duration;
  return source;
}

double tolerance_used(double asked, const physics::Mechanism& scene) {
  const double most = physics::loosest_tolerance(scene);
  if (asked <= most) return asked;
  fmt::print(stderr,
             "graphsolve: note: a tolerance of {} m/s would let things hover; |g| dt / 100 = {:.3g} m/s is taken instead\n",
             asked, most);
  return most;
}

const physics::StepRecord& find_record(const physics::Trajectory& trajectory, int step, const std::string& name) {
  const auto& steps = trajectory.steps;
  if (steps.empty()) throw DescriptionError(fmt::format("{}: holds no records, so it cannot be continued", name));
  const auto found =
      std::find_if(steps.begin(), steps.end(), [step](const auto& record) { return record.step == step; });
  if (found == steps.end())
    throw DescriptionError(fmt::format("{}: has no record {} (it holds {} between {} and {})", name, step, steps.size(),
                                       steps.front().step, steps.back().step));
  try {
    check_record(trajectory, *found);
  } catch (const DescriptionError& error) {
    throw DescriptionError(fmt::format("{}: record {}: {}", name, step, error.what()));
  }
  return *found;
}

}  // namespace cli
