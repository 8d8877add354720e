#include "json_line.hpp"

#include <algorithm>

namespace graphsolve::io {

namespace {

constexpr std::string_view blanks = " \t\r\n,:";

/// Reads from value to value; what lies between them is skipped unseen, for somebody has parsed the text.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) { skip_blanks(); }

  [[nodiscard]] std::size_t at() const { return at_; }
  /// At the end of a list, an object or the text.
  [[nodiscard]] bool ended() const { return at_ >= text_.size() || text_[at_] == ']' || text_[at_] == '}'; }
  /// Into a list or object.
  bool enter() {
    if (at_ >= text_.size() || (text_[at_] != '[' && text_[at_] != '{')) return false;
    ++at_;
    skip_blanks();
    return true;
  }
  /// Over a key or value; what it was.
  std::string_view pass() {
    const std::size_t begin = at_;
    int depth = 0;
    do {
      const char c = text_[at_];
      if (c == '"') pass_string();
      else if (c == '[' || c == '{') ++depth, ++at_;
      else if (c == ']' || c == '}') --depth, ++at_;
      else at_ = depth > 0 ? at_ + 1 : std::min(text_.find_first_of(" \t\r\n,:]}", at_), text_.size());
    } while (depth > 0 && at_ < text_.size());
    const std::string_view passed = text_.substr(begin, at_ - begin);
    skip_blanks();
    return passed;
  }

 private:
  void skip_blanks() { at_ = std::min(text_.find_first_not_of(blanks, at_), text_.size()); }
  void pass_string() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_)
      if (text_[at_] == '\\') ++at_;
    at_ = std::min(at_ + 1, text_.size());
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

/// To entry `index` of the list where the scanner is.
bool go_to(Scanner& scanner, int index) {
  for (; index > 0 && !scanner.ended(); --index) scanner.pass();
  return !scanner.ended();
}

/// To the value of a key of the object where the scanner is.
bool go_to(Scanner& scanner, std::string_view key) {
  while (!scanner.ended()) {
    const std::string_view name = scanner.pass();
    if (name.size() == key.size() + 2 && name.substr(1, key.size()) == key) return true;
    scanner.pass();
  }
  return false;
}

}  // namespace

std::int64_t line_of(std::string_view text, std::string_view path) {
  Scanner scanner(text);
  std::size_t place = scanner.at();
  bool plain = !text.substr(place).starts_with('[') && !text.substr(place).starts_with('{');
  while (!path.empty()) {
    if (!plain && !scanner.enter()) break;
    plain = false;
    bool found = false;
    if (path.front() == '[') {
      int index = 0;
      for (path.remove_prefix(1); path.front() != ']'; path.remove_prefix(1)) index = 10 * index + (path.front() - '0');
      path.remove_prefix(1);
      found = go_to(scanner, index);
    } else {
      if (path.front() == '.') path.remove_prefix(1);
      const std::string_view key = path.substr(0, path.find_first_of(".["));
      path.remove_prefix(key.size());
      found = go_to(scanner, key);
    }
    if (!found) break;
    place = scanner.at();
  }
  return 1 + std::ranges::count(text.substr(0, place), '\n');
}

}  // namespace graphsolve::io
