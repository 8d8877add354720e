#include <fmt/format.h>

#include "graphsolve/io/text_file.hpp"
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

using Parser = io::Document (*)(std::string_view text, std::string_view file);

/// By the ending.
Parser parser_for(const std::string& path) {
  if (path.ends_with(".json")) return io::parse_json;
  if (path.ends_with(".toml")) return io::parse_toml;
  throw DescriptionError(fmt::format("cannot read '{}': a scene file ends in .json or .toml", path));
}

/// A file without a word is a slip, such as a redirection of what failed, and no syntax error in either spelling.
io::Document parse(std::string_view text, std::string_view file, Parser parser) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
    throw DescriptionError(
        fmt::format("{}: is empty; a scene has at least the keys format, version, time_step and bodies", file));
  return parser(text, file);
}

}  // namespace

Trajectory parse_scene_json(std::string_view text, std::string_view file_name) {
  return read_document(parse(text, file_name, io::parse_json), file_name);
}

Trajectory parse_scene_toml(std::string_view text, std::string_view file_name) {
  return read_document(parse(text, file_name, io::parse_toml), file_name);
}

Trajectory read_scene(const std::string& path) {
  const auto parser = parser_for(path);
  const std::string text = read_file(path);
  return read_document(parse(text, path, parser), path);
}

std::int64_t line_in_scene(const std::string& path, std::string_view place) {
  const auto parser = parser_for(path);
  const std::string text = read_file(path);
  const io::Document document = parse(text, path, parser);
  return document.line_of(document.root, io::node_at(document.root, place));
}

}  // namespace physics
