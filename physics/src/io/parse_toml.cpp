#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <memory>
#include <sstream>

#include "io/document.hpp"
#include "physics/mechanism.hpp"

namespace physics::io {

namespace {

[[noreturn]] void fail_depth(std::string_view file, std::int64_t line) {
  throw DescriptionError(fmt::format("{}:{}: nested deeper than {} levels", file, line, deepest));
}

/// The place behind the string that begins at `at`.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? R"(""")" : "'''";
  const bool lines = text.substr(at).starts_with(three);
  const std::string_view end = three.substr(0, lines ? 3 : 1);
  for (at += end.size(); at < text.size(); ++at) {
    if (text.substr(at).starts_with(end)) return at + end.size();
    if (!lines && text[at] == '\n') return at;  // the parser will refuse it
    if (quote == '"' && text[at] == '\\') ++at;
  }
  return text.size();
}

/// The library recurses into what it has read, and no part of it bounds a key such as a.a.a = 1: dots and brackets are
/// counted before it reads.
void check_depth(std::string_view text, std::string_view file) {
  std::vector<std::size_t> open;  // levels down to the brackets that have begun and not ended
  std::size_t level = 0;
  const auto to_bracket = [&] { level = open.empty() ? 0 : open.back(); };
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = end_of_string(text, at);
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '.') ++level;
    if (c == '[' || c == '{') open.push_back(++level);
    if ((c == ']' || c == '}') && !open.empty()) open.pop_back();
    if (c == ']' || c == '}' || c == ',' || c == '\n') to_bracket();
    if (level > deepest)
      fail_depth(file, 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
    ++at;
  }
}

/// level: of lists and tables, the node among them.
Json convert(const toml::node& node, std::string_view file, std::size_t level = 1) {
  if (level > deepest && (node.is_table() || node.is_array()))
    fail_depth(file, std::max<std::int64_t>(1, node.source().begin.line));
  if (const auto* table = node.as_table()) {
    Json object = Json::object();
    for (const auto& [key, value] : *table) object[std::string(key.str())] = convert(value, file, level + 1);
    return object;
  }
  if (const auto* array = node.as_array()) {
    Json list = Json::array();
    for (const toml::node& value : *array) list.push_back(convert(value, file, level + 1));
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
  check_depth(text, file);
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
  return {convert(*table, file), line_of};
}

}  // namespace physics::io
