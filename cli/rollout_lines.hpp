#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "rollout_file.hpp"

/// Lines of the files of rollouts: how they are read, and refused. Errors name file and line.
namespace cli {

using Json = nlohmann::ordered_json;

Json parse(const std::string& line, const std::string& where);

/// From 0 to the largest that fits.
template <class Value>
bool is_count(const Json& json) {
  if (json.is_number_unsigned()) return json.get<std::uint64_t>() <= std::uint64_t{std::numeric_limits<Value>::max()};
  return json.is_number_integer() && json.get<std::int64_t>() >= 0;
}

/// The value of a key that has to be there and of this type; whole numbers count something.
template <class Value>
Value get(const Json& json, const char* key, const std::string& where) {
  const auto found = json.find(key);
  bool fits = found != json.end();
  if constexpr (std::is_same_v<Value, std::string>) fits = fits && found->is_string();
  else if constexpr (std::is_same_v<Value, double>) fits = fits && found->is_number();
  else fits = fits && is_count<Value>(*found);
  if (!fits) throw physics::DescriptionError(fmt::format("{}: is not a line of a rollout (its key '{}')", where, key));
  return found->get<Value>();
}

/// What goes on with a file; a shard among others has another way out.
inline constexpr const char* go_on = "GRAPHSOLVE_SIMD={} goes on with it where the processor can, another file begins anew";

/// Two headers that should be equal. advice: where the instruction sets differ; {} is the one that was found.
void compare(const std::string& found, const std::string& wanted, const std::string& path, const char* advice = go_on);

/// Reads complete lines only; `size` is where the last of them ends.
struct Lines {
  explicit Lines(const std::string& path) : in(path, std::ios::binary) {}
  bool next(std::string& line) {
    if (!std::getline(in, line) || in.eof()) return false;
    size += line.size() + 1;
    return true;
  }
  std::ifstream in;
  std::uintmax_t size = 0;
};

/// Counts the records of a shard's file, which must be the copies in order. Returns the copy that is due.
long long read_records(Lines& lines, long long first, const std::string& path, Tally& tally);

}  // namespace cli
