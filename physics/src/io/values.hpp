#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/document.hpp"
#include "physics/mechanism.hpp"

/// Single values of a scene file, checked for their kind.
namespace physics::io {

/// Thrown while reading; the outermost function turns the node into a line and a key path.
struct ReadError {
  const Json* where;
  std::string message;
};

double number(const Json& json);  ///< finite
int integer(const Json& json);    ///< 4 or 4.0
bool boolean(const Json& json);
const std::string& string(const Json& json);
const Json& list(const Json& json);
const Json& list(const Json& json, std::size_t size);
Vec3 vec3(const Json& json);
Quat quat(const Json& json);  ///< [w, x, y, z]
std::vector<double> numbers(const Json& json);

/// An object whose keys are taken one by one. What is left over in the end is unknown, or an extra.
class Object {
 public:
  explicit Object(const Json& json);
  const Json& required(const char* key);
  const Json* optional(const char* key);
  /// The keys x_..., as JSON text. An error for any other key that was not asked for.
  Extras finish();
  [[nodiscard]] const Json& json() const { return *json_; }

 private:
  const Json* json_;
  std::vector<std::string_view> asked_;
};

/// One of a list of names, by position.
template <class Enum>
struct Choice {
  const char* name;
  Enum value;
};
[[noreturn]] void fail_choice(const Json& json, const std::vector<std::string_view>& names);

template <class Enum, std::size_t n>
Enum choice(const Json& json, const Choice<Enum> (&choices)[n]) {
  const std::string& name = string(json);
  std::vector<std::string_view> names;
  for (const auto& choice : choices) {
    if (name == choice.name) return choice.value;
    names.push_back(choice.name);
  }
  fail_choice(json, names);
}

}  // namespace physics::io
