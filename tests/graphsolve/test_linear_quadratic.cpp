#include "graphsolve/linear_quadratic.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "graphsolve/bound.hpp"
#include "graphsolve/derivative_check.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/nonnegative.hpp"
#include "support/dense.hpp"

namespace test_linear_quadratic {

using namespace graphsolve;

/// Nodes of 2 and 3 unknowns under one cost and one constraint of 2 rows, one more cost on the second node alone.
struct SmallProgram {
  SmallProgram() {
    const NodeId a = graph.add_node("a", 2), b = graph.add_node("b", 3);
    const NodeId row = graph.add_node("row", 2, NodeKind::saddle);
    std::mt19937_64 random(7);
    const auto draw = [&](int rows, int columns) {
      return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return static_cast<double>(random()) * 0x1p-63 - 1; }).eval();
    };
    const Eigen::MatrixXd m = draw(5, 5);
    h = m * m.transpose() + Eigen::MatrixXd::Identity(5, 5);
    c = draw(5, 1);
    j = draw(2, 5);
    r = draw(2, 1);
    const NodeId both[] = {a, b};
    cost.add(both, {h.data(), 25}, {c.data(), 5});
    cost.add_diagonal(b, weight, slope);
    const double* column = j.data();
    const LinearConstraint::Part parts[] = {{a, {column, column + 4}}, {b, {column + 4, column + 10}}};
    constraint.add(row, parts, {r.data(), 2});
  }
  BlockGraph graph;
  Eigen::MatrixXd h, j;
  Eigen::VectorXd c, r;
  std::vector<double> weight{1, 2, 3}, slope{0.5, 0, -0.5};
  QuadraticCost cost;
  LinearConstraint constraint;
};

TEST(LinearQuadratic, SolutionIsThatOfTheDenseOptimalitySystem) {
  SmallProgram p;
  Problem problem(p.graph);
  problem.add(p.cost);
  problem.add(p.constraint);
  InteriorPoint solver(problem,
                       std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
  std::vector<double> x(7, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(7, 7);
  matrix.topLeftCorner(5, 5) = p.h;
  for (int k = 0; k < 3; ++k) matrix(2 + k, 2 + k) += p.weight[k];
  matrix.topRightCorner(5, 2) = -p.j.transpose();
  matrix.bottomLeftCorner(2, 5) = p.j;
  Eigen::VectorXd rhs(7);
  rhs << -p.c, p.r;
  for (int k = 0; k < 3; ++k) rhs[2 + k] -= p.slope[k];
  const Eigen::VectorXd expected = dense::solve(matrix, rhs);
  for (int k = 0; k < 7; ++k) EXPECT_NEAR(x[k], expected[k], 1e-10) << k;
}

TEST(LinearQuadratic, DerivativesAreThoseOfTheResiduals) {
  SmallProgram p;
  Problem problem(p.graph);
  problem.add(p.cost);
  problem.add(p.constraint);
  const std::vector<double> x{0.3, -0.2, 0.7, 0.1, -0.9, 0.4, 0.6};
  const DerivativeReport report = check_terms(problem, x);
  EXPECT_LE(report.largest_error, 1e-8) << report.where;
}

/// |x|^2 - 6 x_0 + 4 x_1 with x_0 <= 1 and x_1 >= -inf, x_1 <= inf.
TEST(LinearQuadratic, AnInfiniteLimitIsNoBound) {
  using Limits = std::numeric_limits<double>;
  for (const auto& [scale, infinity] :
       {std::pair{1.0, Limits::infinity()}, {100.0, Limits::infinity()}, {1.0, Limits::max()}}) {
    BlockGraph graph;
    const NodeId x = graph.add_node("x", 2);
    Problem problem(graph);
    QuadraticCost cost;
    cost.add_diagonal(x, std::vector<double>{2, 2}, std::vector<double>{-6, 4});
    problem.add(cost);
    PortLawBatch<Bound, Nonnegative> bounds;
    bounds.add(Bound(x, 0, Bound::Side::upper, 1), Nonnegative(scale));
    bounds.add(Bound(x, 1, Bound::Side::lower, -infinity), Nonnegative(scale));
    bounds.add(Bound(x, 1, Bound::Side::upper, infinity), Nonnegative(scale));
    problem.add(bounds);
    InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
    std::vector<double> at{0, 0};
    ASSERT_EQ(solver.solve(at), Status::solved);
    EXPECT_EQ(solver.reports()[0].attempts, 1);
    EXPECT_NEAR(at[0], 1, 1e-8);
    EXPECT_NEAR(at[1], -2, 1e-8);
    EXPECT_NEAR(bounds.law(0).force(), 4, 1e-7);
    for (const int free : {1, 2}) EXPECT_LE(bounds.law(free).force(), 1e-15 * scale);
  }
}

/// h/2 x^2 + c x with x >= 0; `upper` < 0: and no x at all.
struct OneVariable {
  QuadraticCost cost;
  PortLawBatch<Bound, Nonnegative> bounds;
  std::vector<double> x{0};
  Status status;
  ComponentReport report;
  OneVariable(double h, double c, double scale, double upper = std::numeric_limits<double>::infinity()) {
    BlockGraph graph;
    const NodeId node = graph.add_node("x", 1);
    Problem problem(graph);
    cost.add_diagonal(node, std::vector<double>{h}, std::vector<double>{c});
    problem.add(cost);
    bounds.add(Bound(node, 0, Bound::Side::lower, 0), Nonnegative(scale));
    bounds.add(Bound(node, 0, Bound::Side::upper, upper), Nonnegative(scale));
    problem.add(bounds);
    InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
    status = solver.solve(x);
    report = solver.reports()[0];
  }
};

TEST(LinearQuadratic, AScaleOfTheLawFarFromTheDiagonalCostsIterationsButNotTheSolution) {
  for (const double h : {1e-3, 1.0, 1e6})
    for (const double off : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6})
      for (const double c : {-1000.0, -1.0, 1e-3, 1.0, 1000.0}) {
        const OneVariable one(h, h * c, h * off);
        ASSERT_EQ(one.status, Status::solved) << h << " " << off << " " << c;
        EXPECT_NEAR(one.x[0], std::max(0.0, -c), 1e-6 * std::max(1.0, -c)) << h << " " << off << " " << c;
        EXPECT_NEAR(one.bounds.law(0).force() / h, std::max(0.0, c), 1e-6 * std::max(1.0, c))
            << h << " " << off << " " << c;
      }
}

TEST(LinearQuadratic, WhatHasNoSolutionEndsInAnyScale) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const OneVariable none(1, 1, scale, -1);
    EXPECT_NE(none.status, Status::solved);
    EXPECT_LE(none.report.attempts, 6);
    EXPECT_EQ(none.x[0], 0);
  }
}

TEST(LinearQuadratic, WrongLengthsAreNamed) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 2), row = graph.add_node("row", 1, NodeKind::saddle);
  graph.add_edge(a, row);
  const Symbolic symbolic(graph, natural_ordering(graph));
  const Wiring wiring(symbolic, graph);
  const auto message = [&](Term& term) -> std::string {
    try {
      term.wire(wiring);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  QuadraticCost cost;
  cost.add_diagonal(a, std::vector<double>{1, 2, 3});
  EXPECT_EQ(message(cost), "hessian of quadratic cost 0: 3 entries where 2 are needed");
  QuadraticCost lopsided;
  lopsided.add(std::vector{a}, std::vector<double>{1, 5, 0, 1});
  EXPECT_EQ(message(lopsided),
            "hessian of quadratic cost 0 is not symmetric: entry (1, 0) is 5.000000, its mirror image 0.000000");
  QuadraticCost tilted;
  tilted.add_diagonal(a, std::vector<double>{1, 2}, std::vector<double>{1});
  EXPECT_EQ(message(tilted), "gradient of quadratic cost 0: 1 entries where 2 are needed");
  LinearConstraint constraint;
  constraint.add(row, std::vector<LinearConstraint::Part>{{a, {1, 2, 3}}}, std::vector<double>{0});
  EXPECT_EQ(message(constraint), "matrix of constraint 0: 3 entries where 2 are needed");
  LinearConstraint sides;
  sides.add(row, std::vector<LinearConstraint::Part>{{a, {1, 2}}}, std::vector<double>{0, 0});
  EXPECT_EQ(message(sides), "right-hand side of constraint 0: 2 entries where 1 are needed");
}

}  // namespace test_linear_quadratic
