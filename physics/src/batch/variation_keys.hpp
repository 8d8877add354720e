#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "physics/mechanism.hpp"

/// What the keys of variations are read with. Errors of a key, not of its value, begin with "vary 'KEY': ".
namespace physics {

template <class... Arguments>
[[noreturn]] void wrong_key(std::string_view key, fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  throw DescriptionError(fmt::format("vary '{}': {}", key, fmt::format(text, std::forward<Arguments>(arguments)...)));
}

/// Names the keys that there are.
[[noreturn]] void unknown_key(std::string_view key);

/// The thing of that name, or an error that names the key.
template <class Things>
auto& find(Things& things, std::string_view name, std::string_view key, const char* kind) {
  const auto found = std::find_if(things.begin(), things.end(), [&](const auto& thing) { return thing.name == name; });
  if (found == things.end()) wrong_key(key, "the scene has no {} '{}'", kind, name);
  return *found;
}

/// Takes ".ending" off a text that has it; the rest may contain dots.
inline bool take_ending(std::string_view& text, std::string_view ending) {
  if (!text.ends_with(ending) || text.size() <= ending.size()) return false;
  const std::size_t rest = text.size() - ending.size();
  if (text[rest - 1] != '.') return false;
  text = text.substr(0, rest - 1);
  return true;
}

/// Takes ".x", ".y" or ".z" off: 0, 1, 2. -1: there is none.
inline int take_axis(std::string_view& text) {
  for (const int axis : {0, 1, 2})
    if (take_ending(text, std::string_view("xyz").substr(axis, 1))) return axis;
  return -1;
}

/// Keys that begin with "start."
void set_start(Mechanism& mechanism, std::string_view key, double value);

}  // namespace physics
