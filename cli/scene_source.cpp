#include "scene_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <system_error>

#include "commands.hpp"
#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

constexpr double most_turns = 0.1;  ///< in a step; docs/scene_files.md, "Fast spin", has what comes of more

/// From the centre of mass of a body to the farthest place where something acts on it [m].
double largest_reach(const physics::Mechanism& scene) {
  double reach = 0;
  for (const physics::Joint& joint : scene.joints)
    reach = std::max({reach, joint.child_point.norm(), joint.parent.is_world() ? 0 : joint.parent_point.norm()});
  for (const physics::Contact& contact : scene.contacts) reach = std::max(reach, contact.point.norm() + contact.radius);
  return reach;
}

/// Of a value in a record, where the scene's own start has this one.
std::string place_in_record(std::size_t index, const std::string& place) {
  const std::string key = place.substr(place.find('.') + 1);
  const bool recorded = key == "position" || key == "orientation" || key == "velocity" || key == "angular_velocity";
  return recorded ? fmt::format("steps[{}].{}", index, place) : place;
}

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
  std::error_code unknown;  // too long a name, say
  // What is there, or looks like a file, is one, and gets the sentence that says how scene files end.
  const std::string short_name = name.substr(0, name.find(':'));
  const auto& known = physics::built_in_scenes();
  if (std::ranges::any_of(known, [&](const auto& info) { return info.name == short_name; })) return false;
  return short_name.find('.') != std::string::npos || std::filesystem::exists(name, unknown);
}

SceneSource load_scene(const std::string& name) {
  if (is_scene_file(name)) return {physics::read_scene(name)};
  SceneSource source{{physics::built_in_scene(name), {}}};
  const std::string short_name = name.substr(0, name.find(':'));
  for (const auto& info : physics::built_in_scenes())
    if (info.name == short_name) source.duration = info.duration;
  return source;
}

DescriptionError about_scene(const std::string& name, const DescriptionError& error) {
  std::string where = name;
  std::error_code no_file;
  // The file is read again, which a pipe does not bear.
  if (!error.place().empty() && is_scene_file(name) && std::filesystem::is_regular_file(name, no_file)) {
    try {
      where += fmt::format(":{}", physics::line_in_scene(name, error.place()));
    } catch (const DescriptionError&) {  // it is another by now
    }
  }
  return DescriptionError(fmt::format("{}: {}", where, error.what()), error.place());
}

double tolerance_used(double asked, const physics::Mechanism& scene) {
  const double most = physics::loosest_tolerance(scene);
  if (asked <= most) return asked;
  fmt::print(stderr,
             "graphsolve: note: a tolerance of {} m/s would let things hover; |g| dt / 100 = {:.3g} m/s is taken instead\n",
             asked, most);
  return most;
}

void note_coarse_step(const physics::Mechanism& scene) {
  const double dt = scene.time_step, fall = scene.gravity.norm() * dt * dt, reach = largest_reach(scene);
  // Free flight is exact at any step.
  if (reach > 0 && fall > reach)
    fmt::print(stderr,
               "graphsolve: note: a time step of {} s is coarse here: |g| dt^2, what a body falls in it, is {:.3g} m, and no "
               "joint or contact is farther than {:.3g} m from its body's centre of mass\n",
               dt, fall, reach);
  const auto spin = [](const physics::Body& body) { return body.angular_velocity.norm(); };
  const auto fastest = std::ranges::max_element(scene.bodies, {}, spin);
  if (fastest == scene.bodies.end()) return;
  const double turns = std::asin(std::min(1.0, spin(*fastest) * dt / 2)) / std::numbers::pi;
  if (turns > most_turns)
    fmt::print(stderr,
               "graphsolve: note: a time step of {} s is coarse here: body '{}' starts at {:.2g} turns a step, and above {} "
               "energy is not kept well\n",
               dt, one_line(fastest->name), turns, most_turns);
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
    const auto index = static_cast<std::size_t>(found - steps.begin());
    throw about_scene(name, DescriptionError(fmt::format("record {}: {}", step, error.what()),
                                             place_in_record(index, error.place())));
  }
  return *found;
}

}  // namespace cli
