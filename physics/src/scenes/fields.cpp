#include "scenes/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace physics::scenes {

namespace {

/// The whole text as a number; false when it is not one.
template <class Number>
bool parse(const std::string& text, Number& value) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} && stop == end;
}

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

}  // namespace

Fields::Fields(std::string scene, std::string_view typed) : scene_(std::move(scene)) {
  while (!typed.empty()) {
    const std::size_t comma = std::min(typed.find(','), typed.size());
    const std::string_view item = typed.substr(0, comma);
    typed.remove_prefix(std::min(comma + 1, typed.size()));
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos || equals == 0)
      throw DescriptionError(fmt::format("scene '{}': '{}' is not of the form parameter=value", scene_, item));
    const auto [place, added] =
        typed_.try_emplace(std::string(item.substr(0, equals)), std::string(item.substr(equals + 1)));
    if (!added) throw DescriptionError(fmt::format("scene '{}': parameter '{}' is given twice", scene_, place->first));
  }
}

const std::string* Fields::take(const char* name) {
  const auto found = typed_.find(name);
  return found == typed_.end() ? nullptr : &found->second;
}

void Fields::bad_value(const char* name, const std::string& text, const std::string& valid) const {
  throw DescriptionError(fmt::format("scene '{}': parameter {} = '{}' is not {}", scene_, name, text, valid));
}

void Fields::number(const char* name, double& value, Range range, const char* meaning) {
  listed_.push_back({name, fmt::format("{}", value), fmt::format("{}, {} .. {}", meaning, range.low, range.high)});
  const std::string* text = take(name);
  if (!text) return;
  if (!parse(*text, value) || !(value >= range.low && value <= range.high))
    bad_value(name, *text, fmt::format("a number from {} to {}", range.low, range.high));
}

void Fields::integer(const char* name, int& value, Range range, const char* meaning) {
  listed_.push_back({name, fmt::format("{}", value), fmt::format("{}, {} .. {}", meaning, range.low, range.high)});
  const std::string* text = take(name);
  if (!text) return;
  if (!parse(*text, value) || value < range.low || value > range.high)
    bad_value(name, *text, fmt::format("an integer from {} to {}", range.low, range.high));
}

int Fields::choose(const char* name, int index, const std::vector<std::string>& words, const char* meaning) {
  listed_.push_back({name, words[index], fmt::format("{}: {}", meaning, joined(words))});
  const std::string* text = take(name);
  if (!text) return index;
  const auto found = std::find(words.begin(), words.end(), *text);
  if (found == words.end()) bad_value(name, *text, "one of " + joined(words));
  return static_cast<int>(found - words.begin());
}

void Fields::expect_all_taken() const {
  std::vector<std::string> valid;
  for (const SceneParameter& parameter : listed_) valid.push_back(parameter.name);
  for (const auto& [name, value] : typed_) {
    if (std::find(valid.begin(), valid.end(), name) == valid.end())
      throw DescriptionError(
          fmt::format("scene '{}' has no parameter '{}'; it has {}", scene_, name, joined(valid)));
  }
}

}  // namespace physics::scenes
