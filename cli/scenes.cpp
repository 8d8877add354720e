#include "physics/scenes.hpp"

#include <fmt/format.h>

#include "commands.hpp"

namespace cli {

namespace {

int list_scenes() {
  for (const physics::SceneInfo& scene : physics::built_in_scenes()) {
    fmt::print("{}\n    {}\n", scene.name, scene.description);
    for (const auto& parameter : scene.parameters)
      fmt::print("      {:<20} {}\n", parameter.name + "=" + parameter.fallback, parameter.meaning);
  }
  fmt::print("\nParameters follow the name: graphsolve simulate snake:n=100,dt=0.005\n");
  return all_solved;
}

}  // namespace

Command add_scenes(CLI::App& program) {
  program.add_subcommand("scenes", "List the built-in scenes with their parameters and defaults.");
  return list_scenes;
}

}  // namespace cli
