#include "graphsolve/io/json_lines.hpp"

#include <nlohmann/json.hpp>
#include <unordered_set>
#include <vector>

namespace graphsolve::io {

namespace {

/// Receives the parser's events, in the shape that nlohmann::json prescribes, and follows the path. False ends the
/// parse.
class LineFinder {
 public:
  LineFinder(const LinePosition& position, std::span<const PathStep> path) : position_(position), path_(path) {}

  bool null() { return value(); }
  bool boolean(bool) { return value(); }
  bool number_integer(nlohmann::json::number_integer_t) { return value(); }
  bool number_unsigned(nlohmann::json::number_unsigned_t) { return value(); }
  bool number_float(nlohmann::json::number_float_t, const std::string&) { return value(); }
  bool string(std::string&) { return value(); }
  bool binary(nlohmann::json::binary_t&) { return false; }
  bool start_object(std::size_t) { return open(); }
  bool start_array(std::size_t) { return open(); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    if (open_ == on_way_) key_ = name;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) { return false; }

  std::int64_t line = 1;

 private:
  /// False: this was the next one, and holds no other.
  bool value() { return !arrive(); }
  bool open() {
    const bool on_way = arrive();
    ++open_;
    return !on_way || on_way_ <= path_.size();
  }
  bool close() { return --open_ >= on_way_; }  // else what was to hold the next one is over
  /// Is the value that begins the next one on the way?
  bool arrive() {
    if (open_ != on_way_ || !is_next()) return false;
    line = position_.line;
    ++on_way_;
    index_ = 0;
    key_.clear();
    return true;
  }
  /// Of a value in the last list or object found; the root comes first.
  bool is_next() {
    if (on_way_ == 0) return true;
    const PathStep& step = path_[on_way_ - 1];
    const std::size_t index = index_++;
    return step.key.empty() ? index == step.index : key_ == step.key;
  }

  const LinePosition& position_;
  std::span<const PathStep> path_;
  std::size_t open_ = 0;    ///< lists and objects that have begun and not ended
  std::size_t on_way_ = 0;  ///< values found, the root among them
  std::size_t index_ = 0;   ///< of the next value in the last one found
  std::string key_;         ///< of it
};

/// Likewise; ends the parse at the first key that its object has already.
class RepetitionFinder {
 public:
  explicit RepetitionFinder(const LinePosition& position) : position_(position) {}

  bool null() { return true; }
  bool boolean(bool) { return true; }
  bool number_integer(nlohmann::json::number_integer_t) { return true; }
  bool number_unsigned(nlohmann::json::number_unsigned_t) { return true; }
  bool number_float(nlohmann::json::number_float_t, const std::string&) { return true; }
  bool string(std::string&) { return true; }
  bool binary(nlohmann::json::binary_t&) { return false; }
  bool start_object(std::size_t) {
    keys_.emplace_back();
    return true;
  }
  bool end_object() {
    keys_.pop_back();
    return true;
  }
  bool start_array(std::size_t) { return true; }
  bool end_array() { return true; }
  bool key(std::string& name) {
    if (keys_.back().insert(name).second) return true;
    found = RepeatedKey{name, position_.line};
    return false;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) { return false; }

  std::optional<RepeatedKey> found;

 private:
  const LinePosition& position_;
  std::vector<std::unordered_set<std::string>> keys_;  ///< of the objects that have begun and not ended
};

}  // namespace

std::int64_t line_of(std::string_view json, std::span<const PathStep> path) {
  LinePosition position;
  LineFinder finder(position, path);
  const LineCounter first(json.data(), &position), last(json.data() + json.size(), &position);
  nlohmann::json::sax_parse(first, last, &finder);
  return finder.line;
}

std::optional<RepeatedKey> repeated_key(std::string_view json) {
  LinePosition position;
  RepetitionFinder finder(position);
  const LineCounter first(json.data(), &position), last(json.data() + json.size(), &position);
  nlohmann::json::sax_parse(first, last, &finder);
  return finder.found;
}

}  // namespace graphsolve::io
