#include <fmt/format.h>

#include <algorithm>

#include "io/document.hpp"
#include "physics/mechanism.hpp"

namespace physics::io {

namespace {

/// Receives the parser's events, in the shape that nlohmann::json prescribes. It builds the tree like the
/// library's own receiver, but refuses a key given twice, which the library lets pass.
class Builder {
 public:
  Builder(const graphsolve::io::LinePosition& position, std::string_view text, std::string_view file)
      : position_(position), text_(text), file_(file) {}

  bool null() { return leaf(nullptr); }
  bool boolean(bool value) { return leaf(value); }
  bool number_integer(Json::number_integer_t value) { return leaf(value); }
  bool number_unsigned(Json::number_unsigned_t value) { return leaf(value); }
  bool number_float(Json::number_float_t value, const std::string&) { return leaf(value); }
  bool string(std::string& value) { return leaf(std::move(value)); }
  bool binary(Json::binary_t&) { return false; }
  bool start_object(std::size_t) { return open(Json::object()); }
  bool start_array(std::size_t) { return open(Json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    if (open_.back()->contains(name))
      throw DescriptionError(fmt::format("{}:{}: key '{}' is given twice", file_, position_.line, name));
    key_ = std::move(name);
    return true;
  }
  bool parse_error(std::size_t read, const std::string&, const Json::exception& error) {
    // The parser has read the character it stumbled over.
    const std::string_view before = text_.substr(0, std::max<std::size_t>(read, 1) - 1);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t column = before.size() - (before.rfind('\n') + 1) + 1;  // rfind: npos + 1 is 0
    throw DescriptionError(fmt::format("{}:{}:{}: {}", file_, line, column, sentence(error.what())));
  }

  Json root;

 private:
  /// "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error ..." without the front.
  static std::string_view sentence(std::string_view what) {
    if (const auto bracket = what.find("] "); bracket != what.npos) what.remove_prefix(bracket + 2);
    if (const auto colon = what.find(": "); what.starts_with("parse error at") && colon != what.npos)
      what.remove_prefix(colon + 2);
    return what;
  }
  Json* add(Json value) {
    if (open_.empty()) {
      root = std::move(value);
      return &root;
    }
    Json& parent = *open_.back();
    if (parent.is_object()) return &(parent[key_] = std::move(value));
    parent.push_back(std::move(value));
    return &parent.back();
  }
  bool leaf(Json value) {
    add(std::move(value));
    return true;
  }
  bool open(Json value) {
    if (open_.size() == deepest)
      throw DescriptionError(fmt::format("{}:{}: nested deeper than {} levels", file_, position_.line, deepest));
    open_.push_back(add(std::move(value)));
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  const graphsolve::io::LinePosition& position_;
  std::string_view text_, file_;
  std::vector<Json*> open_;  ///< stays valid: a parent does not grow while a child is open
  std::string key_;
};

}  // namespace

Document parse_json(std::string_view text, std::string_view file) {
  graphsolve::io::LinePosition position;
  Builder builder(position, text, file);
  const graphsolve::io::LineCounter first(text.data(), &position), last(text.data() + text.size(), &position);
  Json::sax_parse(first, last, &builder);
  const auto line_of = [text](const Json& root, const Json& node) {
    return graphsolve::io::line_of(text, path_to(root, node));
  };
  return {std::move(builder.root), line_of};
}

}  // namespace physics::io
