#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "physics/scenes.hpp"

namespace physics::scenes {

/// Bounds of a parameter, inclusive.
struct Range {
  double low, high;
};

/// Visits the parameters of a scene: lists them with their defaults, or sets them from what was typed. One visit
/// function per scene serves both, so that a default is written once.
class Fields {
 public:
  /// Lists.
  explicit Fields(std::string scene) : scene_(std::move(scene)) {}
  /// Sets from "parameter=value,...".
  Fields(std::string scene, std::string_view typed);

  void number(const char* name, double& value, Range range, const char* meaning);
  void integer(const char* name, int& value, Range range, const char* meaning);

  /// A word out of `words`; the value is its index.
  template <class Enum>
  void choice(const char* name, Enum& value, const std::vector<std::string>& words, const char* meaning) {
    value = static_cast<Enum>(choose(name, static_cast<int>(value), words, meaning));
  }

  /// Throws DescriptionError when something was typed that no parameter took.
  void expect_all_taken() const;

  [[nodiscard]] const std::vector<SceneParameter>& listed() const { return listed_; }

 private:
  int choose(const char* name, int index, const std::vector<std::string>& words, const char* meaning);
  const std::string* take(const char* name);
  [[noreturn]] void bad_value(const char* name, const std::string& text, const std::string& valid) const;

  std::string scene_;
  std::map<std::string, std::string, std::less<>> typed_;
  std::vector<SceneParameter> listed_;
};

}  // namespace physics::scenes
