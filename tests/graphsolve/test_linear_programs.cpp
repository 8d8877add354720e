#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"

/// Linear programs on a ring: no curvature anywhere. Optimality is proved by duality, which shares nothing with the solver.
namespace test_linear_programs {

using namespace graphsolve;

/// min c'x, one constraint per edge of a ring of nodes of two unknowns each, limits `width` around a point that is feasible.
struct RingProgram {
  static constexpr int d = 2;
  int nodes, n;
  Eigen::VectorXd c, low, high, right;
  Eigen::MatrixXd a;
  BlockGraph graph;
  QuadraticCost cost;
  LinearConstraint constraint;
  PortLawBatch<Bound, Nonnegative> bounds;

  RingProgram(int nodes_count, double width, std::uint64_t seed) : nodes(nodes_count), n(d * nodes) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto draw = [&](int size) { return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); })); };
    c = draw(n);
    const Eigen::VectorXd inside = draw(n);
    low = inside - width * draw(n).cwiseAbs();
    high = inside + width * draw(n).cwiseAbs();
    a = Eigen::MatrixXd::Zero(nodes, n);
    std::vector<NodeId> x, rows;
    for (int i = 0; i < nodes; ++i) x.push_back(graph.add_node("x" + std::to_string(i), d));
    for (int i = 0; i < nodes; ++i) rows.push_back(graph.add_node("row" + std::to_string(i), 1, NodeKind::saddle));
    for (int i = 0; i < nodes; ++i) {
      const int next = (i + 1) % nodes;
      const Eigen::VectorXd own = draw(d), others = draw(d);
      a.row(i).segment(d * i, d) = own;
      a.row(i).segment(d * next, d) = others;
      for (const int k : {i, next}) graph.add_edge(rows[i], x[k], EdgeRank::full);
      const std::array<LinearConstraint::Part, 2> parts{{{x[i], {own.begin(), own.end()}}, {x[next], {others.begin(), others.end()}}}};
      const std::array<double, 1> b{a.row(i).dot(inside)};
      constraint.add(rows[i], parts, b);
    }
    right = a * inside;
    for (int i = 0; i < nodes; ++i) {
      const std::array<NodeId, 1> node{x[i]};
      cost.add(node, {}, {c.data() + d * i, static_cast<std::size_t>(d)});
      for (int k = 0; k < d; ++k) {
        bounds.add(Bound(x[i], k, Bound::Side::lower, low[d * i + k]), Nonnegative());
        bounds.add(Bound(x[i], k, Bound::Side::upper, high[d * i + k]), Nonnegative());
      }
    }
  }
};

/// Feasible on both sides, and both values agree.
void expect_optimal(RingProgram& p, const std::vector<double>& solution, const std::string& which) {
  const Eigen::Map<const Eigen::VectorXd> x(solution.data(), p.n), lambda(solution.data() + p.n, p.nodes);
  Eigen::VectorXd lower(p.n), upper(p.n);
  for (int i = 0; i < p.n; ++i) lower[i] = p.bounds.law(2 * i).force(), upper[i] = p.bounds.law(2 * i + 1).force();
  const double size = 1 + x.lpNorm<Eigen::Infinity>();
  EXPECT_LE((p.a * x - p.right).lpNorm<Eigen::Infinity>(), 1e-7 * size) << which;
  EXPECT_GE((x - p.low).minCoeff(), -1e-7) << which;
  EXPECT_GE((p.high - x).minCoeff(), -1e-7) << which;
  EXPECT_GE(lower.minCoeff(), 0) << which;
  EXPECT_GE(upper.minCoeff(), 0) << which;
  EXPECT_LE((p.c - p.a.transpose() * lambda - lower + upper).lpNorm<Eigen::Infinity>(), 1e-7) << which;
  const double primal = p.c.dot(x), dual = p.right.dot(lambda) + p.low.dot(lower) - p.high.dot(upper);
  EXPECT_NEAR(primal, dual, 1e-6 * p.n * size) << which;
}

TEST(LinearPrograms, AreSolvedWhereverTheirLimitsLie) {
  for (const double width : {0.1, 1.0, 100.0, 1e4})
    for (int seed = 1; seed <= 60; ++seed) {
      RingProgram program(3 + seed % 6, width, seed);
      Problem problem(program.graph);
      problem.add(program.cost);
      problem.add(program.constraint);
      problem.add(program.bounds);
      InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())),
                           {.tolerance = 1e-9});
      std::vector<double> x(problem.graph().rows(), 0.0);
      const std::string which = "seed " + std::to_string(seed) + ", limits " + std::to_string(width);
      ASSERT_EQ(solver.solve(x), Status::solved) << which << ": " << solver.reports()[0].residual;
      expect_optimal(program, x, which);
    }
}

}  // namespace test_linear_programs
