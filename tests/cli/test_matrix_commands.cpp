#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "graphsolve/io/matrix_market.hpp"
#include "program.hpp"

// `analyze` and `solve` as a shell sees them.

namespace {

namespace fs = std::filesystem;
using graphsolve::SparseMatrix;
using graphsolve::Triplet;
namespace io = graphsolve::io;

class MatrixCommand : public Program {
 protected:
  using Program::write;
  void write(const std::string& name, int n, const std::vector<Triplet>& triplets) const {
    write(name, io::matrix_market(graphsolve::from_triplets(n, n, triplets)));
  }
};

/// A ring of n rows, symmetric and positive definite; without the closing link a chain.
enum class Shape { chain, ring };
std::vector<Triplet> line(int n, Shape shape) {
  std::vector<Triplet> t;
  for (int i = 0; i < n; ++i) {
    t.push_back({i, i, 4});
    const int next = (i + 1) % n;
    if (next != 0 || shape == Shape::ring) t.insert(t.end(), {{i, next, -1}, {next, i, -1}});
  }
  return t;
}

/// Two variables held by constraints: x0, and x0 again when `twice`.
std::vector<Triplet> saddle(bool twice) {
  std::vector<Triplet> t{{0, 0, 2}, {1, 1, 3}, {0, 1, 1}, {1, 0, 1}, {2, 0, 1}, {0, 2, 1}};
  if (twice) t.insert(t.end(), {{3, 0, 2}, {0, 3, 2}});
  else t.insert(t.end(), {{3, 1, 1}, {1, 3, 1}});
  return t;
}

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

TEST_F(MatrixCommand, LargeMatricesAreDrawnInPixelsAndTheFileStaysSmall) {
  write("long.mtx", 3000, line(3000, Shape::ring));
  const Outcome outcome = run("analyze long.mtx --ordering natural --svg long.svg");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::string svg = text("long.svg");
  EXPECT_TRUE(well_formed(svg));
  EXPECT_EQ(occurrences(svg, "<title>"), 0);
  EXPECT_LT(svg.size(), 300'000u);
}

/// Its first row goes first in natural order and fills all of the matrix: 2e8 blocks.
TEST_F(MatrixCommand, AnOrderingThatFillsMoreThanMemoryHoldsIsLeftOut) {
  constexpr int n = 20000;
  std::vector<Triplet> arrow;
  for (int i = 0; i < n; ++i) arrow.push_back({i, i, 3});
  for (int i = 1; i < n; ++i) arrow.insert(arrow.end(), {{i, 0, 1e-3}, {0, i, 1e-3}});
  write("arrow.mtx", n, arrow);
  EXPECT_EQ(refused("analyze arrow.mtx --ordering natural"),
            "graphsolve: arrow.mtx: natural: left out, it fills more than 3000000 blocks; take another ordering, or "
            "merge rows into blocks\n");
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

TEST_F(MatrixCommand, AnalyzeTakesAScene) {
  const Outcome outcome = run("analyze snake:n=4 --ordering minimum-fill --json x.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(text("x.json"));
  EXPECT_EQ(json["blocks"], 7);
  EXPECT_EQ(json["saddle_blocks"], 3);
  EXPECT_EQ(json["orderings"][0]["fill_blocks"], 0);
}

TEST_F(MatrixCommand, SolveFindsOnesAndWritesThemBitForBit) {
  write("a.mtx", 20, line(20, Shape::ring));
  const Outcome outcome = run("solve a.mtx --out x.mtx");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("cholesky"), std::string::npos);
  EXPECT_NE(outcome.out.find("20 0 0"), std::string::npos) << outcome.out;
  const io::DenseMatrix x = io::read_dense_matrix_market((folder_ / "x.mtx").string());
  ASSERT_EQ(x.rows, 20);
  for (const double value : x.value) EXPECT_NEAR(value, 1, 1e-14);
}

TEST_F(MatrixCommand, SolveTakesSeveralRightHandSidesAndEveryFactorization) {
  write("a.mtx", 6, line(6, Shape::ring));
  const SparseMatrix a = io::read_matrix_market((folder_ / "a.mtx").string()).matrix;
  const std::vector<double> expected{1, 2, 3, 4, 5, 6, -1, 0, 1, 0, -1, 7};
  std::vector<double> b(12);
  for (const std::size_t c : {0u, 1u}) graphsolve::multiply(a, std::span(expected).subspan(6 * c, 6), std::span(b).subspan(6 * c, 6));
  write("b.mtx", io::matrix_market(b, 6));
  for (const char* kind : {"ldu", "ldlt", "cholesky", "auto"}) {
    const Outcome outcome = run(std::string("solve a.mtx b.mtx --out x.mtx --factorization ") + kind);
    EXPECT_EQ(outcome.code, 0) << kind << outcome.err;
    const io::DenseMatrix x = io::read_dense_matrix_market((folder_ / "x.mtx").string());
    ASSERT_EQ(x.value.size(), 12u);
    for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(x.value[k], expected[k], 1e-13) << kind;
  }
}

TEST_F(MatrixCommand, SolveReportsTheInertiaOfASaddleSystem) {
  write("a.mtx", 4, saddle(false));
  const Outcome outcome = run("solve a.mtx");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 2 0"), std::string::npos) << outcome.out;
}

TEST_F(MatrixCommand, SolveNamesTheBlocksOfASingularMatrixAndExitsWithOne) {
  write("a.mtx", 4, saddle(true));
  const Outcome twice = run("solve a.mtx --out x.mtx");
  EXPECT_EQ(twice.code, 1) << twice.out << twice.err;
  EXPECT_NE(twice.err.find("a.mtx: the matrix is singular"), std::string::npos) << twice.err;
  EXPECT_NE(twice.err.find("rows 3-4"), std::string::npos) << twice.err;
  EXPECT_FALSE(fs::exists(folder_ / "x.mtx"));
  write("zero.mtx", 3, {{0, 0, 1}, {1, 1, 1}, {2, 2, 0}});
  const Outcome zero = run("solve zero.mtx");
  EXPECT_EQ(zero.code, 1) << zero.out;
  EXPECT_NE(zero.err.find("graphsolve: row 3 has no entry\n"), std::string::npos) << zero.err;
  // Two equal rows that no zero on the diagonal gives away.
  write("equal.mtx", 3, {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 1}, {2, 2, 1}, {1, 2, 1}, {2, 1, 1}, {0, 2, 1}, {2, 0, 1}});
  EXPECT_EQ(run("solve equal.mtx").code, 1);
  // Whoever is asked to factor it: the chain that stands in for cholesky solves it for this right-hand side.
  write("one.mtx", 2, {{0, 0, 1}, {0, 1, 2}, {1, 0, 2}, {1, 1, 4}});
  for (const char* kind : {"auto", "ldu", "ldlt", "cholesky"})
    for (const char* file : {"a.mtx", "equal.mtx", "one.mtx"}) {
      const Outcome outcome = run("solve " + std::string(file) + " --factorization " + kind);
      EXPECT_EQ(outcome.code, 1) << file << " by " << kind << outcome.out;
      EXPECT_NE(outcome.err.find("the matrix is singular"), std::string::npos) << outcome.err;
    }
}

// Regular once rows and columns are scaled (condition 9), though a pivot is boosted on the way.
TEST_F(MatrixCommand, UnitsFarApartDoNotMakeAMatrixSingular) {
  write("a.mtx", 4, {{0, 0, 1}, {1, 1, 2}, {2, 2, -1}, {3, 3, -1e18}, {2, 0, -1}, {0, 2, -1}, {3, 0, 2e9}, {0, 3, 2e9},
                     {2, 1, 3e-9}, {1, 2, 3e-9}, {3, 1, -1}, {1, 3, -1}, {3, 2, 1e9}, {2, 3, 1e9}});
  const Outcome outcome = run("solve a.mtx --factorization ldlt");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_EQ(outcome.err.find("singular"), std::string::npos) << outcome.err;
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

TEST_F(MatrixCommand, OfASingularSystemWithSolutionsOneIsTakenOnDemand) {
  write("a.mtx", 4, saddle(true));
  const Outcome refused = run("solve a.mtx --out x.mtx");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("--accept-singular takes one"), std::string::npos) << refused.err;
  const Outcome taken = run("solve a.mtx --out x.mtx --accept-singular");
  EXPECT_EQ(taken.code, 0) << taken.err;
  EXPECT_NE(taken.err.find("a.mtx: the matrix is singular"), std::string::npos) << taken.err;
  EXPECT_TRUE(fs::exists(folder_ / "x.mtx"));
  // No x solves 0 x3 = 1.
  write("zero.mtx", 3, {{0, 0, 1}, {1, 1, 1}, {2, 2, 0}});
  std::ofstream(folder_ / "b.mtx") << "%%MatrixMarket matrix array real general\n3 1\n1\n1\n1\n";
  EXPECT_EQ(run("solve zero.mtx b.mtx --accept-singular").code, 1);
}

// The constant vector solves A v = 0; what rounding leaves of the last pivot is as often positive as not. Wide units do
// not make the same network singular once one node is held.
TEST_F(MatrixCommand, ANetworkThatNothingHoldsIsSingularWhateverRoundingMakesOfIt) {
  for (int seed = 1; seed <= 10; ++seed) {
    const int n = 30;
    std::vector<double> diagonal(n, 0.0);
    std::vector<graphsolve::Triplet> entries;
    const auto connect = [&](int i, int j) {
      const double conductance = 1 + 0.7 * std::sin(1.3 * i + 0.37 * j * seed);
      entries.push_back({i, j, -conductance});
      entries.push_back({j, i, -conductance});
      diagonal[i] += conductance;
      diagonal[j] += conductance;
    };
    for (int i = 0; i < n; ++i) connect(i, (i + 1) % n), connect(i, (i + 7) % n);
    for (int i = 0; i < n; ++i) entries.push_back({i, i, diagonal[i]});
    write("free.mtx", n, entries);
    const Outcome outcome = run("solve free.mtx");
    EXPECT_EQ(outcome.code, 1) << seed << outcome.out;
    EXPECT_NE(outcome.err.find("free.mtx: the matrix is singular"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out.find("good"), std::string::npos) << outcome.out;
    entries.back().value += 1;
    const auto unit = [&](int i) { return std::pow(10.0, 12 * std::sin(2.0 * i)); };
    for (auto& entry : entries) entry.value *= unit(entry.row) * unit(entry.column);
    write("held.mtx", n, entries);
    EXPECT_EQ(run("solve held.mtx").code, 0) << seed;
  }
}

TEST_F(MatrixCommand, WhatCholeskyCannotDoLdltDoesAndBothAreReported) {
  write("a.mtx", 2, {{0, 0, 1}, {1, 1, 1}, {0, 1, 2}, {1, 0, 2}});
  write("sizes.txt", "1 1\n");
  const Outcome outcome = run("solve a.mtx --blocks sizes.txt");
  EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_NE(outcome.out.find("cholesky: not positive definite at block"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("1 1 0"), std::string::npos) << outcome.out;
}

TEST_F(MatrixCommand, BlocksWronglyCalledRegularAreSolvedByTheRobustChainAloud) {
  write("a.mtx", 3, {{0, 1, 1}, {1, 2, 1}, {2, 0, 1}});
  const std::string block = R"({"dimension": 1, "kind": "regular"})";
  write("map.json", R"({"format": "graphsolve-blocks", "version": 1, "blocks": [)" + block + "," + block + "," + block + "]}");
  const Outcome outcome = run("solve a.mtx --blocks map.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_NE(outcome.out.find("ldu: singular pivot at block"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("robust: "), std::string::npos) << outcome.out;
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
  EXPECT_EQ(refused("solve a.mtx b.mtx"), "graphsolve: b.mtx: the right-hand side must have 3 rows, not 2 x 1\n");
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

}  // namespace
