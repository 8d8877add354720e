#include "graphsolve/diagnosis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/robust_solver.hpp"
#include "pair_of_nodes.hpp"
#include "support/problem_families.hpp"

namespace test_diagnosis {

using namespace graphsolve;
using cases::pair_graph;
using families::Problem;

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
  RobustSolver solver(problem.graph);
  families::load(problem.matrix, problem.graph, solver.symbolic(), solver.values());
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

}  // namespace test_diagnosis
