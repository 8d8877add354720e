#include "graphsolve/factorization.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <memory>

#include "factorization_cases.hpp"
#include "support/dense.hpp"

namespace test_factorization {

using namespace graphsolve;
using cases::relative;
using cases::right_hand_side;
using cases::view;

std::vector<Ordering> orderings(const BlockGraph& graph) {
  return {natural_ordering(graph), depth_first_ordering(graph), minimum_fill_ordering(graph)};
}

TEST(Factorization, SolvesAndSolvesTransposedLikeDenseEigenOnEveryFamilyAndOrder) {
  for (const auto& [name, graph] : cases::all())
    for (const bool saddle : {true, false}) {
      const Eigen::MatrixXd a = saddle ? families::saddle_matrix(graph, 7) : families::dominant_matrix(graph, 7);
      const Eigen::VectorXd b = right_hand_side(a.rows());
      const Eigen::VectorXd expected = dense::solve(a, b), transposed = dense::solve(a.transpose(), b);
      for (const Ordering& ordering : orderings(graph)) {
        Factorization f(std::make_shared<const Symbolic>(graph, ordering));
        families::load(a, graph, f.symbolic(), f.values());
        const auto outcome = f.factorize();
        ASSERT_TRUE(outcome.ok()) << name;
        ASSERT_EQ(outcome.dropped_rows, 0) << name;
        Eigen::VectorXd x = b, y = b;
        f.solve(view(x));
        f.solve_transposed(view(y));
        EXPECT_LE(relative(x, expected), 1e-9) << name;
        EXPECT_LE(relative(y, transposed), 1e-9) << name;
      }
    }
}

TEST(Factorization, RefinementReachesComponentwiseBackwardErrorNearRounding) {
  for (const auto& [name, graph] : cases::all()) {
    const Eigen::MatrixXd a = families::saddle_matrix(graph, 11);
    const Eigen::VectorXd b = right_hand_side(a.rows());
    Factorization f(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)));
    f.allow_refinement();
    f.keep_matrix(true);
    families::load(a, graph, f.symbolic(), f.values());
    ASSERT_TRUE(f.factorize().ok());
    Eigen::VectorXd x = b;
    f.solve(view(x));
    const auto refined = f.refine(view(b), view(x));
    const Eigen::VectorXd scale = a.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs();
    const double error = ((a * x - b).cwiseAbs().array() / scale.array()).maxCoeff();
    EXPECT_LE(refined.backward_error, 1e-15) << name;
    EXPECT_LE(error, 4e-16 * static_cast<double>(a.rows())) << name;  // measured here, not by the solver
  }
}

TEST(Factorization, BackwardErrorIsNaNWhereverTheRightHandSideHoldsANaN) {
  const BlockGraph graph = families::chain(3);
  const Eigen::MatrixXd a = families::saddle_matrix(graph, 11);
  Factorization f(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)));
  f.allow_refinement();
  f.keep_matrix(true);
  families::load(a, graph, f.symbolic(), f.values());
  ASSERT_TRUE(f.factorize().ok());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    Eigen::VectorXd b = right_hand_side(a.rows()), x = b;
    f.solve(view(x));
    b[i] = NAN;
    EXPECT_TRUE(std::isnan(f.refine(view(b), view(x)).backward_error)) << i;
  }
}

TEST(Factorization, ComponentsAreIndependent) {
  BlockGraph graph;
  for (const char* name : {"a", "b"}) {
    const NodeId first = graph.add_node(name, 2), second = graph.add_node(name, 3);
    graph.add_edge(first, second);
  }
  const Eigen::MatrixXd a = families::dominant_matrix(graph, 3);
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)));
  ASSERT_EQ(f.symbolic().components(), 2);
  families::load(a, graph, f.symbolic(), f.values());
  ASSERT_TRUE(f.factorize(1).ok());
  Eigen::VectorXd x = right_hand_side(a.rows());
  const Eigen::VectorXd b = x;
  f.solve_component(view(x), 1);
  EXPECT_EQ(x.head(5), b.head(5)) << "component 0 was touched";
  EXPECT_LE(relative(x.tail(5), a.bottomRightCorner(5, 5).lu().solve(b.tail(5))), 1e-12);
}

TEST(Factorization, DependentRowsAreLeftOutAndTheirGroupIsNamed) {
  // Two nodes linked three times by one row each: the third link repeats the sum of the first two.
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 3), b = graph.add_node("b", 3);
  std::vector<NodeId> links;
  for (int k = 0; k < 4; ++k) {
    links.push_back(graph.add_node("link " + std::to_string(k), 1, NodeKind::saddle));
    graph.add_edge(links[k], a, EdgeRank::full_row);
    graph.add_edge(links[k], b, EdgeRank::full_row);
  }
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(10, 10);
  f.topLeftCorner(6, 6).setIdentity();
  Eigen::MatrixXd j(4, 6);
  j << 1, 2, 0, -1, 0, 1, 0, 1, 1, 2, -1, 0, 1, 3, 1, 1, -1, 1, 0, 0, 1, 0, 1, 2;
  f.bottomLeftCorner(4, 6) = j;
  f.topRightCorner(6, 4) = -j.transpose();
  Factorization factor(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)));
  families::load(f, graph, factor.symbolic(), factor.values());
  const auto outcome = factor.factorize();
  ASSERT_TRUE(outcome.ok());
  ASSERT_EQ(outcome.dropped_rows, 1);
  Eigen::VectorXd y(10);
  factor.dependency(factor.dropped_rows()[0], {y.data(), 10});
  EXPECT_LE((y.transpose() * f).cwiseAbs().maxCoeff(), 1e-12 * y.cwiseAbs().maxCoeff());
  y /= y[6];
  EXPECT_NEAR(y[7], 1, 1e-9);
  EXPECT_NEAR(y[8], -1, 1e-9);
  EXPECT_NEAR(y[9], 0, 1e-9);

  // A consistent right-hand side is solved in spite of the dependency.
  Eigen::VectorXd x = f * right_hand_side(10), rhs = x;
  factor.solve({x.data(), 10});
  EXPECT_LE((f * x - rhs).norm(), 1e-12 * rhs.norm());
}

TEST(Factorization, SingularRegularBlockIsReportedAtItsPivot) {
  BlockGraph graph;
  const NodeId good = graph.add_node("good", 2), bad = graph.add_node("bad", 2);
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(4, 4);
  a.bottomRightCorner(2, 2) << 1, 2, 2, 4;
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)));
  families::load(a, graph, f.symbolic(), f.values());
  const auto outcome = f.factorize();
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(f.symbolic().node(outcome.first_bad_pivot), bad);
  EXPECT_NE(good, bad);
}

TEST(Factorization, RefinementWithoutAKeptMatrixIsRefused) {
  BlockGraph graph;
  graph.add_node("x", 1);
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)));
  f.values()[0] = 2;
  ASSERT_TRUE(f.factorize().ok());
  const double b[] = {1};
  double x[] = {0.5};
  EXPECT_THROW((void)f.refine(b, x), std::logic_error);
}

TEST(Factorization, NotANumberIsReportedAtItsPivot) {
  const BlockGraph graph = families::chain(3);
  Eigen::MatrixXd a = families::saddle_matrix(graph, 5);
  a(6, 7) = std::numeric_limits<double>::quiet_NaN();
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)));
  families::load(a, graph, f.symbolic(), f.values());
  const auto outcome = f.factorize();
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(f.symbolic().node(outcome.first_bad_pivot), NodeId{1});
}

}  // namespace test_factorization
