#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "matrix_command.hpp"

namespace test_solve_command {

// `solve` as a shell sees it.

using namespace matrix_command;

class SolveCommand : public MatrixCommand {};

const std::string three_regular_rows = R"({"format": "graphsolve-blocks", "version": 1, "blocks": [
  {"dimension": 1, "kind": "regular"}, {"dimension": 1, "kind": "regular"}, {"dimension": 1, "kind": "regular"}]})";

TEST_F(SolveCommand, SolveFindsOnesAndWritesThemBitForBit) {
  write("a.mtx", 20, line(20, Shape::ring));
  const Outcome outcome = run("solve a.mtx --out x.mtx");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("cholesky"), std::string::npos);
  EXPECT_NE(outcome.out.find("20 0 0"), std::string::npos) << outcome.out;
  const io::DenseMatrix x = io::read_dense_matrix_market((folder_ / "x.mtx").string());
  ASSERT_EQ(x.rows, 20);
  for (const double value : x.value) EXPECT_NEAR(value, 1, 1e-14);
}

TEST_F(SolveCommand, SolveTakesSeveralRightHandSidesAndEveryFactorization) {
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

TEST_F(SolveCommand, SolveReportsTheInertiaOfASaddleSystem) {
  write("a.mtx", 4, saddle(false));
  const Outcome outcome = run("solve a.mtx");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 2 0"), std::string::npos) << outcome.out;
}

TEST_F(SolveCommand, SolveNamesTheBlocksOfASingularMatrixAndExitsWithOne) {
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
TEST_F(SolveCommand, UnitsFarApartDoNotMakeAMatrixSingular) {
  write("a.mtx", 4, {{0, 0, 1}, {1, 1, 2}, {2, 2, -1}, {3, 3, -1e18}, {2, 0, -1}, {0, 2, -1}, {3, 0, 2e9}, {0, 3, 2e9},
                     {2, 1, 3e-9}, {1, 2, 3e-9}, {3, 1, -1}, {1, 3, -1}, {3, 2, 1e9}, {2, 3, 1e9}});
  const Outcome outcome = run("solve a.mtx --factorization ldlt");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_EQ(outcome.err.find("singular"), std::string::npos) << outcome.err;
}

/// Regular, 2 positive eigenvalues and 1 negative, but in this order a pivot has no size of its own: no eigenvalue is zero.
TEST_F(SolveCommand, SignsOfBoostedPivotsAreNotKnownAndNotCalledZero) {
  write("a.mtx", 3, {{1, 1, 3}, {2, 2, 1}, {0, 1, 1}, {1, 0, 1}, {0, 2, 1}, {2, 0, 1}});
  write("map.json", three_regular_rows);
  const Outcome outcome = run("solve a.mtx --blocks map.json --factorization ldlt --ordering natural");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("  1 1 0 (1?)  "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("ldlt: inertia: at least 1 positive, at least 1 negative; one pivot without size of its own was "
                             "boosted, its sign is not known\n"),
            std::string::npos) << outcome.out;
  const Outcome better = run("solve a.mtx --blocks map.json --factorization ldlt");
  EXPECT_NE(better.out.find("  2 1 0  "), std::string::npos) << better.out;
  EXPECT_EQ(better.out.find("not known"), std::string::npos) << better.out;
}

TEST_F(SolveCommand, OfASingularSystemWithSolutionsOneIsTakenOnDemand) {
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
TEST_F(SolveCommand, ANetworkThatNothingHoldsIsSingularWhateverRoundingMakesOfIt) {
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

// What threshold pivoting solves to rounding may be singular all the same. Which rung solves is up to rounding, and that to
// the instruction set: of so many some get there with each.
TEST_F(SolveCommand, WhatTheRobustChainSolvesIsAskedWhetherItIsSingular) {
  std::mt19937 random(5);
  const auto from = [&](int low, int high) { return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1)); };
  const double units[] = {1, 1e-6, 1e6, 1e12};
  int by_chain = 0;
  for (int seed = 0; seed < 100; ++seed) {
    double a[4][4];
    for (auto& row : a)
      for (double& entry : row) entry = from(-4, 4);
    for (int j = 0; j < 4; ++j) a[3][j] = a[0][j] + a[1][j];
    std::vector<Triplet> entries;
    double of_row[4], of_column[4];
    for (int i = 0; i < 4; ++i) of_row[i] = units[from(0, 3)], of_column[i] = units[from(0, 3)];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) entries.push_back({i, j, a[i][j] * of_row[i] * of_column[j]});
    write("a.mtx", 4, entries);
    const Outcome outcome = run("solve a.mtx");
    EXPECT_EQ(outcome.code, 1) << seed << outcome.out;
    EXPECT_NE(outcome.err.find("the matrix is singular"), std::string::npos) << seed << outcome.err;
    by_chain += outcome.out.find("robust: threshold pivoting") != std::string::npos && outcome.err.find("--accept-singular") != std::string::npos;
  }
  EXPECT_GT(by_chain, 0);
}

TEST_F(SolveCommand, WhatCholeskyCannotDoLdltDoesAndBothAreReported) {
  write("a.mtx", 2, {{0, 0, 1}, {1, 1, 1}, {0, 1, 2}, {1, 0, 2}});
  write("sizes.txt", "1 1\n");
  const Outcome outcome = run("solve a.mtx --blocks sizes.txt");
  EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_NE(outcome.out.find("cholesky: not positive definite at block"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("1 1 0"), std::string::npos) << outcome.out;
}

/// A ring that leans: neighbours differ, and blocks of one row.
std::vector<Triplet> leaning_ring(int n) {
  std::vector<Triplet> t;
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    t.insert(t.end(), {{i, i, 4.0 + 0.1 * i}, {i, next, -1.5}, {next, i, 0.25 * i}});
  }
  return t;
}

TEST_F(SolveCommand, TransposedSolvesWithTheFactorsOfA) {
  write("a.mtx", 12, leaning_ring(12));
  const SparseMatrix a = io::read_matrix_market((folder_ / "a.mtx").string()).matrix;
  std::vector<double> expected(24), b(24);
  for (std::size_t k = 0; k < 24; ++k) expected[k] = std::sin(1.0 + static_cast<double>(k));
  for (const std::size_t c : {0u, 1u})
    graphsolve::multiply(graphsolve::transpose(a), std::span(expected).subspan(12 * c, 12), std::span(b).subspan(12 * c, 12));
  write("b.mtx", io::matrix_market(b, 12));
  const Outcome outcome = run("solve a.mtx b.mtx --transposed --out x.mtx");
  ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("2 right-hand sides of A^T x = b\n"), std::string::npos) << outcome.out;
  EXPECT_NE(text("x.mtx").find("x of A^T x = b, A = a.mtx"), std::string::npos);
  const std::vector<double> x = io::read_dense_matrix_market((folder_ / "x.mtx").string()).value;
  ASSERT_EQ(x.size(), 24u);
  for (std::size_t k = 0; k < 24; ++k) EXPECT_NEAR(x[k], expected[k], 1e-14);
  ASSERT_EQ(run("solve a.mtx b.mtx --out x.mtx").code, 0);
  EXPECT_GT(std::abs(io::read_dense_matrix_market((folder_ / "x.mtx").string()).value[0] - expected[0]), 1e-3) << "shows nothing";
  const Outcome ones = run("solve a.mtx --transposed");
  EXPECT_EQ(ones.code, 0) << ones.err;
  const auto error = ones.out.find("largest |x - 1|: ");
  ASSERT_NE(error, std::string::npos) << ones.out;
  EXPECT_LT(std::stod(ones.out.substr(error + 17)), 1e-14);
  // Of a symmetric matrix it is the same, by every factorization.
  write("s.mtx", 6, line(6, Shape::ring));
  for (const char* kind : {"ldu", "ldlt", "cholesky"})
    EXPECT_EQ(run(std::string("solve s.mtx --transposed --factorization ") + kind).code, 0) << kind;
}

TEST_F(SolveCommand, TransposedGoesThroughTheRobustChainAndKnowsSingularMatrices) {
  write("cycle.mtx", 3, {{0, 1, 1}, {1, 2, 2}, {2, 0, 4}});
  write("map.json", three_regular_rows);
  write("b.mtx", io::matrix_market(std::vector<double>{4, 1, 2}, 3));  // A^T of ones
  const Outcome chain = run("solve cycle.mtx b.mtx --transposed --blocks map.json --out x.mtx");
  EXPECT_EQ(chain.code, 0) << chain.out << chain.err;
  EXPECT_NE(chain.out.find("robust: "), std::string::npos) << chain.out;
  for (const double x : io::read_dense_matrix_market((folder_ / "x.mtx").string()).value) EXPECT_NEAR(x, 1, 1e-15);
  // The last row is twice, the last column five times the one before: b has to be so too, in A x = b and A^T x = b.
  write("twice.mtx", 4, {{0, 0, 2}, {1, 1, 3}, {0, 1, 1}, {1, 0, 0.5}, {2, 0, 1}, {0, 2, 1}, {3, 0, 2}, {0, 3, 5}});
  const Outcome singular = run("solve twice.mtx --transposed");
  EXPECT_EQ(singular.code, 1) << singular.out;
  EXPECT_NE(singular.err.find("twice.mtx: the matrix is singular"), std::string::npos) << singular.err;
  EXPECT_NE(singular.err.find("--accept-singular takes one"), std::string::npos) << singular.err;
  for (const double factor : {2.0, 5.0}) {
    write("b.mtx", io::matrix_market(std::vector<double>{1, 2, 3, 3 * factor}, 4));
    EXPECT_EQ(run("solve twice.mtx b.mtx --accept-singular").code, factor == 2 ? 0 : 1);
    EXPECT_EQ(run("solve twice.mtx b.mtx --accept-singular --transposed").code, factor == 5 ? 0 : 1);
  }
}

TEST_F(SolveCommand, BlocksWronglyCalledRegularAreSolvedByTheRobustChainAloud) {
  write("a.mtx", 3, {{0, 1, 1}, {1, 2, 1}, {2, 0, 1}});
  write("map.json", three_regular_rows);
  const Outcome outcome = run("solve a.mtx --blocks map.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_NE(outcome.out.find("ldu: singular pivot at block"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("robust: "), std::string::npos) << outcome.out;
}

/// The second row is twice the first: only the second right-hand side contradicts that.
TEST_F(SolveCommand, TheRightHandSideThatHasNoSolutionIsNamed) {
  write("one.mtx", 2, {{0, 0, 1}, {0, 1, 2}, {1, 0, 2}, {1, 1, 4}});
  write("sizes.txt", "1 1\n");
  write("b.mtx", io::matrix_market(std::vector<double>{1, 2, 1, 0, 3, 6}, 2));
  const Outcome outcome = run("solve one.mtx b.mtx --factorization cholesky --blocks sizes.txt --accept-singular");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("no solution found for 1 of 3 right-hand sides\n"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(": right-hand side 2: factorization: backward error"), std::string::npos) << outcome.out;
}

/// The first overflows as the program makes its right-hand side, the others as they are solved.
TEST_F(SolveCommand, NumbersOutOfTheRangeOfDoublesMakeNoMatrixSingular) {
  write("large.mtx", 2, {{0, 0, 1.7e308}, {0, 1, 1.6e308}, {1, 0, 1.6e308}, {1, 1, 1.7e308}});
  const Outcome own = run("solve large.mtx");
  EXPECT_EQ(own.code, 2) << own.out << own.err;
  EXPECT_NE(own.err.find("large.mtx: row 1 of A * ones is inf: give a right-hand side"), std::string::npos) << own.err;
  write("b.mtx", io::matrix_market(std::vector<double>{1.7e308, 1.6e308}, 2));
  EXPECT_EQ(run("solve large.mtx b.mtx").err.find("is singular"), std::string::npos);
  for (const auto& [a, b] : {std::pair{1e-200, 1e200}, std::pair{1e200, 1e-200}}) {
    write("a.mtx", 1, {{0, 0, a}});
    write("b.mtx", io::matrix_market(std::vector<double>{b}, 1));
    const Outcome outcome = run("solve a.mtx b.mtx --out x.mtx");
    EXPECT_EQ(outcome.code, 1) << outcome.out;
    EXPECT_NE(outcome.err.find("a.mtx: no attempt was good enough; the matrix was not found to be singular"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.out.find("the matrix is not singular, "), std::string::npos) << outcome.out;
    EXPECT_FALSE(fs::exists(folder_ / "x.mtx"));
  }
}

/// Its first row goes first in natural order and fills all of the matrix: 1.6e11 numbers.
TEST_F(SolveCommand, FillBeyondTheMemoryOfTheMachineIsRefusedBeforeItIsMade) {
  constexpr int n = 400'000;
  std::string arrow = "%%MatrixMarket matrix coordinate real symmetric\n400000 400000 799999\n1 1 400000\n";
  for (int i = 2; i <= n; ++i) arrow += std::to_string(i) + " 1 1\n" + std::to_string(i) + " " + std::to_string(i) + " 4\n";
  write("arrow.mtx", arrow);
  const Outcome outcome = run("solve arrow.mtx --ordering natural");
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  EXPECT_TRUE(outcome.err.starts_with("graphsolve: arrow.mtx: in the order 'natural' the matrix fills so much that its factor"))
      << outcome.err;
  EXPECT_NE(outcome.err.find("take another --ordering"), std::string::npos) << outcome.err;
}

/// Its first row has no pivot of its own, and goes first in natural order only.
TEST_F(SolveCommand, TheRobustChainKeepsTheOrderingThatWasAskedFor) {
  write("a.mtx", 3, {{1, 1, 3}, {2, 2, 1}, {0, 1, 1}, {1, 0, 1}, {0, 2, 1}, {2, 0, 1}});
  write("map.json", three_regular_rows);
  for (const auto& [ordering, boosts] : {std::pair("natural", 1), std::pair("minimum-fill", 0)}) {
    const Outcome outcome = run(std::string("solve a.mtx --blocks map.json --factorization cholesky --ordering ") + ordering);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::size_t line = outcome.out.find("\nrobust: factorization");
    ASSERT_NE(line, std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.out.substr(line, outcome.out.find('\n', line + 1) - line).find("(1?)") != std::string::npos, boosts == 1)
        << outcome.out;
  }
}

}  // namespace test_solve_command
