#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <system_error>

/// Checks of option values that several commands share, with sentences of their own and nothing added to the help.
namespace cli {

inline CLI::Validator whole_number(long long least, long long most = std::numeric_limits<long long>::max()) {
  const auto check = [=](const std::string& text) {
    long long value = 0;
    if (!CLI::detail::lexical_cast(text, value) || value < least)
      return fmt::format("must be a whole number >= {}, not {}", least, text);
    return value <= most ? std::string() : fmt::format("must not be above {}", most);
  };
  return {check, ""};
}

inline CLI::Validator seed() {
  const auto check = [](const std::string& text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool fine = error == std::errc() && end == text.data() + text.size();
    return fine ? std::string()
                : fmt::format("must be a whole number from 0 to {}, not {}", std::numeric_limits<std::uint64_t>::max(), text);
  };
  return {check, ""};
}

/// An empty word is what a shell makes of a variable that is not set: nothing would be written. The next option is taken
/// where the name was forgotten: it would be written to, and be missing.
inline CLI::Validator file_name() {
  const auto check = [](const std::string& text) {
    if (text.empty()) return std::string("needs a file name");
    return text.starts_with('-') ? fmt::format("needs a file name, not {} (./{} is one)", text, text) : std::string();
  };
  return {check, ""};
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
