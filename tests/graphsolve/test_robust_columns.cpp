// Orderings, several right-hand sides and transposed solves of RobustSolver.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "factorization_cases.hpp"
#include "graphsolve/robust_solver.hpp"
#include "pair_of_nodes.hpp"
#include "support/problem_families.hpp"

namespace test_robust_columns {

using namespace graphsolve;
using cases::fill;
using cases::pair_graph;
using cases::view;
using families::Difficulty;
using families::Family;
using families::Problem;
using families::Values;

constexpr double untouched = 7.25;

RobustSolver loaded(const Problem& problem, RobustSolver::Options options = {}) {
  RobustSolver solver(problem.graph, std::move(options));
  families::load(problem.matrix, problem.graph, solver.symbolic(), solver.values());
  return solver;
}

double error_of(const Eigen::SparseMatrix<double>& a, const Eigen::VectorXd& x, const Eigen::VectorXd& b) {
  return families::backward_error(a, view(x), view(b));
}

Eigen::SparseMatrix<double> transposed(const Problem& problem) { return problem.matrix.transpose(); }

TEST(RobustSolver, TakesEveryOrderingThatThereIs) {
  const Problem problem = families::make_problem({.family = Family::chain, .n = 40});
  for (const OrderingMethod method : ordering_methods()) {
    if (!available(method)) continue;
    RobustSolver solver = loaded(problem, {.ordering = method});
    const Ordering expected = make_ordering(problem.graph, method);
    EXPECT_EQ(solver.ordering().sequence, expected.sequence) << name(method);
    for (int k = 0; k < solver.symbolic().pivots(); ++k)
      ASSERT_EQ(solver.symbolic().node(k), Symbolic(problem.graph, expected).node(k)) << name(method);
    Eigen::VectorXd x(problem.right.size());
    EXPECT_EQ(solver.solve(view(problem.right), view(x)).status, Status::solved) << name(method);
    EXPECT_LE(error_of(problem.matrix, x, problem.right), 1e-12) << name(method);
  }
}

TEST(RobustSolver, TakesAPermutationOfTheNodesAndRefusesWhatIsNone) {
  const Problem problem = families::make_problem({.family = Family::ladder, .n = 40});
  std::vector<NodeId> sequence;
  for (int k = problem.graph.size(); k-- > 0;) sequence.push_back({k});
  RobustSolver solver = loaded(problem, {.ordering = OrderingMethod::user, .sequence = sequence});
  EXPECT_EQ(solver.ordering().sequence, user_ordering(problem.graph, sequence).sequence);
  EXPECT_NE(solver.ordering().sequence, minimum_fill_ordering(problem.graph).sequence);
  Eigen::VectorXd x(problem.right.size());
  EXPECT_EQ(solver.solve(view(problem.right), view(x)).status, Status::solved);
  EXPECT_LE(error_of(problem.matrix, x, problem.right), 1e-12);
  const auto make = [&](RobustSolver::Options options) { RobustSolver(problem.graph, std::move(options)); };
  EXPECT_THROW(make({.ordering = OrderingMethod::user}), std::invalid_argument);
  EXPECT_THROW(make({.sequence = sequence}), std::invalid_argument);  // would be ignored
  sequence.back() = sequence.front();
  EXPECT_THROW(make({.ordering = OrderingMethod::user, .sequence = sequence}), std::invalid_argument);
}

/// Column c of some solutions that have nothing in common.
Eigen::MatrixXd solutions(const Problem& problem, int columns) {
  return Eigen::MatrixXd::NullaryExpr(problem.right.size(), columns, [](Eigen::Index i, Eigen::Index c) {
    return std::cos(1.7 * static_cast<double>(i) + 0.9 * static_cast<double>(c * c));
  });
}

std::span<double> all_of(Eigen::MatrixXd& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

class EveryDifficulty : public testing::TestWithParam<Difficulty> {};
INSTANTIATE_TEST_SUITE_P(RobustSolver, EveryDifficulty, testing::ValuesIn(families::all_difficulties().begin(), families::all_difficulties().end()));

TEST_P(EveryDifficulty, EveryColumnIsRefinedToTheGoal) {
  constexpr int columns = 4;
  for (const auto family : families::all_families())
    for (const auto values : {Values::symmetric, Values::unsymmetric}) {
      const Problem problem = families::make_problem({.family = family, .n = 60, .difficulty = GetParam(), .values = values});
      RobustSolver solver = loaded(problem, {.acceptable = 1e-15, .max_sweeps = 20});
      Eigen::MatrixXd b = problem.matrix * solutions(problem, columns), x(b.rows(), columns);
      const auto report = solver.solve(all_of(b), all_of(x), columns);
      EXPECT_EQ(report.status, Status::solved) << problem.name << report.why;
      EXPECT_EQ(report.unsolved, 0) << problem.name;
      double worst = 0;
      for (int c = 0; c < columns; ++c) worst = std::max(worst, error_of(problem.matrix, x.col(c), b.col(c)));
      EXPECT_LE(worst, 1e-15) << problem.name;
    }
}

TEST_P(EveryDifficulty, TransposedSystemsAreSolvedToTheGoal) {
  constexpr int columns = 2;
  for (const auto family : families::all_families())
    for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
      const Values values = kind == FactorizationKind::ldu ? Values::unsymmetric : Values::symmetric;
      const Problem problem = families::make_problem({.family = family, .n = 60, .difficulty = GetParam(), .values = values});
      const Eigen::SparseMatrix<double> a = transposed(problem);
      RobustSolver solver = loaded(problem, {.kind = kind, .acceptable = 1e-15, .max_sweeps = 20});
      Eigen::MatrixXd b = a * solutions(problem, columns), x(b.rows(), columns);
      const auto report = solver.solve_transposed(all_of(b), all_of(x), columns);
      EXPECT_EQ(report.status, Status::solved) << problem.name << report.why;
      for (int c = 0; c < columns; ++c) EXPECT_LE(error_of(a, x.col(c), b.col(c)), 1e-15) << problem.name;
    }
}

TEST(RobustSolver, OfSeveralRightHandSidesTheWorstIsReportedAndTheOthersAreSolved) {
  const Problem problem = families::make_problem({.family = Family::chain, .n = 20, .difficulty = Difficulty::redundant});
  RobustSolver solver = loaded(problem);
  ASSERT_GT(solver.factorize().dropped_rows, 0);
  constexpr int columns = 4;
  Eigen::MatrixXd b = problem.matrix * solutions(problem, columns);
  const auto dropped = solver.factorization().dropped_rows()[0];
  b(problem.graph.row(dropped.node) + dropped.row, 1) += 1;
  b(0, 3) = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd x = Eigen::MatrixXd::Constant(b.rows(), columns, untouched);
  const auto report = solver.solve(all_of(b), all_of(x), columns);
  EXPECT_EQ(report.status, Status::singular);
  EXPECT_EQ(report.column, 1);
  EXPECT_EQ(report.unsolved, 2);
  EXPECT_NE(report.why.find("'" + std::string(problem.graph.name(dropped.node)) + "'"), std::string::npos) << report.why;
  for (const int c : {0, 2}) EXPECT_LE(error_of(problem.matrix, x.col(c), b.col(c)), 1e-12) << c;
  for (const int c : {1, 3}) EXPECT_EQ(x.col(c), Eigen::VectorXd::Constant(x.rows(), untouched)) << c;
}

TEST(RobustSolver, TransposedSolvesTakeTheRungsOfTheTransposedMatrixAndSaySo) {
  int calls = 0;
  RobustSolver solver(pair_graph(), {.fallback = [&](const RobustSolver::Matrix& a, std::span<const double> r, std::span<double> y) {
                        ++calls;
                        EXPECT_EQ(std::vector<double>(a.values.begin(), a.values.end()), (std::vector<double>{2, 5}));
                        y[0] = r[1] / 2, y[1] = r[0] / 5;
                        return true;
                      }});
  fill(solver, 0, 2, 5, 0);  // columns of the transposed matrix: 2 below, 5 above
  const std::vector<double> b{15, 8};
  std::vector<double> x(2);
  const auto report = solver.solve_transposed(b, x);
  ASSERT_EQ(report.status, Status::solved) << report.why;
  EXPECT_EQ(report.rung, Rung::threshold_pivoting);
  EXPECT_NE(report.why.find("has no usable pivot"), std::string::npos) << report.why;
  EXPECT_EQ(x, (std::vector<double>{4, 3}));
  EXPECT_GE(calls, 1);
}

TEST(RobustSolver, TransposedSolvesFollowTheValues) {
  RobustSolver solver(pair_graph());
  const std::vector<double> b{4, 8};
  std::vector<double> x(2);
  for (const double zero : {1.0, 0.0}) {  // at 0 by the transposed matrix itself
    fill(solver, 2 * zero, 1, 2, 2 * zero);
    ASSERT_EQ(solver.solve_transposed(b, x).status, Status::solved);
    EXPECT_NEAR(2 * zero * x[0] + 2 * x[1], 4, 1e-14);
    EXPECT_NEAR(x[0] + 2 * zero * x[1], 8, 1e-14);
    fill(solver, 0, 1, 4, 0);
    ASSERT_EQ(solver.solve_transposed(b, x).status, Status::solved);
    EXPECT_EQ(x, (std::vector<double>{8, 1}));
  }
}

TEST(RobustSolver, ContradictingColumnsAreNamedWhereATransposedSystemHasNoSolution) {
  const Problem problem = families::make_problem(
      {.family = Family::chain, .n = 20, .difficulty = Difficulty::redundant, .values = Values::unsymmetric});
  RobustSolver solver = loaded(problem);
  ASSERT_GT(solver.factorize().dropped_rows, 0);
  const auto dropped = solver.factorization().dropped_rows()[0];
  Eigen::VectorXd b = transposed(problem) * solutions(problem, 1).col(0);
  Eigen::VectorXd x = Eigen::VectorXd::Constant(b.size(), untouched);
  ASSERT_EQ(solver.solve_transposed(view(std::as_const(b)), view(x)).status, Status::solved);
  EXPECT_LE(error_of(transposed(problem), x, b), 1e-12);
  b[problem.graph.row(dropped.node) + dropped.row] += 1;
  x.setConstant(untouched);
  const auto report = solver.solve_transposed(view(std::as_const(b)), view(x));
  EXPECT_EQ(report.status, Status::singular);
  EXPECT_EQ(report.why.find("no solution: the columns of '"), 0u) << report.why;
  EXPECT_NE(report.why.find("'" + std::string(problem.graph.name(dropped.node)) + "'"), std::string::npos) << report.why;
  EXPECT_EQ(x, Eigen::VectorXd::Constant(b.size(), untouched));
}

/// x0 + x1 = 1 and = 1 + 1e-8, of numbers near 1e6: a backward error would not tell.
TEST(RobustSolver, SmallContradictionsAmongLargeNumbersAreFoundOnBothSides) {
  BlockGraph graph;
  const NodeId x = graph.add_node("x", 2);
  const NodeId c[2] = {graph.add_node("one", 1, NodeKind::saddle), graph.add_node("other", 1, NodeKind::saddle)};
  for (const NodeId node : c) graph.add_edge(node, x, EdgeRank::full_row);
  RobustSolver solver(graph);
  const Symbolic& s = solver.symbolic();
  for (int i = 0; i < 2; ++i) {
    solver.entry(s.block(x, x), i, i) = 1;
    for (const NodeId node : c) {
      solver.entry(s.block(node, x), 0, i) = 1;
      solver.entry(s.block(x, node), i, 0) = -1;
    }
  }
  for (const double sign : {1.0, -1.0}) {  // of J in A and in A^T
    std::vector<double> b{1e6, -1e6, sign, sign * (1 + 1e-8)}, y(4, untouched);
    auto report = sign > 0 ? solver.solve(b, y) : solver.solve_transposed(b, y);
    EXPECT_EQ(report.status, Status::singular) << sign << report.backward_error;
    const std::string what = sign > 0 ? "no solution: the rows of " : "no solution: the columns of ";
    EXPECT_EQ(report.why.find(what + "'one', 'other'"), 0u) << report.why;
    EXPECT_EQ(y, std::vector<double>(4, untouched));
    b[3] = b[2];
    report = sign > 0 ? solver.solve(b, y) : solver.solve_transposed(b, y);
    EXPECT_EQ(report.status, Status::solved) << report.why;
    EXPECT_NEAR(y[0] + y[1], 1, 1e-9);
  }
}

TEST(RobustSolver, NumbersThatAreNoneAreNamedAlsoWhereTheSystemIsTransposed) {
  RobustSolver solver(pair_graph());
  fill(solver, 1, std::numeric_limits<double>::quiet_NaN(), 0, 1);
  const std::vector<double> b{1, 2};
  std::vector<double> x(2);
  EXPECT_EQ(solver.solve_transposed(b, x).why, "entry (0, 0) of block ('left', 'right') is nan");
}

TEST(Refinement, OfTransposedSystemsReachesTheGoalWithAndWithoutPacks) {
  for (const auto family : families::all_families())
    for (const Packs packs : {Packs::off, Packs::on}) {
      const Problem problem = families::make_problem(
          {.family = family, .n = 60, .difficulty = Difficulty::mass_ratio, .values = Values::unsymmetric});
      const Eigen::SparseMatrix<double> a = transposed(problem);
      Factorization f(std::make_shared<const Symbolic>(problem.graph, minimum_fill_ordering(problem.graph), packs));
      f.allow_refinement();
      f.keep_matrix(true);
      families::load(problem.matrix, problem.graph, f.symbolic(), f.values());
      ASSERT_TRUE(f.factorize().ok());
      const Eigen::VectorXd b = a * problem.solution;
      Eigen::VectorXd x = b;
      f.solve_transposed(view(x));
      x[0] *= 1 + 1e-6;  // what refinement has to mend
      const auto refined = f.refine_transposed(view(b), view(x), 10);
      EXPECT_NEAR(refined.backward_error, error_of(a, x, b), 1e-15) << problem.name;
      EXPECT_LE(error_of(a, x, b), 1e-15) << problem.name;
      EXPECT_GT(refined.sweeps, 0) << problem.name;
    }
}

/// A chain of four nodes of three rows whose last rows are equal but for 1e-6, and a solution whose halves differ by 1e12:
/// rounding in rows of large terms is as large as the small ones, and elimination spreads it.
struct TwoSizes {
  explicit TwoSizes(std::uint64_t seed) : matrix(12, 12), solution(12) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(12, 12);
    for (int i = 0; i < 12; ++i) {
      if (i % 3 == 0) graph.add_node(std::to_string(i / 3), 3, NodeKind::regular);
      if (i % 3 == 0 && i > 0) graph.add_edge({i / 3 - 1}, {i / 3});
      for (int j = 0; j < 12; ++j)
        if (std::abs(i / 3 - j / 3) <= 1) a(i, j) = number(random);
      solution[i] = number(random) * (i < 6 ? 1e6 : 1e-6);
    }
    a.row(11) = a.row(10) + 1e-6 * a.row(11);
    matrix = a.sparseView();
  }
  BlockGraph graph;
  Eigen::SparseMatrix<double> matrix;
  Eigen::VectorXd solution;
};

TEST(Refinement, OfTransposedSystemsTakesResidualsInTwiceThePrecisionWhereOthersStandStill) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const Packs packs : {Packs::off, Packs::on}) {
      const TwoSizes system(seed);
      const Eigen::SparseMatrix<double> a = system.matrix.transpose();
      Factorization f(std::make_shared<const Symbolic>(system.graph, minimum_fill_ordering(system.graph), packs));
      f.allow_refinement();
      f.keep_matrix(true);
      families::load(system.matrix, system.graph, f.symbolic(), f.values());
      ASSERT_TRUE(f.factorize().ok());
      const Eigen::VectorXd b = a * system.solution;
      Eigen::VectorXd x = b;
      f.solve_transposed(view(x));
      const auto refined = f.refine_transposed(view(b), view(x), 30);
      // In one precision a third of these stand still at 2e-15 to 1e-13.
      EXPECT_LE(error_of(a, x, b), 1e-15) << "seed " << seed;
      EXPECT_NEAR(refined.backward_error, error_of(a, x, b), 3e-16) << "seed " << seed;
    }
}

}  // namespace test_robust_columns
