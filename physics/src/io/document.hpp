#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "graphsolve/io/json_lines.hpp"

/// A parsed file before its schema is looked at. TOML becomes the same kind of tree as JSON, so there is one reader.
namespace physics::io {

/// Keeps the order of the file.
using Json = nlohmann::ordered_json;

struct Document {
  Json root;
  /// Line of a node of `root` in the file, from 1. Only errors ask, so finding it may cost another parse.
  std::function<std::int64_t(const Json& root, const Json& node)> line_of;
};

/// Throw DescriptionError "file:line:column: ..." on wrong syntax or a key given twice. The text must outlive the
/// document.
Document parse_json(std::string_view text, std::string_view file);
Document parse_toml(std::string_view text, std::string_view file);

/// Levels of nesting in either spelling; what comes later recurses.
inline constexpr std::size_t deepest = 64;

using graphsolve::io::PathStep;
/// Way from the root to a node, found by the node's address.
std::vector<PathStep> path_to(const Json& root, const Json& node);
/// "bodies[2].mass"; empty for the root.
std::string text(const std::vector<PathStep>& path);
/// The node that such a text names, as far as the way goes; keys without dots and brackets.
const Json& node_at(const Json& root, std::string_view path);

}  // namespace physics::io
