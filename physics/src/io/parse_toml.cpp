#include <fmt/format.h>
#include <toml++/toml.h>

#include <memory>
#include <sstream>

#include "io/document.hpp"
#include "physics/mechanism.hpp"

namespace physics::io {

namespace {

Json convert(const toml::node& node) {
  if (const auto* table = node.as_table()) {
    Json object = Json::object();
    for (const auto& [key, value] : *table) object[std::string(key.str())] = convert(value);
    return object;
  }
  if (const auto* array = node.as_array()) {
    Json list = Json::array();
    for (const toml::node& value : *array) list.push_back(convert(value));
    return list;
  }
  if (const auto* value = node.as_string()) return value->get();
  if (const auto* value = node.as_integer()) return value->get();
  if (const auto* value = node.as_floating_point()) return value->get();
  if (const auto* value = node.as_boolean()) return value->get();
  // Dates and times: nothing in a scene is one, and in a key x_ their text is as good as themselves.
  std::ostringstream out;
  if (const auto* date = node.as_date()) out << *date;
  if (const auto* time = node.as_time()) out << *time;
  if (const auto* both = node.as_date_time()) out << *both;
  return out.str();
}

}  // namespace

Document parse_toml(std::string_view text, std::string_view file) {
  std::shared_ptr<const toml::table> table;
  try {
    table = std::make_shared<toml::table>(toml::parse(text, file));
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    throw DescriptionError(fmt::format("{}:{}:{}: {}", file, at.line, at.column, error.description()));
  }
  const auto line_of = [table](const Json& root, const Json& node) {
    const toml::node* at = table.get();
    for (const PathStep& step : path_to(root, node)) {
      const toml::node* next = nullptr;
      if (const auto* inner = at->as_table()) next = inner->get(step.key);
      if (const auto* list = at->as_array()) next = list->get(step.index);
      if (!next) break;
      at = next;
    }
    return std::max<std::int64_t>(1, at->source().begin.line);
  };
  return {convert(*table), line_of};
}

}  // namespace physics::io
