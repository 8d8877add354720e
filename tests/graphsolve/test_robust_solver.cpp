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
}

TEST(RobustSolver, NothingIsSolvedByNothing) {
  RobustSolver solver{BlockGraph()};
  const auto report = solver.solve({}, {});
  EXPECT_EQ(report.status, Status::solved) << report.why;
  EXPECT_EQ(solver.solve_transposed({}, {}, 3).status, Status::solved);
  EXPECT_TRUE(report.outcome.ok());
}

Diagnosis of_matrix(const BlockGraph& graph, const Eigen::Matrix2d& a, FactorizationKind kind = FactorizationKind::ldu) {
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)), kind);
  f.allow_refinement();
  f.keep_matrix(true);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) f.entry(f.symbolic().block({i}, {j})) = a(i, j);
  return diagnose(graph, f, f.factorize());
}

TEST(Diagnosis, NamesTheBlockThatFailedItsNeighboursAndTheNearNullVector) {
  const Diagnosis d = of_matrix(pair_graph(), (Eigen::Matrix2d() << 1, 2, 2, 4).finished());
  EXPECT_EQ(d.failed, "right");
  EXPECT_EQ(d.failed_neighbours, std::vector<std::string>{"left"});
  EXPECT_EQ(d.structural_rank, 2);
  EXPECT_LE(d.smallest_singular, 1e-12);
  ASSERT_EQ(d.near_null.size(), 2u);  // (2, -1)
  EXPECT_EQ(d.near_null[0].node, "left");
  EXPECT_NEAR(d.near_null[0].share, 0.8, 1e-6);
  EXPECT_NE(to_string(d).find("the elimination ended at block 'right', neighbour of 'left'"), std::string::npos) << to_string(d);
}

TEST(Diagnosis, CountsStructuralRankZeroRowsAndSigns) {
  const Diagnosis empty_row = of_matrix(pair_graph(), (Eigen::Matrix2d() << 1, 2, 0, 0).finished());
  EXPECT_EQ(empty_row.structural_rank, 1);
  ASSERT_EQ(empty_row.zero_rows.size(), 1u);
  EXPECT_EQ(empty_row.zero_rows[0].node, "right");
  EXPECT_NE(to_string(empty_row).find("row 0 of 'right' has no entry"), std::string::npos);
  const Diagnosis swapped = of_matrix(pair_graph(), (Eigen::Matrix2d() << 0, 1, 1, 3).finished());
  EXPECT_EQ(swapped.structural_rank, 2);  // by an augmenting path
  const Diagnosis signs = of_matrix(pair_graph(), (Eigen::Matrix2d() << 2, 1, 1, -3).finished(), FactorizationKind::ldlt);
  EXPECT_EQ(signs.inertia, (Inertia{1, 1, 0}));
}

TEST(Diagnosis, SignsOfBoostedPivotsAreNotKnown) {
  BlockGraph graph;
  graph.add_node("good", 2);
  graph.add_node("flat", 2);
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)), FactorizationKind::ldlt);
  f.allow_refinement();
  f.keep_matrix(true);
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(4, 4);
  a.bottomRightCorner(2, 2) << 1, 2, 2, 4;
  families::load(a, graph, f.symbolic(), f.values());
  const Diagnosis d = diagnose(graph, f, f.factorize());
  EXPECT_EQ(d.boosts, 1);
  EXPECT_NE(to_string(d).find("inertia: at least 3 positive, at least 0 negative, 0 zero, 1 not known"), std::string::npos)
      << to_string(d);
  const Diagnosis regular = of_matrix(pair_graph(), (Eigen::Matrix2d() << 2, 1, 1, -3).finished(), FactorizationKind::ldlt);
  EXPECT_NE(to_string(regular).find("inertia: 1 positive, 1 negative, 0 zero\n"), std::string::npos) << to_string(regular);
}

TEST(Diagnosis, NamesEntriesThatAreNotNumbersAndNothingElse) {
  const Diagnosis d = of_matrix(pair_graph(), (Eigen::Matrix2d() << 1, 2, std::numeric_limits<double>::infinity(), 4).finished());
  ASSERT_EQ(d.not_finite.size(), 1u);
  EXPECT_EQ(to_string(d), "entry (0, 0) of block ('right', 'left') is inf\n");
}

TEST(Diagnosis, GroupsRedundantRowsByName) {
  const Problem problem = families::make_problem({.family = families::Family::chain, .n = 20, .difficulty = families::Difficulty::redundant});
  RobustSolver solver = loaded(problem, {});
  const auto outcome = solver.factorize();
  const Diagnosis d = diagnose(problem.graph, solver.factorization(), outcome);
  int rows = 0;
  for (const auto& group : d.redundant) {
    EXPECT_GE(group.nodes.size(), 2u);
    rows += group.redundant_rows;
  }
  EXPECT_EQ(rows, outcome.dropped_rows);
  EXPECT_GT(rows, 0);
  EXPECT_NE(to_string(d).find("too many among"), std::string::npos) << to_string(d);
}

TEST(Diagnosis, NamesRedundantRowsOfAProblemOfTheInteriorPoint) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 2), first = graph.add_node("first", 1, NodeKind::saddle);
  const NodeId second = graph.add_node("second", 1, NodeKind::saddle);
  QuadraticCost cost;
  cost.add_diagonal(a, std::vector<double>{1, 1});
  LinearConstraint sum;
  for (const NodeId row : {first, second}) sum.add(row, std::vector<LinearConstraint::Part>{{a, {1, 1}}}, std::vector<double>{1});
  graphsolve::Problem problem(graph);
  problem.add(cost);
  problem.add(sum);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
  std::vector<double> x(4, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  const Factorization::Outcome outcome = solver.factorize_terms(x);
  EXPECT_EQ(outcome.dropped_rows, 1);
  const Diagnosis d = diagnose(problem.graph(), solver.factorization(), outcome);
  ASSERT_EQ(d.redundant.size(), 1u);
  EXPECT_EQ(d.redundant[0].redundant_rows, 1);
  EXPECT_NE(std::ranges::find(d.redundant[0].nodes, "second"), d.redundant[0].nodes.end());
  ASSERT_EQ(solver.solve(x), Status::solved) << "it goes on as before";
}

}  // namespace test_robust_solver
