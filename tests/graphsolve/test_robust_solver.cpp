#include "graphsolve/robust_solver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "factorization_cases.hpp"
#include "graphsolve/diagnosis.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "pair_of_nodes.hpp"
#include "support/problem_families.hpp"

namespace test_robust_solver {

using namespace graphsolve;
using cases::fill;
using cases::pair_graph;
using cases::view;
using families::Problem;

RobustSolver loaded(const Problem& problem, RobustSolver::Options options) {
  RobustSolver solver(problem.graph, std::move(options));
  families::load(problem.matrix, problem.graph, solver.symbolic(), solver.values());
  return solver;
}

RobustSolver::Report solve_to_the_goal(const Problem& problem, FactorizationKind kind) {
  RobustSolver solver = loaded(problem, {.kind = kind, .acceptable = 1e-15, .max_sweeps = 20});
  Eigen::VectorXd x = Eigen::VectorXd::Constant(problem.right.size(), std::numeric_limits<double>::quiet_NaN());
  const auto report = solver.solve(view(problem.right), view(x));
  EXPECT_EQ(report.status, Status::solved) << problem.name << ": " << report.why;
  EXPECT_LE(families::backward_error(problem.matrix, view(x), view(problem.right)), 1e-15) << problem.name << name(report.rung);
  EXPECT_EQ(report.rung == Rung::factorization, report.why.empty()) << problem.name << report.why;
  return report;
}

/// Two constraints that differ by e: their complement is e^2, less than what rows are left out for, but the matrix is far from
/// singular, and no one may say that there is no solution.
TEST(RobustSolver, RowsThatAreAlmostParallelDoNotContradictEachOther) {
  for (const double e : {1e-4, 1e-5, 4e-6, 1e-6})
    for (const auto kind : {FactorizationKind::ldlt, FactorizationKind::ldu}) {
      BlockGraph graph;
      const NodeId x = graph.add_node("x", 2), c = graph.add_node("c", 2, NodeKind::saddle);
      graph.add_edge(c, x);
      RobustSolver solver(graph, {.kind = kind});
      const Symbolic& s = solver.symbolic();
      const double rows[2][2] = {{1, 1}, {1, 1 + e}};
      for (int i = 0; i < 2; ++i) {
        solver.entry(s.block(x, x), i, i) = 1;
        for (int j = 0; j < 2; ++j) solver.entry(s.block(c, x), i, j) = solver.entry(s.block(x, c), j, i) = rows[i][j];
      }
      const std::vector<double> b{0, 0, 2, 3};
      std::vector<double> y(4);
      const auto report = solver.solve(b, y);
      ASSERT_EQ(report.status, Status::solved) << e << ": " << report.why;
      const double second = 1 / e;  // x0 + x1 = 2, e x1 = 1
      EXPECT_NEAR(y[1], second, 1e-8 * second);
      EXPECT_NEAR(y[0], 2 - second, 1e-8 * second);
    }
}

class EveryHardVariant : public testing::TestWithParam<families::Difficulty> {};

TEST_P(EveryHardVariant, OfEveryFamilyIsSolvedToTheGoal) {
  for (const auto family : families::all_families())
    for (const int n : {60, 100})
      for (const auto leaves : {families::Leaves::none, families::Leaves::one_each})
        for (const auto values : {families::Values::symmetric, families::Values::unsymmetric}) {
          const Problem problem = families::make_problem(
              {.family = family, .n = n, .leaves = leaves, .difficulty = GetParam(), .values = values});
          (void)solve_to_the_goal(problem, FactorizationKind::ldu);
          if (values == families::Values::symmetric) (void)solve_to_the_goal(problem, FactorizationKind::ldlt);
        }
}
INSTANTIATE_TEST_SUITE_P(RobustSolver, EveryHardVariant, testing::ValuesIn(families::all_difficulties().begin(), families::all_difficulties().end()));

// The plain residual of these has nothing but rounding where the error still is 1e-14.
TEST(RobustSolver, ResidualsInTwiceThePrecisionSpareTheOtherRungs) {
  for (const auto values : {families::Values::symmetric, families::Values::unsymmetric}) {
    const Problem problem = families::make_problem({.family = families::Family::control, .n = 100,
                                                    .difficulty = families::Difficulty::wide_diagonals, .values = values});
    EXPECT_EQ(solve_to_the_goal(problem, FactorizationKind::ldu).rung, Rung::factorization) << problem.name;
  }
}

// The unknowns of soft nodes with more constraints than rows drown in rounding: no rows depend, and nothing contradicts.
TEST(RobustSolver, RowsThatOnlyRoundingMakesDependentContradictNothing) {
  const Problem problem = families::make_problem({.family = families::Family::ladder, .n = 100, .difficulty = families::Difficulty::wide_diagonals});
  RobustSolver solver = loaded(problem, {});
  ASSERT_GT(solver.factorize().dropped_rows, 0);
  Eigen::VectorXd x(problem.right.size());
  const auto report = solver.solve(view(problem.right), view(x));
  EXPECT_EQ(report.status, Status::solved) << report.why;
  EXPECT_EQ(report.rung, Rung::threshold_pivoting) << report.why;
}

TEST(RobustSolver, ABlockWithoutPivotIsSaidAndSolvedInAnotherOrder) {
  RobustSolver solver(pair_graph());
  fill(solver, 0, 1, 1, 3);  // one of the two orders divides by zero
  if (solver.symbolic().node(0) == NodeId{1}) fill(solver, 3, 1, 1, 0);
  const std::vector<double> b{1, 2};
  std::vector<double> x(2);
  const auto report = solver.solve(b, x);
  ASSERT_EQ(report.status, Status::solved) << report.why;
  EXPECT_EQ(report.rung, Rung::reordered);
  EXPECT_NE(report.why.find("has no usable pivot"), std::string::npos) << report.why;
  EXPECT_LE(report.backward_error, 1e-15);
}

TEST(RobustSolver, WhatNoOrderCanDoIsDoneByThresholdPivotingOrTheGivenSolver) {
  const std::vector<double> b{1, 2};
  std::vector<double> x(2);
  RobustSolver solver(pair_graph());
  fill(solver, 0, 1, 1, 0);
  const auto report = solver.solve(b, x);
  ASSERT_EQ(report.status, Status::solved) << report.why;
  EXPECT_EQ(report.rung, Rung::threshold_pivoting);
  EXPECT_EQ(x, (std::vector<double>{2, 1}));

  int calls = 0;
  RobustSolver injected(pair_graph(), {.fallback = [&](const RobustSolver::Matrix& a, std::span<const double> r, std::span<double> y) {
                          ++calls;
                          EXPECT_EQ(a.rows, 2);
                          y[0] = r[1], y[1] = r[0];
                          return true;
                        }});
  fill(injected, 0, 1, 1, 0);
  ASSERT_EQ(injected.solve(b, x).status, Status::solved);
  EXPECT_GE(calls, 1);
}

TEST(RobustSolver, ValuesThatChangedAreSolvedWithAlsoWhereNobodyFactoredThem) {
  RobustSolver solver(pair_graph());
  const std::vector<double> b{4, 8};
  std::vector<double> x(2);
  fill(solver, 2, 0, 0, 2);
  ASSERT_EQ(solver.solve(b, x).status, Status::solved);
  EXPECT_EQ(x, (std::vector<double>{2, 4}));
  fill(solver, 4, 0, 0, 1);
  ASSERT_EQ(solver.solve(b, x).status, Status::solved);
  EXPECT_EQ(x, (std::vector<double>{1, 8}));
}

TEST(RobustSolver, ASingularSystemLeavesXAndNamesTheBlock) {
  RobustSolver solver(pair_graph());
  fill(solver, 1, 2, 2, 4);
  const std::vector<double> b{1, 0};
  std::vector<double> x{7, 8};
  const auto report = solver.solve(b, x);
  EXPECT_EQ(report.status, Status::singular);
  EXPECT_EQ(x, (std::vector<double>{7, 8}));
  EXPECT_NE(report.why.find("block '"), std::string::npos) << report.why;
  EXPECT_NE(report.why.find("the matrix is singular"), std::string::npos) << report.why;
}

TEST(RobustSolver, ContradictingRedundantRowsHaveNoSolutionAndAreNamed) {
  const Problem problem = families::make_problem({.family = families::Family::chain, .n = 20, .difficulty = families::Difficulty::redundant});
  RobustSolver solver = loaded(problem, {});
  ASSERT_GT(solver.factorize().dropped_rows, 0);
  Eigen::VectorXd x(problem.right.size());
  ASSERT_EQ(solver.solve(view(problem.right), view(x)).status, Status::solved);
  Eigen::VectorXd b = problem.right;
  const auto dropped = solver.factorization().dropped_rows()[0];
  b[problem.graph.row(dropped.node) + dropped.row] += 1;
  const auto report = solver.solve(view(std::as_const(b)), view(x));
  EXPECT_EQ(report.status, Status::singular);
  EXPECT_NE(report.why.find("'" + std::string(problem.graph.name(dropped.node)) + "'"), std::string::npos) << report.why;
}

TEST(RobustSolver, NumbersThatAreNoneAreNamed) {
  RobustSolver solver(pair_graph());
  fill(solver, 1, std::numeric_limits<double>::quiet_NaN(), 0, 1);
  const std::vector<double> b{1, 2};
  std::vector<double> x(2);
  const auto report = solver.solve(b, x);
  EXPECT_EQ(report.status, Status::not_finite);
  EXPECT_EQ(report.why, "entry (0, 0) of block ('left', 'right') is nan");
  fill(solver, 1, 0, 0, 1);
  solver.factorize();
  const std::vector<double> bad{1, std::numeric_limits<double>::infinity()};
  EXPECT_EQ(solver.solve(bad, x).why, "right-hand side 0 of 'right' is inf");
}

/// One equation a x = b.
RobustSolver::Report of_numbers(double a, double b, double acceptable = 1e-12) {
  BlockGraph graph;
  const NodeId node = graph.add_node("only", 1);
  RobustSolver solver(graph, {.acceptable = acceptable});
  solver.entry(solver.symbolic().block(node, node)) = a;
  double x = 7;
  const auto report = solver.solve({&b, 1}, {&x, 1});
  EXPECT_EQ(x == 7, report.status != Status::solved);
  return report;
}

TEST(RobustSolver, NumbersOutOfTheRangeOfDoublesMakeNoMatrixSingular) {
  const auto large = of_numbers(1e-200, 1e200), small = of_numbers(1e200, 1e-200);
  EXPECT_EQ(large.status, Status::not_finite) << large.why;
  EXPECT_NE(large.why.find("the matrix is not singular, numbers on the way to the solution are too large"), std::string::npos) << large.why;
  EXPECT_EQ(small.status, Status::stalled) << small.why;
  EXPECT_NE(small.why.find("the matrix is not singular, its solution is too small"), std::string::npos) << small.why;
  EXPECT_EQ(of_numbers(1e-200, 1e-200).status, Status::solved);
}

TEST(RobustSolver, WhatIsNotAccurateEnoughIsStalledAndNotSingular) {
  const auto report = of_numbers(3, 1, -1);
  EXPECT_EQ(report.status, Status::stalled);
  EXPECT_TRUE(report.why.ends_with("; the matrix is not singular")) << report.why;
  RobustSolver given(pair_graph(), {.fallback = [](const RobustSolver::Matrix&, std::span<const double>, std::span<double>) { return false; }});
  fill(given, 0, 1, 1, 0);
  const std::vector<double> b{1, 2};
  std::vector<double> x(2);
  const auto failed = given.solve(b, x);
  EXPECT_EQ(failed.status, Status::stalled);
  EXPECT_NE(failed.why.find("the given solver failed; the matrix is not singular"), std::string::npos) << failed.why;
  EXPECT_EQ(failed.backward_error, std::numeric_limits<double>::infinity());
}

TEST(RobustSolver, NumbersThatAreNoneFromTheGivenSolverAreItsOwnFault) {
  for (const double returned : {std::nan(""), 1e308}) {
    RobustSolver solver(pair_graph(), {.fallback = [&](const RobustSolver::Matrix&, std::span<const double>, std::span<double> x) {
                          std::ranges::fill(x, returned);
                          return true;
                        }});
    fill(solver, 0, 10, 10, 0);
    const std::vector<double> b{1, 2};
    std::vector<double> x{7, 7};
    const auto report = solver.solve(b, x);
    EXPECT_EQ(report.status, Status::stalled) << report.why;
    const std::string said = std::isnan(returned) ? "numbers that are not finite" : "numbers too large to be checked";
    EXPECT_NE(report.why.find("the given solver returned " + said + "; the matrix is not singular"), std::string::npos) << report.why;
    EXPECT_EQ(report.backward_error, std::numeric_limits<double>::infinity());
    EXPECT_EQ(x, (std::vector<double>{7, 7}));
  }
}

TEST(RobustSolver, WithoutASolutionTheBackwardErrorIsNotThatOfAPerfectOne) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  RobustSolver solver(pair_graph());
  std::vector<double> x(2);
  fill(solver, 1, 0, 0, 1);
  EXPECT_EQ(solver.solve(std::vector{infinity, 1.0}, x).backward_error, infinity);
  fill(solver, infinity, 0, 0, 1);
  EXPECT_EQ(solver.solve(std::vector{1.0, 1.0}, x).backward_error, infinity);
}

TEST(RobustSolver, NothingIsSolvedByNothing) {
  RobustSolver solver{BlockGraph()};
  const auto report = solver.solve({}, {});
  EXPECT_EQ(report.status, Status::solved) << report.why;
  EXPECT_EQ(solver.solve_transposed({}, {}, 3).status, Status::solved);
  EXPECT_TRUE(report.outcome.ok());
}

}  // namespace test_robust_solver
