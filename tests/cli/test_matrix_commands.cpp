#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "matrix_command.hpp"

namespace test_matrix_commands {

// `analyze`, and what both commands for matrices refuse, as a shell sees it.

using namespace matrix_command;

/// Tags that open are closed, in order, and attributes hold no raw angle brackets.
bool well_formed(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = xml.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos || std::count(tag.begin(), tag.end(), '"') % 2) return false;
    if (tag[0] == '?' || tag.back() == '/') continue;
    if (tag[0] != '/') open.push_back(tag.substr(0, tag.find(' ')));
    else if (open.empty() || open.back() != tag.substr(1)) return false;
    else open.pop_back();
  }
  return open.empty() && xml.find("</svg>") != std::string::npos;
}

int occurrences(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST_F(MatrixCommand, AnalyzeComparesAllOrderingsAndAChainHasNoFill) {
  write("chain.mtx", 30, line(30, Shape::chain));
  const Outcome outcome = run("analyze chain.mtx --json report.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* name : {"natural", "depth-first", "minimum-fill", "wide"})
    EXPECT_NE(outcome.out.find(name), std::string::npos) << name;
  const auto json = nlohmann::json::parse(text("report.json"));
  EXPECT_EQ(json["format"], "graphsolve-analysis");
  EXPECT_EQ(json["rows"], 30);
  EXPECT_EQ(json["blocks"], 30);
  ASSERT_GE(json["orderings"].size(), 4u);
  for (const auto& row : json["orderings"]) {
    if (row["ordering"] == "minimum-fill") {
      EXPECT_EQ(row["fill_blocks"], 0);
      EXPECT_EQ(row["fill_ratio"], 1.0);
    }
    EXPECT_EQ(row["stored_scalars"].get<int>() - row["matrix_scalars"].get<int>(), row["fill_scalars"]);
  }
}

TEST_F(MatrixCommand, AnalyzeDrawsTheRingWithItsFillAndTheTree) {
  write("ring.mtx", 12, line(12, Shape::ring));
  const Outcome outcome = run("analyze ring.mtx --ordering natural --svg ring.svg --dot ring.dot --json ring.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string svg = text("ring.svg"), graph = text("ring.dot"), tree = text("ring-tree.dot");
  EXPECT_TRUE(well_formed(svg));
  // 12 diagonal blocks, 12 links and 9 fill blocks, the last two in both triangles.
  EXPECT_EQ(occurrences(svg, "<title>"), 12 + 2 * (12 + 9));
  EXPECT_EQ(occurrences(svg, ", fill"), 2 * 9);
  EXPECT_NE(svg.find("100 % of it by 1 cycle"), std::string::npos);
  EXPECT_NE(outcome.out.find("1 cycle of 12 blocks"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("without the edge"), std::string::npos) << outcome.out;
  const auto fill = nlohmann::json::parse(text("ring.json"))["fill"];
  EXPECT_EQ(fill["fill_blocks"], 9);
  ASSERT_EQ(fill["causes"].size(), 1u);
  EXPECT_EQ(fill["causes"][0]["operations"], fill["operations"]);
  EXPECT_EQ(occurrences(graph, " -- "), 12);
  EXPECT_EQ(occurrences(tree, " -> "), 11);
}

/// Of a mesh of 400 rows, which is one component, the separators are named; of the small ring above nothing more is said.
TEST_F(MatrixCommand, AnalyzeSaysWhereTheFillOfAMeshIsPaid) {
  constexpr int n = 20;
  std::vector<Triplet> mesh;
  const auto connect = [&](int i, int j) { mesh.insert(mesh.end(), {{i, j, -1}, {j, i, -1}}); };
  for (int i = 0; i < n * n; ++i) {
    mesh.push_back({i, i, 5});
    if (i % n + 1 < n) connect(i, i + 1);
    if (i + n < n * n) connect(i, i + n);
  }
  write("mesh.mtx", n * n, mesh);
  const Outcome outcome = run("analyze mesh.mtx --ordering minimum-fill --json mesh.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("where that is paid, by blocks that are eliminated as one:\n"), std::string::npos) << outcome.out;
  EXPECT_EQ(occurrences(outcome.out, " rows: 'row "), 5) << outcome.out;
  EXPECT_NE(outcome.out.find(" more fronts\n"), std::string::npos) << outcome.out;
  const auto fill = nlohmann::json::parse(text("mesh.json"))["fill"];
  for (const char* key : {"fill_blocks", "fill_scalars", "operations"}) {
    std::int64_t sum = 0;
    for (const auto& front : fill["fronts"]) sum += front[key].get<std::int64_t>();
    EXPECT_EQ(sum, fill[key]) << key;
  }
  write("ring.mtx", 12, line(12, Shape::ring));
  EXPECT_EQ(run("analyze ring.mtx --ordering natural").out.find("where that is paid"), std::string::npos);
}

TEST_F(MatrixCommand, LargeMatricesAreDrawnInPixelsAndTheFileStaysSmall) {
  write("long.mtx", 3000, line(3000, Shape::ring));
  const Outcome outcome = run("analyze long.mtx --ordering natural --svg long.svg");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string svg = text("long.svg");
  EXPECT_TRUE(well_formed(svg));
  EXPECT_EQ(occurrences(svg, "<title>"), 0);
  EXPECT_LT(svg.size(), 300'000u);
}

/// Its first row goes first in natural order and fills all of the matrix: 8e8 blocks. Sloan's method takes half a minute,
/// minimum degree 2 s, the other nine together one.
TEST_F(MatrixCommand, OrderingsThatFillMoreThanMemoryHoldsOrTakeLongAreLeftOut) {
  constexpr int n = 40000;
  std::vector<Triplet> arrow;
  for (int i = 0; i < n; ++i) arrow.push_back({i, i, 3});
  for (int i = 1; i < n; ++i) arrow.insert(arrow.end(), {{i, 0, 1e-3}, {0, i, 1e-3}});
  write("arrow.mtx", n, arrow);
  EXPECT_EQ(refused("analyze arrow.mtx --ordering natural"),
            "graphsolve: arrow.mtx: natural: left out, it fills more than 3000000 blocks; take another ordering, or "
            "merge rows into blocks\n");
  const Outcome all = run("analyze arrow.mtx");
  EXPECT_EQ(all.code, 0) << all.err;
  for (const char* part : {"natural: left out, it fills", "sloan: left out, it takes long", "--ordering sloan waits for it",
                           "minimum-degree: left out, it takes long", "--ordering minimum-degree waits for it", "minimum-fill", "reverse-cuthill-mckee"})
    EXPECT_NE(all.out.find(part), std::string::npos) << part;
}

TEST_F(MatrixCommand, AMatrixThatAllOrderingsFillIsRefusedAsAWhole) {
  constexpr int n = 4000;
  std::mt19937 random(1);
  std::vector<Triplet> tangle;
  for (int i = 0; i < n; ++i) {
    tangle.push_back({i, i, 50});
    for (int k = 0; k < 12; ++k)
      if (const int j = static_cast<int>(random() % n); j != i) tangle.insert(tangle.end(), {{i, j, -1}, {j, i, -1}});
  }
  write("tangle.mtx", n, tangle);
  EXPECT_EQ(refused("analyze tangle.mtx"), "graphsolve: tangle.mtx: every ordering fills more than 3000000 blocks, which is too "
                                           "much to explain; merge rows into blocks (--blocks)\n");
}

TEST_F(MatrixCommand, NamesOfTheBlockMapAppearEscaped) {
  write("ring.mtx", 4, line(4, Shape::ring));
  write("map.json", R"({"format": "graphsolve-blocks", "version": 1, "blocks": [{"name": "a<\"&b", "dimension": 2}, 2]})");
  const Outcome outcome = run("analyze ring.mtx --blocks map.json --svg x.svg --dot x.dot --json x.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 blocks from map.json"), std::string::npos) << outcome.out;
  EXPECT_TRUE(well_formed(text("x.svg")));
  EXPECT_NE(text("x.svg").find("a&lt;&quot;&amp;b"), std::string::npos);
  EXPECT_NE(text("x.dot").find("\"a<\\\"&b (2)\""), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(text("x.json"))["blocks"], 2);
}

/// What does not depend on the clock.
nlohmann::json without_times(const std::string& text) {
  auto json = nlohmann::json::parse(text);
  for (auto& row : json["orderings"]) row.erase("ordering_cpu_s"), row.erase("symbolic_cpu_s");
  json.erase("findings");
  return json;
}

TEST_F(MatrixCommand, TheMapThatAnalyzeWritesIsTakenByBothCommandsAndMayBeEdited) {
  write("a.mtx", 4, {{0, 0, 2}, {1, 1, 3}, {0, 1, 1}, {1, 0, 1}, {2, 0, 1}, {0, 2, 1}, {2, 1, 1}, {1, 2, 1}, {3, 0, 1},
                     {0, 3, 1}, {3, 1, -1}, {1, 3, -1}});
  EXPECT_EQ(run("analyze a.mtx --write-blocks map.json --json found.json").code, 0);
  const std::string map = text("map.json");
  EXPECT_NE(map.find(R"({"name":"rows 3-4","dimension":2,"kind":"saddle"})"), std::string::npos) << map;
  EXPECT_NE(map.find("full_row"), std::string::npos) << map;
  const Outcome again = run("analyze a.mtx --blocks map.json --write-blocks again.json --json given.json");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(text("again.json"), map);
  EXPECT_EQ(without_times(text("given.json")), without_times(text("found.json")));
  std::string edited = map;
  while (edited.find("rows 3-4") != std::string::npos) edited.replace(edited.find("rows 3-4"), 8, "held");
  write("edited.json", edited);
  const Outcome solved = run("solve a.mtx --blocks edited.json");
  EXPECT_EQ(solved.code, 0) << solved.err;
  EXPECT_NE(solved.out.find("2 blocks from edited.json"), std::string::npos) << solved.out;
}

TEST_F(MatrixCommand, RoomThatAMapMakesForLaterEntriesIsWrittenAgain) {
  write("chain.mtx", 4, line(4, Shape::chain));
  write("map.json", R"({"format": "graphsolve-blocks", "version": 1, "blocks": [1, 1, 1, 1],
                        "edges": [{"from": "row 1", "to": "row 4"}]})");
  EXPECT_EQ(run("analyze chain.mtx --blocks map.json --write-blocks again.json --json a.json").code, 0);
  EXPECT_EQ(run("analyze chain.mtx --blocks again.json --json b.json").code, 0);
  EXPECT_EQ(without_times(text("a.json")), without_times(text("b.json")));
  EXPECT_GT(nlohmann::json::parse(text("b.json"))["orderings"][0]["fill_blocks"], 0) << "the ring that the map closes";
}

TEST_F(MatrixCommand, AMapIsOnlyWrittenOfAMatrixAndOverNothingThatIsRead) {
  write("a.mtx", 3, line(3, Shape::chain));
  write("sizes.txt", "1 2\n");
  EXPECT_EQ(refused("analyze a.mtx --write-blocks a.mtx"), "graphsolve: --write-blocks would overwrite the input 'a.mtx'\n");
  EXPECT_EQ(refused("analyze a.mtx --blocks sizes.txt --write-blocks sizes.txt"),
            "graphsolve: --write-blocks would overwrite the input 'sizes.txt'\n");
  EXPECT_EQ(refused("analyze snake --write-blocks map.json"),
            "graphsolve: --write-blocks needs a matrix (.mtx), and 'snake' is a scene\n");
  write("twice.json", "{\"format\": \"graphsolve-blocks\", \"version\": 1,\n\"blocks\": [1, 2],\n\"blocks\": [3]}");
  EXPECT_EQ(refused("solve a.mtx --blocks twice.json"),
            "graphsolve: twice.json:3: the key 'blocks' is given twice in one object\n");
}

TEST_F(MatrixCommand, AnalyzeTakesAScene) {
  const Outcome outcome = run("analyze snake:n=4 --ordering minimum-fill --json x.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(text("x.json"));
  EXPECT_EQ(json["blocks"], 7);
  EXPECT_EQ(json["saddle_blocks"], 3);
  EXPECT_EQ(json["orderings"][0]["fill_blocks"], 0);
}

TEST_F(MatrixCommand, AnalyzeSaysWhichOrderingBestTook) {
  write("a.mtx", 3, {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {0, 1, 1}, {1, 0, 1}});
  const Outcome outcome = run("analyze a.mtx --ordering best");
  EXPECT_NE(outcome.out.find("best (minimum-fill)"), std::string::npos) << outcome.out;
}

TEST_F(MatrixCommand, ANumberTooLargeInABlockMapIsNamed) {
  write("a.mtx", 1, {{0, 0, 1}});
  write("map.json", "[1e999]");
  const Outcome outcome = run("analyze a.mtx --blocks map.json");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("map.json:1: a number is too large"), std::string::npos) << outcome.err;
}

TEST_F(MatrixCommand, InputWithoutAnEndIsRefused) {
  if (!fs::exists("/dev/zero")) GTEST_SKIP() << "no /dev/zero here";
  const std::string banner = "%%MatrixMarket matrix coordinate real general\n";
  write("long.mtx", banner + "2 2 2\n" + std::string(200'000, '1') + "\n");
  write("zero.mtx", banner + "2 2 2\n1 1 1\n" + std::string(1, '\0') + "2 2 1\n");
  EXPECT_EQ(refused("solve /dev/zero"), "graphsolve: /dev/zero:1: holds a zero byte: this is no text\n");
  EXPECT_EQ(refused("solve long.mtx"), "graphsolve: long.mtx:3: the line is longer than 65536 characters\n");
  EXPECT_EQ(refused("analyze zero.mtx"), "graphsolve: zero.mtx:4: holds a zero byte: this is no text\n");
  const Outcome endless = run("solve /dev/stdin", "tr '\\0' x </dev/zero |");
  EXPECT_EQ(endless.code, 2);
  EXPECT_EQ(endless.err, "graphsolve: /dev/stdin:1: the line is longer than 65536 characters\n");
}

TEST_F(MatrixCommand, WrongInputIsNamedWithFileLineAndValue) {
  write("a.mtx", 3, line(3, Shape::chain));
  write("bad.mtx", "%%MatrixMarket matrix coordinate real general\n2 2 1\n3 1 1\n");
  write("wide.mtx", "%%MatrixMarket matrix coordinate real general\n2 3 1\n1 1 1\n");
  write("unsymmetric.mtx", 2, {{0, 0, 1}, {1, 1, 1}, {1, 0, 1}});
  write("b.mtx", "%%MatrixMarket matrix array real general\n2 1\n1\n2\n");
  write("sizes.txt", "2 2\n");
  for (const char* command : {"analyze", "solve"}) {
    const std::string c = command;
    EXPECT_EQ(refused(c + " bad.mtx"), "graphsolve: bad.mtx:3: row 3 lies outside of 1 .. 2\n");
    EXPECT_EQ(refused(c + " none.mtx"), "graphsolve: none.mtx: cannot be read: No such file or directory\n");
    EXPECT_EQ(refused(c + " wide.mtx"), "graphsolve: wide.mtx: the matrix must be square, not 2 x 3\n");
    EXPECT_EQ(refused(c + " a.mtx --blocks sizes.txt"),
              "graphsolve: sizes.txt: block 'rows 3-4': row 4 lies outside of 1 .. 3\n");
    EXPECT_NE(refused(c + " a.mtx --ordering bset").find("there is no ordering 'bset'"), std::string::npos);
  }
  EXPECT_EQ(refused("solve a.mtx b.mtx"), "graphsolve: b.mtx: the right-hand side must have 3 rows and a column at least, not 2 x 1\n");
  EXPECT_NE(refused("solve a.mtx --factorization qr").find("there is no factorization 'qr'"), std::string::npos);
  EXPECT_EQ(refused("solve unsymmetric.mtx --factorization ldlt"),
            "graphsolve: unsymmetric.mtx: ldlt needs a symmetric matrix\n");
  EXPECT_NE(refused("analyze snake --blocks sizes.txt").find("is a scene"), std::string::npos);
  EXPECT_NE(refused("analyze no_such_scene").find("no_such_scene"), std::string::npos);
  EXPECT_NE(refused("solve a.mtx --out no/x.mtx").find("no/x.mtx"), std::string::npos);
}

TEST_F(MatrixCommand, NeitherMatrixNorRightHandSideNorMapIsOverwritten) {
  write("a.mtx", 3, line(3, Shape::chain));
  write("b.mtx", "%%MatrixMarket matrix array real general\n3 1\n1\n2\n3\n");
  write("sizes.txt", "1 2\n");
  for (const char* input : {"a.mtx", "b.mtx", "sizes.txt"})
    EXPECT_EQ(refused("solve a.mtx b.mtx --blocks sizes.txt --out " + std::string(input)),
              "graphsolve: --out would overwrite the input '" + std::string(input) + "'\n");
  EXPECT_EQ(refused("analyze a.mtx --json a.mtx"), "graphsolve: --json would overwrite the input 'a.mtx'\n");
  EXPECT_EQ(refused("analyze a.mtx --blocks sizes.txt --dot sizes.txt"),
            "graphsolve: --dot would overwrite the input 'sizes.txt'\n");
}

TEST_F(MatrixCommand, BothExplainThemselves) {
  for (const char* command : {"analyze --help", "solve --help"}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.code, 0);
    for (const char* part : {"--blocks", "--ordering", "Exit code"})
      EXPECT_NE(outcome.out.find(part), std::string::npos) << command << part;
  }
}

}  // namespace test_matrix_commands
