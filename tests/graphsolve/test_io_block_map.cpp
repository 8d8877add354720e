#include <gtest/gtest.h>

#include "graphsolve/io/block_map.hpp"
#include "graphsolve/io/json_lines.hpp"
#include "support/graph_families.hpp"

namespace test_io_block_map {

using namespace graphsolve;
using namespace graphsolve::io;

std::string error_of(const std::string& text) {
  try {
    (void)parse_block_map(text, "map.json");
  } catch (const FileError& error) {
    return error.what();
  }
  return "accepted";
}

std::string blocks(const std::string& list) {
  return R"({"format": "graphsolve-blocks", "version": 1, "blocks": )" + list + "}";
}

SparseMatrix sparse(const Eigen::MatrixXd& dense) {
  std::vector<Triplet> t;
  for (int j = 0; j < dense.cols(); ++j)
    for (int i = 0; i < dense.rows(); ++i)
      if (dense(i, j) != 0) t.push_back({i, j, dense(i, j)});
  return from_triplets(static_cast<int>(dense.rows()), static_cast<int>(dense.cols()), t);
}

TEST(BlockMapFile, AListOfSizesIsEnough) {
  for (const char* text : {"[3, 1, 2]", "3 1 2\n", "3,1,\n2", " 3\r\n1\r\n2\r\n"}) {
    const BlockMap map = parse_block_map(text);
    ASSERT_EQ(map.blocks.size(), 3u) << text;
    EXPECT_EQ(map.blocks[0].rows, (std::vector<int>{0, 1, 2}));
    EXPECT_EQ(map.blocks[2].rows, (std::vector<int>{4, 5}));
    EXPECT_EQ(map.blocks[2].name, "rows 5-6");
    EXPECT_FALSE(map.blocks[0].kind.has_value());
  }
}

TEST(BlockMapFile, NamesKindsRowsAndRanksAreRead) {
  const BlockMap map = parse_block_map(R"({"format": "graphsolve-blocks", "version": 1,
    "blocks": [{"name": "x", "dimension": 2, "kind": "regular"}, {"name": "c", "rows": [5, 3], "kind": "saddle"}, 1],
    "edges": [{"from": "c", "to": "x", "rank": "full_row"}]})");
  ASSERT_EQ(map.blocks.size(), 3u);
  EXPECT_EQ(map.blocks[1].rows, (std::vector<int>{4, 2}));
  EXPECT_EQ(map.blocks[1].kind, NodeKind::saddle);
  EXPECT_EQ(map.blocks[2].rows, std::vector<int>{3});  // follows the row after the last one listed
  ASSERT_EQ(map.couplings.size(), 1u);
  EXPECT_EQ(map.couplings[0].a, 1);
  EXPECT_EQ(map.couplings[0].b, 0);
  EXPECT_EQ(map.couplings[0].rank, EdgeRank::full_row);
}

TEST(BlockMapFile, WhatDetectionFoundComesBackAsTheSameGraph) {
  const SparseMatrix matrix = sparse(families::saddle_matrix(families::ladder(8), 2));
  const BlockStructure found = detect_blocks(matrix);
  const std::string text = block_map_json(block_map(found));
  const BlockMap map = parse_block_map(text);
  const BlockStructure back = make_blocks(matrix, map.blocks, map.couplings);
  EXPECT_EQ(back.row_of, found.row_of);
  ASSERT_EQ(back.graph.size(), found.graph.size());
  for (int v = 0; v < found.graph.size(); ++v) {
    EXPECT_EQ(back.graph.name({v}), found.graph.name({v}));
    EXPECT_EQ(back.graph.kind({v}), found.graph.kind({v}));
    ASSERT_EQ(back.graph.edges({v}).size(), found.graph.edges({v}).size());
    for (std::size_t e = 0; e < found.graph.edges({v}).size(); ++e)
      EXPECT_EQ(back.graph.edges({v})[e].rank, found.graph.edges({v})[e].rank);
  }
  EXPECT_EQ(block_map_json(map), text);
}

TEST(BlockMapFile, EveryMistakeIsNamedWithItsPlace) {
  EXPECT_EQ(error_of(" \n"), "map.json: the file is empty");
  EXPECT_EQ(error_of("3 x"), "map.json: this is neither JSON nor a list of block sizes");
  EXPECT_EQ(error_of("{\n\"a\": 1,,\n}"), "map.json:2: this is no JSON: syntax error");
  EXPECT_EQ(error_of("[]"), "map.json: there are no blocks");
  EXPECT_EQ(error_of("[3, 0]"), "map.json:1: [1]: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of("[3, 1.5]"), "map.json:1: [1]: 1.5 is no whole number from 1 on");
  EXPECT_EQ(error_of("[2000000000]"), "map.json:1: [0]: 2000000000 rows are more than a block may have (16384)");
  EXPECT_EQ(error_of("9999999999"), "map.json:1: [0]: 9999999999 is more than the 2147483647 supported");
  EXPECT_EQ(error_of("[18446744073709551615]"), "map.json:1: [0]: 18446744073709551615 is more than the 2147483647 supported");
  EXPECT_EQ(error_of("[99999999999999999999]"), "map.json:1: [0]: 1e+20 is more than the 2147483647 supported");
  EXPECT_EQ(error_of("[-9999999999]"), "map.json:1: [0]: -9999999999 is no whole number from 1 on");
  EXPECT_EQ(error_of("{}"), "map.json: the key 'format' must be 'graphsolve-blocks'");
  EXPECT_EQ(error_of(R"({"format": "graphsolve-blocks", "version": 2, "blocks": [1]})"),
            "map.json: the key 'version' must be 1");
  EXPECT_EQ(error_of(R"({"format": "graphsolve-blocks", "version": 1})"), "map.json: the key 'blocks' is missing");
  EXPECT_EQ(error_of(blocks("3")), "map.json:1: blocks: 3 is no list");
  EXPECT_EQ(error_of(blocks("[\"x\"]")), "map.json:1: blocks[0]: 'x' is no object");
  EXPECT_EQ(error_of(blocks(R"([{"name": "a"}])")),
            "map.json:1: blocks[0]: needs either 'dimension' (the next rows) or 'rows' (a list)");
  EXPECT_EQ(error_of(blocks(R"([{"dimension": 1, "size": 2}])")), "map.json:1: blocks[0]: unknown key 'size'");
  EXPECT_EQ(error_of(blocks(R"([{"dimension": 1, "kind": "sadle"}])")),
            "map.json:1: blocks[0].kind: 'sadle' is no kind; there are: regular, semidefinite, saddle, shared");
  EXPECT_EQ(error_of(blocks(R"([{"rows": [1, 0]}])")), "map.json:1: blocks[0].rows[1]: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of(blocks(R"([{"rows": []}])")), "map.json:1: blocks[0].rows: a block has at least one row");
  EXPECT_EQ(error_of(blocks(R"([{"dimension": 1, "name": ""}])")), "map.json:1: blocks[0].name: '' is no name");
  EXPECT_EQ(error_of(blocks(R"([{"dimension": 1, "name": "a"}, {"dimension": 1, "name": "a"}])")),
            "map.json:1: blocks[1]: the name 'a' is taken by blocks[0]");
  EXPECT_EQ(error_of(blocks(R"([1], "edges": [{"from": "row 1", "to": "b"}])")),
            "map.json:1: edges[0].to: there is no block 'b'");
  EXPECT_EQ(error_of(blocks(R"([1, 1], "edges": [{"from": "row 1", "to": "row 2", "rank": "high"}])")),
            "map.json:1: edges[0].rank: 'high' is no rank; there are: unknown, full_row, full_column, full");
}

TEST(BlockMapFile, DeepNestingIsAMistakeLikeOthers) {
  const std::string deep = std::string(300'000, '[') + std::string(300'000, ']');
  EXPECT_EQ(error_of(deep), "map.json:1: [0]: a list of 1 is no object");
  EXPECT_EQ(error_of(blocks(deep)), "map.json:1: blocks[0]: a list of 1 is no object");
  EXPECT_EQ(error_of(R"({"format": "graphsolve-blocks", "version": 1, "edges": )" + deep + ",\n\"blocks\": [0]}"),
            "map.json:2: blocks[0]: 0 is no whole number from 1 on");
}

TEST(BlockMapFile, MistakesAreNamedWithTheirLine) {
  const std::string head = "{\n \"format\": \"graphsolve-blocks\",\n \"version\": 1,\n \"blocks\": [\n";
  EXPECT_EQ(error_of(head + "  {\"name\": \"a]\\\"}\", \"dimension\": 2},\n  3,\n\n  {\"rows\": [7,\n 8, 0]}\n ]\n}"),
            "map.json:9: blocks[2].rows[2]: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of(head + "  1, 1\n ],\n \"edges\": [\n  {\"from\": \"row 1\",\n   \"to\": \"row 2\",\n" +
                     "   \"rank\": \"high\"}]}"),
            "map.json:10: edges[0].rank: 'high' is no rank; there are: unknown, full_row, full_column, full");
  EXPECT_EQ(error_of(head + "  1,\n  {\"dimension\": 1,\n   \"kind\": \"sadle\"}]}").substr(0, 30),
            "map.json:7: blocks[1].kind: 's");
  EXPECT_EQ(error_of("3\n4, 5\n\n0 1"), "map.json:4: [3]: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of("\n[3,\n 4,\n 0]"), "map.json:4: [2]: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of("\r\n\r\n3\r\n ,0"), "map.json:4: [1]: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of(head + "  {\"dimension\"\n:\n0\n}]}"),
            "map.json:7: blocks[0].dimension: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of(head + "  1,\n  {\"dimensi\\u006fn\":\n   0}]}"),
            "map.json:7: blocks[1].dimension: 0 is no whole number from 1 on");
  EXPECT_EQ(error_of(head + "  {\"dimension\":\n   1,\n   \"dimension\": 0}]}"),
            "map.json:7: the key 'dimension' is given twice in one object");
}

TEST(BlockMapFile, AKeyGivenTwiceIsRefusedWithItsLine) {
  EXPECT_EQ(error_of(blocks("[{\"dimension\": 1, \"name\": \"a\",\n \"n\\u0061me\": \"b\"}]")),
            "map.json:2: the key 'name' is given twice in one object");
  EXPECT_EQ(error_of("{\"format\": \"graphsolve-blocks\", \"version\": 1, \"blocks\": [1],\n\"blocks\": [1]}"),
            "map.json:2: the key 'blocks' is given twice in one object");
  EXPECT_EQ(error_of(blocks(R"([1, 1], "edges": [{"from": "row 1", "to": "row 2", "rank": "full", "rank": "unknown"}])")),
            "map.json:1: the key 'rank' is given twice in one object");
  EXPECT_EQ(error_of(blocks(R"([{"name": "a", "dimension": 1}, {"name": "b", "dimension": 1}])")), "accepted");
}

TEST(BlockMapFile, NamesThatAreNotUtf8AreRefusedBeforeAnythingIsWritten) {
  BlockMap map = parse_block_map("1 1");
  map.blocks[1].name = "Tr\xe4ger";
  try {
    (void)block_map_json(map);
    FAIL() << "written";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "the name of block 1, 'Tr\xef\xbf\xbdger', is not UTF-8, which JSON must be; give it another one");
  }
  map.blocks[1].name = "Tr\xc3\xa4ger \"\n";
  EXPECT_EQ(parse_block_map(block_map_json(map)).blocks[1].name, map.blocks[1].name);
}

TEST(LineOfJson, TheLastValueOnTheWayCounts) {
  const std::string_view text = "\n{\n\"a.b\": 1,\n\"a\": [3,\n [4],\n {\"b\": {}}],\n\"b\": {\"b\":\n 5}\n}";
  const auto line = [&](std::vector<PathStep> path) { return line_of(text, path); };
  EXPECT_EQ(line({}), 2);
  EXPECT_EQ(line({{"a.b"}}), 3);
  EXPECT_EQ(line({{"", 1}, {"", 1}, {"", 0}}), 5);
  EXPECT_EQ(line({{"a"}, {"", 2}, {"b"}}), 6);
  EXPECT_EQ(line({{"b"}, {"b"}}), 8);
  EXPECT_EQ(line({{"c"}}), 2);
  EXPECT_EQ(line({{"a"}, {"", 3}}), 4);
  EXPECT_EQ(line({{"a"}, {"", 2}, {"c"}}), 6);
  EXPECT_EQ(line({{"a.b"}, {"", 0}}), 3);         // a number holds nothing: not what the list after it holds
  EXPECT_EQ(line({{"a"}, {"", 1}, {"", 1}}), 5);  // nor does a list that is over
}

}  // namespace test_io_block_map
