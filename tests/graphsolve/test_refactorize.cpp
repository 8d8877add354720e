#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "support/problem_families.hpp"

namespace test_refactorize {

using namespace graphsolve;
using families::Problem;

std::vector<Problem> problems(families::Values values) {
  std::vector<Problem> list;
  for (const auto family : families::all_families())
    for (const auto difficulty : {families::Difficulty::plain, families::Difficulty::redundant})
      list.push_back(families::make_problem({.family = family, .n = 40, .difficulty = difficulty, .values = values}));
  return list;
}

std::unique_ptr<Factorization> prepared(const Problem& problem, FactorizationKind kind) {
  auto f = std::make_unique<Factorization>(
      std::make_shared<const Symbolic>(problem.graph, minimum_fill_ordering(problem.graph)), kind);
  f->allow_refactorization();
  f->keep_matrix(true);
  families::load(problem.matrix, problem.graph, f->symbolic(), f->values());
  return f;
}

/// Ancestors of the nodes in the elimination tree, themselves included.
int ancestors(const Symbolic& s, const std::vector<NodeId>& nodes) {
  std::vector<char> seen(s.pivots());
  int count = 0;
  for (const NodeId node : nodes)
    for (int k = s.position(node); k >= 0 && !seen[k]; k = s.parent(k)) seen[k] = 1, ++count;
  return count;
}

TEST(Refactorize, GivesTheBitsOfAWholeFactorizationAndRedoesAncestorsOnly) {
  std::mt19937_64 random(4);
  for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
    const bool ldu = kind == FactorizationKind::ldu;
    for (const Problem& problem : problems(ldu ? families::Values::unsymmetric : families::Values::symmetric)) {
      auto partial = prepared(problem, kind);
      ASSERT_TRUE(partial->factorize().ok()) << problem.name;
      Problem changed = problem;
      for (int round = 0; round < 5; ++round) {
        std::vector<NodeId> nodes;  // one to three regular nodes get another diagonal block
        for (int k = 0; k <= round % 3; ++k) {
          const NodeId node{static_cast<int>(random() % static_cast<unsigned>(problem.graph.size()))};
          if (problem.graph.kind(node) != NodeKind::regular || std::find(nodes.begin(), nodes.end(), node) != nodes.end()) continue;
          nodes.push_back(node);
          for (int i = problem.graph.row(node); i < problem.graph.row(node) + problem.graph.dimension(node); ++i)
            changed.matrix.coeffRef(i, i) *= 1.5;
          const BlockHandle handle = partial->symbolic().block(node, node);
          for (int i = 0; i < handle.rows; ++i) partial->kept_entry(handle, i, i) *= 1.5;
        }
        auto whole = prepared(changed, kind);
        const auto expected = whole->factorize();
        const auto outcome = partial->refactorize(nodes);
        ASSERT_TRUE(outcome.ok()) << problem.name;
        EXPECT_TRUE(std::ranges::equal(partial->values(), whole->values())) << problem.name << " round " << round;
        EXPECT_EQ(outcome.pivots, ancestors(partial->symbolic(), nodes)) << problem.name;
        EXPECT_LE(outcome.operations, expected.operations) << problem.name;
        EXPECT_EQ(outcome.inertia, expected.inertia) << problem.name;
        EXPECT_EQ(outcome.dropped_rows, expected.dropped_rows) << problem.name;
        EXPECT_EQ(partial->dropped_rows().size(), whole->dropped_rows().size()) << problem.name;
        Eigen::VectorXd x = problem.right, y = problem.right;
        partial->solve({x.data(), static_cast<std::size_t>(x.size())});
        whole->solve({y.data(), static_cast<std::size_t>(y.size())});
        EXPECT_EQ(x, y) << problem.name;
      }
    }
  }
}

/// All nodes couple with each other, in blocks of d x d.
Problem complete(int d, families::Values values) {
  Problem problem;
  problem.name = "complete " + std::to_string(d);
  const int nodes = 21, n = nodes * d;
  for (int i = 0; i < nodes; ++i) problem.graph.add_node("node " + std::to_string(i), d);
  for (int i = 0; i < nodes; ++i)
    for (int j = 0; j < i; ++j) problem.graph.add_edge({i}, {j});
  std::mt19937_64 random(d);
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd m = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
  Eigen::MatrixXd a = m * m.transpose() + n * Eigen::MatrixXd::Identity(n, n);
  if (values == families::Values::unsymmetric) a += m;
  problem.matrix = a.sparseView();
  problem.right = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
  return problem;
}

// A whole factorization takes several pivots of a dense end together; done again they go one by one.
TEST(Refactorize, PivotsTogetherGiveTheBitsAndCountsOfPivotsOneByOne) {
  for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
    const auto values = kind == FactorizationKind::ldu ? families::Values::unsymmetric : families::Values::symmetric;
    std::vector<Problem> list;
    for (int d = 1; d <= 5; ++d) list.push_back(complete(d, values));
    for (const auto difficulty : {families::Difficulty::mass_ratio, families::Difficulty::redundant})
      list.push_back(families::make_problem({.family = families::Family::grid, .n = 144, .difficulty = difficulty, .values = values}));
    for (const Problem& problem : list) {
      auto together = prepared(problem, kind), one_by_one = prepared(problem, kind);
      const auto expected = together->factorize();
      ASSERT_TRUE(expected.ok()) << problem.name;
      ASSERT_TRUE(one_by_one->factorize().ok());
      std::vector<NodeId> all;
      for (int k = 0; k < problem.graph.size(); ++k) all.push_back({k});
      const auto outcome = one_by_one->refactorize(all);
      EXPECT_TRUE(std::ranges::equal(together->values(), one_by_one->values())) << problem.name;
      EXPECT_EQ(outcome.operations, expected.operations) << problem.name;
      EXPECT_EQ(outcome.growth, expected.growth) << problem.name;
      EXPECT_EQ(outcome.dropped_rows, expected.dropped_rows) << problem.name;
      Eigen::VectorXd x = problem.right;
      together->solve({x.data(), static_cast<std::size_t>(x.size())});
      EXPECT_LE((problem.matrix * x - problem.right).norm(), 1e-9 * problem.right.norm()) << problem.name;
    }
  }
}

TEST(Refactorize, ARootOfATreeCostsTheSameWhateverTheSizeOfTheRest) {
  const auto cost = [](int n) {
    const Problem problem = families::make_problem({.family = families::Family::chain, .n = n});
    auto f = prepared(problem, FactorizationKind::ldlt);
    EXPECT_TRUE(f->factorize().ok());
    const NodeId root = f->symbolic().node(f->symbolic().pivots() - 1);
    const auto outcome = f->refactorize({&root, 1});
    EXPECT_EQ(outcome.pivots, 1);
    return outcome.operations;
  };
  EXPECT_EQ(cost(20), cost(400));
}

TEST(Refactorize, AfterAFailureEverythingIsDoneAgain) {
  const Problem problem = families::make_problem({.family = families::Family::chain, .n = 10});
  auto f = prepared(problem, FactorizationKind::cholesky);  // the constraints' own blocks are negative
  ASSERT_FALSE(f->factorize().ok());
  auto g = prepared(problem, FactorizationKind::ldlt);
  ASSERT_TRUE(g->factorize().ok());
  const NodeId node{0};
  const BlockHandle handle = g->symbolic().block(node, node);
  const double before = g->kept_entry(handle);
  g->kept_entry(handle) = std::numeric_limits<double>::quiet_NaN();
  ASSERT_FALSE(g->refactorize({&node, 1}).ok());
  std::vector<double> x(problem.right.begin(), problem.right.end());
  EXPECT_THROW(g->solve(x), std::logic_error) << "there are no factors";
  g->kept_entry(handle) = before;
  const auto outcome = g->refactorize({&node, 1});
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.pivots, problem.graph.size());
  auto whole = prepared(problem, FactorizationKind::ldlt);
  ASSERT_TRUE(whole->factorize().ok());
  EXPECT_TRUE(std::ranges::equal(g->values(), whole->values()));
}

// Diagonals 1e-12 .. 1e12 need the fallback where there are loops: test_robust_solver.cpp.
TEST(Refinement, ReachesTheGoalOnEveryFamilyAndHardVariantForBothKinds) {
  using families::Difficulty;
  for (const auto family : families::all_families())
    for (const auto difficulty : {Difficulty::plain, Difficulty::mass_ratio, Difficulty::redundant, Difficulty::exact_saddle})
      for (const auto leaves : {families::Leaves::none, families::Leaves::one_each})
        for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
          const Problem problem = families::make_problem({.family = family, .n = 60, .leaves = leaves, .difficulty = difficulty});
          auto f = prepared(problem, kind);
          ASSERT_TRUE(f->factorize().ok()) << problem.name;
          Eigen::VectorXd x = problem.right;
          const std::span<double> view{x.data(), static_cast<std::size_t>(x.size())};
          const std::span<const double> b{problem.right.data(), static_cast<std::size_t>(x.size())};
          f->solve(view);
          (void)f->refine(b, view, 10);
          EXPECT_LE(families::backward_error(problem.matrix, view, b), 1e-15) << problem.name << (kind == FactorizationKind::ldu ? " ldu" : " ldlt");
        }
}

/// What set_zero() has written over is no factor to build on: the kept matrix is factored as a whole.
TEST(Refactorize, AfterZeroesFactorsAllOfTheKeptMatrix) {
  for (const Problem& problem : problems(families::Values::symmetric)) {
    auto f = prepared(problem, FactorizationKind::ldlt);
    ASSERT_TRUE(f->factorize().ok()) << problem.name;
    const std::vector<double> factor(f->values().begin(), f->values().end());
    const NodeId last = f->symbolic().node(f->symbolic().pivots() - 1);
    f->set_zero();
    ASSERT_TRUE(f->refactorize({&last, 1}).ok()) << problem.name;
    EXPECT_TRUE(std::ranges::equal(f->values(), factor)) << problem.name;
  }
}

}  // namespace test_refactorize
