#pragma once

// For the readers of graphsolve and physics; outside the version promise (docs/architecture.md).

#include <cctype>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// Lines of what a JSON parser reads, for messages. For whoever reads JSON by nlohmann::json, which keeps no lines.
namespace graphsolve::io {

/// `line`, from 1, is that of the last character that was not space: a parser reads one character past a number.
struct LinePosition {
  std::int64_t line = 1, next_line = 1;
};

/// Feeds a parser and keeps `position` up to date on the way.
class LineCounter {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  LineCounter(const char* at, LinePosition* position) : at_(at), position_(position) {}
  reference operator*() const { return *at_; }
  LineCounter& operator++() {
    if (*at_ == '\n') ++position_->next_line;
    if (!std::isspace(static_cast<unsigned char>(*at_))) position_->line = position_->next_line;
    ++at_;
    return *this;
  }
  friend bool operator==(const LineCounter& a, const LineCounter& b) { return a.at_ == b.at_; }

 private:
  const char* at_;
  LinePosition* position_;
};

/// A step from a list or an object to what it holds.
struct PathStep {
  std::string key;  ///< empty: by index
  std::size_t index = 0;
};

/// Line, from 1, where the value at a path begins in a text that is valid JSON, nested as deep as it may be. The last
/// value on the way that is there counts, and of a key given twice the first.
std::int64_t line_of(std::string_view json, std::span<const PathStep> path);

struct RepeatedKey {
  std::string key;
  std::int64_t line = 1;  ///< of the second one
};
/// The first key that an object of a text holds twice, which nlohmann::json lets pass. The text is valid JSON.
std::optional<RepeatedKey> repeated_key(std::string_view json);

}  // namespace graphsolve::io
