#include "io/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace physics::io {

namespace {

bool find(const Json& at, const Json& node, std::vector<PathStep>& path) {
  if (&at == &node) return true;
  if (!at.is_structured()) return false;
  std::size_t index = 0;
  for (const auto& item : at.items()) {
    path.push_back({at.is_object() ? item.key() : std::string(), index++});
    if (find(item.value(), node, path)) return true;
    path.pop_back();
  }
  return false;
}

}  // namespace

std::vector<PathStep> path_to(const Json& root, const Json& node) {
  std::vector<PathStep> path;
  find(root, node, path);
  return path;
}

std::string text(const std::vector<PathStep>& path) {
  std::string result;
  for (const PathStep& step : path) {
    if (step.key.empty()) {
      result += fmt::format("[{}]", step.index);
    } else {
      result += (result.empty() ? "" : ".") + step.key;
    }
  }
  return result;
}

const Json& node_at(const Json& root, std::string_view path) {
  const Json* at = &root;
  while (!path.empty()) {
    const std::size_t end = std::min(path.find_first_of(".[", 1), path.size());
    const std::string_view step = path.substr(0, end);
    path.remove_prefix(end);
    if (step[0] == '[') {
      std::size_t index = 0;
      std::from_chars(step.data() + 1, step.data() + step.size(), index);
      if (!at->is_array() || index >= at->size()) break;
      at = &(*at)[index];
    } else {
      const auto found = at->find(step.substr(step[0] == '.' ? 1 : 0));  // of no object: not found
      if (found == at->end()) break;
      at = &*found;
    }
  }
  return *at;
}

}  // namespace physics::io
