#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "factorization_cases.hpp"
#include "support/dense.hpp"
#include "support/problem_families.hpp"

namespace test_problem_families {

using namespace families;
using cases::view;

std::vector<Spec> specs(int n) {
  std::vector<Spec> list;
  for (const Family family : all_families())
    for (const Difficulty difficulty : all_difficulties())
      for (const Leaves leaves : {Leaves::none, Leaves::one_each})
        for (const Values values : {Values::symmetric, Values::unsymmetric})
          list.push_back({.family = family, .n = n, .leaves = leaves, .difficulty = difficulty, .values = values});
  return list;
}

TEST(ProblemFamilies, EveryEntryLiesInABlockOfTheGraphAndEqualSpecsGiveEqualBits) {
  for (const Spec& spec : specs(9)) {
    const Problem problem = make_problem(spec), again = make_problem(spec);
    const graphsolve::Symbolic symbolic(problem.graph, graphsolve::natural_ordering(problem.graph));
    std::vector<double> values(symbolic.values_size());
    load(problem.matrix, problem.graph, symbolic, values);  // throws where there is no block
    EXPECT_EQ((problem.matrix - again.matrix).norm(), 0) << problem.name;
    EXPECT_EQ(problem.right, again.right) << problem.name;
    EXPECT_LE(backward_error(problem.matrix, view(problem.solution), view(problem.right)), 1e-15) << problem.name;
  }
}

TEST(ProblemFamilies, SymmetricMeansSymmetricAndUnsymmetricIsMonotoneButForTheCoupling) {
  for (const Spec& spec : specs(9)) {
    const Problem problem = make_problem(spec);
    const Eigen::MatrixXd a = problem.matrix;
    EXPECT_EQ((a - a.transpose()).norm() == 0, spec.values == Values::symmetric) << problem.name;
    if (spec.difficulty != Difficulty::plain) continue;
    for (int i = 0; i < problem.graph.size(); ++i) {
      const int row = problem.graph.row({i}), d = problem.graph.dimension({i});
      const Eigen::MatrixXd block = a.block(row, row, d, d);
      const double lowest = dense::eigenvalues(block + block.transpose())[0];
      EXPECT_TRUE(problem.graph.kind({i}) == graphsolve::NodeKind::saddle || lowest > 0) << problem.name;
    }
  }
}

TEST(ProblemFamilies, RedundantRowsMakeTheMatrixSingularAndTheOthersAreRegular) {
  for (const Spec& spec : specs(9)) {
    if (spec.difficulty == Difficulty::wide_diagonals || spec.difficulty == Difficulty::mass_ratio) continue;
    const Problem problem = make_problem(spec);
    const Eigen::Index rank = dense::rank(problem.matrix, 1e-11);
    EXPECT_EQ(rank < problem.matrix.rows(), spec.difficulty == Difficulty::redundant) << problem.name;
  }
}

TEST(ProblemFamilies, TheDefaultOrderingKeepsTheBarsOfFill) {
  const auto fill = [](Family family, int n) {
    const Problem problem = make_problem({.family = family, .n = n});
    return fill_factor(graphsolve::Symbolic(problem.graph, graphsolve::minimum_fill_ordering(problem.graph)));
  };
  for (const Family family : {Family::chain, Family::tree, Family::quadruped}) EXPECT_EQ(fill(family, 1000), 1.0);
  EXPECT_EQ(fill(Family::control, 100), 1.0);
  EXPECT_LE(fill(Family::loop, 1000), 1.30);
  EXPECT_LE(fill(Family::ladder, 1000), 1.45);
  EXPECT_LE(fill(Family::grid, 1000), 3.5);
}

TEST(ProblemFamilies, RepeatedSystemsAreDisjointAndEqual) {
  const Problem one = make_problem({.family = Family::ladder, .n = 8}), eight = repeated(one, 8);
  EXPECT_EQ(graphsolve::connected_components(eight.graph).count, 8);
  ASSERT_EQ(eight.matrix.rows(), 8 * one.matrix.rows());
  EXPECT_EQ(eight.matrix.nonZeros(), 8 * one.matrix.nonZeros());
  EXPECT_LE(backward_error(eight.matrix, view(eight.solution), view(eight.right)), 1e-15);
}

TEST(ProblemFamilies, BackwardErrorOfAWrongOrMissingNumberIsSeen) {
  const Problem problem = make_problem({.family = Family::chain, .n = 5});
  Eigen::VectorXd x = problem.solution;
  x[3] += 1e-9;
  EXPECT_GT(backward_error(problem.matrix, view(x), view(problem.right)), 1e-12);
  x[3] = NAN;
  EXPECT_TRUE(std::isnan(backward_error(problem.matrix, view(x), view(problem.right))));
}

}  // namespace test_problem_families
