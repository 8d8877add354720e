#include <fmt/format.h>

#include "graphsolve/io/matrix_market.hpp"
#include "io/read.hpp"
#include "physics/scene_io.hpp"

namespace physics {

namespace {

Trajectory read_document(const io::Document& document, std::string_view file) {
  try {
    Trajectory trajectory;
    io::Object object(document.root);
    io::read_mechanism(object, trajectory.mechanism);
    if (const io::Json* steps = object.optional("steps"))
      trajectory.steps = io::read_steps(*steps, trajectory.mechanism);
    if (const io::Json* failure = object.optional("failure"))
      trajectory.failure = io::read_failure(*failure, trajectory.steps);
    trajectory.mechanism.extras = object.finish();
    return trajectory;
  } catch (const io::ReadError& error) {
    const std::string path = io::text(io::path_to(document.root, *error.where));
    throw DescriptionError(fmt::format("{}:{}: {}{}{}", file, document.line_of(document.root, *error.where), path,
                                       path.empty() ? "" : ": ", error.message));
  }
}

std::string read_file(const std::string& path) {
  try {
    return graphsolve::io::read_text(path);
  } catch (const graphsolve::io::FileError& error) {
    throw DescriptionError(error.what());
  }
}

}  // namespace

Trajectory parse_scene_json(std::string_view text, std::string_view file_name) {
  return read_document(io::parse_json(text, file_name), file_name);
}

Trajectory parse_scene_toml(std::string_view text, std::string_view file_name) {
  return read_document(io::parse_toml(text, file_name), file_name);
}

Trajectory read_scene(const std::string& path) {
  const bool json = path.ends_with(".json");
  if (!json && !path.ends_with(".toml"))
    throw DescriptionError(fmt::format("cannot read '{}': a scene file ends in .json or .toml", path));
  const std::string text = read_file(path);
  return json ? parse_scene_json(text, path) : parse_scene_toml(text, path);
}

}  // namespace physics
