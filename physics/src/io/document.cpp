#include "io/document.hpp"

#include <fmt/format.h>

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

}  // namespace physics::io
