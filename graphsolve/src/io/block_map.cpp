#include "graphsolve/io/block_map.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "graph/block_pattern.hpp"
#include "graphsolve/io/json_lines.hpp"
#include "graphsolve/io/text_file.hpp"
#include "io/shown.hpp"

namespace graphsolve::io {

namespace {

using Json = nlohmann::ordered_json;

template <class T>
struct Word {
  std::string_view text;
  T value;
};
constexpr std::array kinds{Word{"regular", NodeKind::regular}, Word{"semidefinite", NodeKind::semidefinite},
                           Word{"saddle", NodeKind::saddle}, Word{"shared", NodeKind::shared}};
constexpr std::array ranks{Word{"unknown", EdgeRank::unknown}, Word{"full_row", EdgeRank::full_row},
                           Word{"full_column", EdgeRank::full_column}, Word{"full", EdgeRank::full}};

/// "blocks[2].kind" as steps: no key of a block map holds a dot or a bracket.
std::vector<PathStep> steps(std::string_view path) {
  constexpr std::string_view marks = ".[]";
  std::vector<PathStep> steps;
  for (std::size_t at = 0; (at = path.find_first_not_of(marks, at)) != path.npos;) {
    const std::string word(path.substr(at, path.find_first_of(marks, at) - at));
    if (at > 0 && path[at - 1] == '[') steps.push_back({"", std::stoul(word)});
    else steps.push_back({word});
    at += word.size();
  }
  return steps;
}

/// Reads with the path of what is read, for errors.
class Reader {
 public:
  Reader(std::string_view file, std::string_view text) : file_(file), text_(text) {}

  [[noreturn]] void fail(const std::string& where, const std::string& what) const {
    if (where.empty()) throw FileError(file_, what);
    throw FileError(file_, line_of(text_, steps(where)), where + ": " + what);
  }

  static std::string show(const Json& value) {
    if (value.is_array()) return "a list of " + std::to_string(value.size());
    if (value.is_object()) return "an object";  // neither is written out: they may be nested deeper than the stack is
    const std::string text = value.is_string() ? "'" + value.get<std::string>() + "'" : value.dump();
    return text.size() > 60 ? text.substr(0, 60) + "..." : text;
  }

  int integer(const Json& value, const std::string& where, int least) const {
    constexpr int most = std::numeric_limits<int>::max();
    const double number = value.is_number() ? value.get<double>() : 0;
    // Integers beyond 64 bits are read as reals.
    if (number > most && (value.is_number_integer() || number >= 0x1p64))
      fail(where, show(value) + " is more than the " + std::to_string(most) + " supported");
    if (value.is_number_integer() && number >= least) return value.get<int>();
    fail(where, show(value) + " is no whole number from " + std::to_string(least) + " on");
  }

  template <class T, std::size_t N>
  T word(const Json& value, const std::string& where, const std::array<Word<T>, N>& words, const char* thing) const {
    std::string known;
    for (const auto& w : words) {
      if (value.is_string() && value.get_ref<const std::string&>() == w.text) return w.value;
      known += (known.empty() ? "" : ", ") + std::string(w.text);
    }
    fail(where, show(value) + " is no " + thing + "; there are: " + known);
  }

  void only(const Json& object, const std::string& where, std::initializer_list<std::string_view> keys) const {
    for (const auto& [key, value] : object.items())
      if (std::ranges::find(keys, std::string_view(key)) == keys.end())
        fail(where, "unknown key '" + key + "'");
  }

  const Json& array(const Json& value, const std::string& where) const {
    if (!value.is_array()) fail(where, show(value) + " is no list");
    return value;
  }
  const Json& object(const Json& value, const std::string& where) const {
    if (!value.is_object()) fail(where, show(value) + " is no object");
    return value;
  }

 private:
  std::string_view file_, text_;
};

std::string index(const std::string& list, std::size_t i) { return list + "[" + std::to_string(i) + "]"; }

/// A slip of the pen must not eat the memory before the graph is made.
constexpr int largest_block = BlockGraph::largest_dimension;

void append_rows(const Reader& reader, const Json& json, const std::string& where, int& next, std::vector<int>& rows) {
  const int size = reader.integer(json, where, 1);
  if (size > largest_block)
    reader.fail(where, std::to_string(size) + " rows are more than a block may have (" + std::to_string(largest_block) +
                           ")");
  if (size > std::numeric_limits<int>::max() - next) reader.fail(where, "the rows exceed 2147483647");
  for (int i = 0; i < size; ++i) rows.push_back(next++);
}

/// `next` is the row after the block before.
Block read_block(const Reader& reader, const Json& json, const std::string& where, int& next) {
  Block block;
  if (json.is_number()) {
    append_rows(reader, json, where, next, block.rows);
    block.name = name_of_rows(block.rows);
    return block;
  }
  reader.object(json, where);
  reader.only(json, where, {"name", "dimension", "rows", "kind"});
  if (json.contains("dimension") == json.contains("rows"))
    reader.fail(where, "needs either 'dimension' (the next rows) or 'rows' (a list)");
  if (json.contains("dimension")) {
    append_rows(reader, json["dimension"], where + ".dimension", next, block.rows);
  } else {
    const Json& rows = reader.array(json["rows"], where + ".rows");
    for (std::size_t i = 0; i < rows.size(); ++i)
      block.rows.push_back(reader.integer(rows[i], index(where + ".rows", i), 1) - 1);
    if (rows.empty()) reader.fail(where + ".rows", "a block has at least one row");
    next = block.rows.back() + 1;
  }
  if (json.contains("kind")) block.kind = reader.word(json["kind"], where + ".kind", kinds, "kind");
  block.name = name_of_rows(block.rows);
  if (!json.contains("name")) return block;
  if (!json["name"].is_string() || json["name"].get_ref<const std::string&>().empty())
    reader.fail(where + ".name", Reader::show(json["name"]) + " is no name");
  block.name = json["name"];
  return block;
}

using Names = std::unordered_map<std::string, int>;

Names index_names(const Reader& reader, const std::vector<Block>& blocks) {
  Names names;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const auto [known, fresh] = names.emplace(blocks[b].name, static_cast<int>(b));
    if (!fresh)
      reader.fail(index("blocks", b), "the name '" + blocks[b].name + "' is taken by " + index("blocks", known->second));
  }
  return names;
}

BlockCoupling read_coupling(const Reader& reader, const Json& json, const std::string& where, const Names& names) {
  reader.object(json, where);
  reader.only(json, where, {"from", "to", "rank"});
  const auto end = [&](const char* key) {
    if (!json.contains(key)) reader.fail(where, std::string("needs '") + key + "', the name of a block");
    const auto known = json[key].is_string() ? names.find(json[key].get<std::string>()) : names.end();
    if (known == names.end()) reader.fail(where + "." + key, "there is no block " + Reader::show(json[key]));
    return known->second;
  };
  BlockCoupling coupling{end("from"), end("to"), EdgeRank::unknown};
  if (coupling.a == coupling.b) reader.fail(where, "a block is not coupled with itself");
  if (json.contains("rank")) coupling.rank = reader.word(json["rank"], where + ".rank", ranks, "rank");
  return coupling;
}

BlockMap read_sizes(const Reader& reader, const Json& list, const std::string& where) {
  BlockMap map;
  int next = 0;
  for (std::size_t i = 0; i < list.size(); ++i) map.blocks.push_back(read_block(reader, list[i], index(where, i), next));
  if (map.blocks.empty()) reader.fail(where, "there are no blocks");
  return map;
}

BlockMap read_object(const Reader& reader, const Json& json) {
  reader.only(json, "", {"format", "version", "blocks", "edges"});
  if (!json.contains("format") || json["format"] != "graphsolve-blocks")
    reader.fail("", "the key 'format' must be 'graphsolve-blocks'");
  if (!json.contains("version") || json["version"] != 1) reader.fail("", "the key 'version' must be 1");
  if (!json.contains("blocks")) reader.fail("", "the key 'blocks' is missing");
  BlockMap map = read_sizes(reader, reader.array(json["blocks"], "blocks"), "blocks");
  const Names names = index_names(reader, map.blocks);
  if (!json.contains("edges")) return map;
  const Json& edges = reader.array(json["edges"], "edges");
  for (std::size_t i = 0; i < edges.size(); ++i)
    map.couplings.push_back(read_coupling(reader, edges[i], index("edges", i), names));
  return map;
}

/// "3 4 2" or "3, 4,\n2" as a JSON list, line by line.
std::string as_list(std::string_view text) {
  std::string list = "[";
  std::string_view separator;
  bool open = false;  // inside a word
  for (const char c : text) {
    const bool blank = c == ',' || c == ' ' || c == '\n' || c == '\t' || c == '\r';
    if (!blank && !open) list += std::exchange(separator, ",");
    if (!blank || c == '\n') list += c;
    open = !blank;
  }
  return list + "]";
}

bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

}  // namespace

BlockMap parse_block_map(std::string_view text, std::string_view name) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) throw FileError(name, "the file is empty");
  const bool json = text[first] == '{' || text[first] == '[';
  const std::string list = json ? "" : as_list(text);
  const Reader reader(name, json ? text : list);
  try {
    const Json value = Json::parse(json ? text : list);
    if (const auto again = repeated_key(json ? text : list))
      throw FileError(name, again->line, "the key '" + again->key + "' is given twice in one object");
    return value.is_array() ? read_sizes(reader, value, "") : read_object(reader, value);
  } catch (const nlohmann::json::parse_error& error) {
    if (!json) reader.fail("", "this is neither JSON nor a list of block sizes");
    const std::string_view before = text.substr(0, std::min(error.byte, text.size()));
    throw FileError(name, 1 + std::ranges::count(before, '\n'), "this is no JSON: syntax error");
  } catch (const nlohmann::json::out_of_range&) {
    throw FileError(name, 1, "a number is too large");
  }
}

BlockMap read_block_map(const std::string& path) { return parse_block_map(read_text(path), path); }

BlockMap block_map(const BlockStructure& structure) {
  const BlockGraph& graph = structure.graph;
  BlockMap map;
  std::vector<int> matrix_row(structure.row_of.size());
  for (std::size_t i = 0; i < matrix_row.size(); ++i) matrix_row[structure.row_of[i]] = static_cast<int>(i);
  for (int v = 0; v < graph.size(); ++v) {
    const auto first = matrix_row.begin() + graph.row({v});
    map.blocks.push_back({std::string(graph.name({v})), {first, first + graph.dimension({v})}, graph.kind({v})});
    for (const auto& edge : graph.edges({v}))
      if (edge.to.index > v && edge.rank != EdgeRank::unknown) map.couplings.push_back({v, edge.to.index, edge.rank});
  }
  return map;
}

std::string block_map_json(const BlockMap& map) {
  const auto word = [](const auto& words, auto value) {
    return std::ranges::find_if(words, [&](const auto& w) { return w.value == value; })->text;
  };
  Json blocks = Json::array(), edges = Json::array();
  int next = 0;
  for (const Block& block : map.blocks) {
    if (!is_utf8(block.name))
      throw std::invalid_argument("the name of block " + std::to_string(&block - map.blocks.data()) + ", '" +
                                  shown(block.name) + "', is not UTF-8, which JSON must be; give it another one");
    Json json{{"name", block.name}};
    bool consecutive = true;
    for (const int row : block.rows) consecutive = consecutive && row == next++;
    if (consecutive) {
      json["dimension"] = block.rows.size();
    } else {
      json["rows"] = Json::array();
      for (const int row : block.rows) json["rows"].push_back(std::int64_t{row} + 1);
      next = block.rows.back() + 1;
    }
    if (block.kind) json["kind"] = word(kinds, *block.kind);
    blocks.push_back(json);
  }
  for (const BlockCoupling& c : map.couplings)
    edges.push_back({{"from", map.blocks[c.a].name}, {"to", map.blocks[c.b].name}, {"rank", word(ranks, c.rank)}});
  // One block per line: files that people read and edit.
  std::string text = "{\n \"format\": \"graphsolve-blocks\",\n \"version\": 1,\n";
  const auto list = [&](const char* key, const Json& items) {
    text += std::string(" \"") + key + "\": [";
    for (std::size_t i = 0; i < items.size(); ++i) text += (i ? ",\n  " : "\n  ") + items[i].dump();
    text += "]";
  };
  list("blocks", blocks);
  if (!edges.empty()) {
    text += ",\n";
    list("edges", edges);
  }
  return text + "\n}\n";
}

}  // namespace graphsolve::io
