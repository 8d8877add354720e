#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

/// Checks of option values that several commands share, with sentences of their own and nothing added to the help.
namespace cli {

inline CLI::Validator at_least_zero() {
  return {[](const std::string& text) { return text.starts_with('-') ? "must be >= 0, not " + text : std::string(); },
          ""};
}

inline CLI::Validator positive() {
  const auto check = [](const std::string& text) {
    double value = 0;
    const bool fine = CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value);
    return fine ? std::string() : "must be a number > 0, not " + text;
  };
  return {check, ""};
}

}  // namespace cli
