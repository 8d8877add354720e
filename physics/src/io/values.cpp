#include "io/values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics::io {

namespace {

std::string kind(const Json& json) {
  if (json.is_null()) return "null";
  if (json.is_boolean()) return "true or false";
  if (json.is_number()) return "a number";
  if (json.is_string()) return fmt::format("the text '{}'", json.get_ref<const std::string&>());
  if (json.is_array()) return fmt::format("a list of {}", json.size());
  return "an object";
}

[[noreturn]] void fail_kind(const Json& json, std::string_view expected) {
  throw ReadError{&json, fmt::format("is {}, expected {}", kind(json), expected)};
}

}  // namespace

double number(const Json& json) {
  if (!json.is_number()) fail_kind(json, "a number");
  const double value = json.get<double>();
  if (!std::isfinite(value)) throw ReadError{&json, fmt::format("is {}, expected a finite number", value)};
  return value;
}

int integer(const Json& json) {
  const double value = number(json);
  if (value != std::floor(value)) throw ReadError{&json, fmt::format("is {}, expected a whole number", value)};
  constexpr int most = std::numeric_limits<int>::max();
  if (std::abs(value) > most)
    throw ReadError{&json, fmt::format("is {:.0f}, expected a whole number from -{} to {}", value, most, most)};
  return static_cast<int>(value);
}

bool boolean(const Json& json) {
  if (!json.is_boolean()) fail_kind(json, "true or false");
  return json.get<bool>();
}

const std::string& string(const Json& json) {
  if (!json.is_string()) fail_kind(json, "text");
  return json.get_ref<const std::string&>();
}

const Json& list(const Json& json) {
  if (!json.is_array()) fail_kind(json, "a list");
  return json;
}

const Json& list(const Json& json, std::size_t size) {
  if (!json.is_array() || json.size() != size) fail_kind(json, fmt::format("a list of {}", size));
  return json;
}

Vec3 vec3(const Json& json) {
  list(json, 3);
  return {number(json[0]), number(json[1]), number(json[2])};
}

Quat quat(const Json& json) {
  list(json, 4);
  return {number(json[0]), number(json[1]), number(json[2]), number(json[3])};
}

std::vector<double> numbers(const Json& json) {
  std::vector<double> values;
  values.reserve(list(json).size());
  for (const Json& value : json) values.push_back(number(value));
  return values;
}

Object::Object(const Json& json) : json_(&json) {
  if (!json.is_object()) fail_kind(json, "an object");
}

const Json* Object::optional(const char* key) {
  asked_.push_back(key);
  const auto found = json_->find(key);
  return found == json_->end() ? nullptr : &*found;
}

const Json& Object::required(const char* key) {
  if (const Json* value = optional(key)) return *value;
  throw ReadError{json_, fmt::format("key '{}' is missing", key)};
}

Extras Object::finish() {
  Extras extras;
  for (const auto& item : json_->items()) {
    if (item.key().starts_with("x_")) {
      extras.emplace_back(item.key(), item.value().dump());
    } else if (std::find(asked_.begin(), asked_.end(), item.key()) == asked_.end()) {
      throw ReadError{&item.value(),
                      fmt::format("unknown key '{}' (known here: {})", item.key(), fmt::join(asked_, ", "))};
    }
  }
  return extras;
}

void fail_choice(const Json& json, const std::vector<std::string_view>& names) {
  throw ReadError{&json,
                  fmt::format("is '{}', expected {}", json.get_ref<const std::string&>(), fmt::join(names, ", "))};
}

}  // namespace physics::io
