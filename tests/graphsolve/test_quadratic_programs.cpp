#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"

namespace test_quadratic_programs {

/// Quadratic programs as users have them: what is solved is the solution, and what has one is solved.

using namespace graphsolve;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// min x'Hx/2 + c'x, A x = b, lo <= x <= up, with a known solution; H of any rank.
struct Program {
  MatrixXd h, a;
  VectorXd c, b, lo, up;
  double value = 0;  ///< of the objective at the solution

  explicit Program(unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    const auto any = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
    const int n = any(2, 18), m = any(0, n / 2), rank = any(1, n);
    MatrixXd l(n, rank);
    for (double& v : l.reshaped()) v = uniform(-1, 1);
    h = l * l.transpose();
    a = MatrixXd::Zero(m, n);
    for (double& v : a.reshaped()) v = any(0, 2) > 0 ? uniform(-1, 1) : 0;
    for (int i = 0; i < m; ++i) a(i, i) += 0.5;
    VectorXd x(n), force = VectorXd::Zero(n), multiplier(m);
    lo.resize(n);
    up.resize(n);
    for (int i = 0; i < n; ++i) {
      x[i] = uniform(-2, 2);
      const int kind = any(0, 4);
      lo[i] = x[i] - (kind == 0 ? 0 : uniform(0.1, 3));
      up[i] = x[i] + (kind == 1 ? 0 : uniform(0.1, 3));
      if (kind < 2) force[i] = (kind == 0 ? 1 : -1) * uniform(0.1, 2);
    }
    for (double& v : multiplier) v = uniform(-2, 2);
    b = a * x;
    c = -(h * x) + a.transpose() * multiplier + force;
    value = 0.5 * x.dot(h * x) + c.dot(x);
  }
};

/// One node per unknown and per constraint: H is a term of all of them.
void expect_solved(unsigned seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Program p(seed);
  const int n = static_cast<int>(p.c.size()), m = static_cast<int>(p.b.size());
  BlockGraph graph;
  std::vector<NodeId> unknowns;
  for (int i = 0; i < n; ++i) unknowns.push_back(graph.add_node("x" + std::to_string(i), 1));
  QuadraticCost cost;
  cost.add(unknowns, {p.h.data(), static_cast<std::size_t>(p.h.size())}, {p.c.data(), static_cast<std::size_t>(n)});
  LinearConstraint constraints;
  for (int r = 0; r < m; ++r) {
    const NodeId node = graph.add_node("c" + std::to_string(r), 1, NodeKind::saddle);
    std::vector<LinearConstraint::Part> parts;
    for (int i = 0; i < n; ++i)
      if (p.a(r, i) != 0) parts.push_back({unknowns[i], {p.a(r, i)}});
    const double right[] = {p.b[r]};
    constraints.add(node, parts, right);
  }
  PortLawBatch<Bound, Nonnegative> bounds;
  for (int i = 0; i < n; ++i) {
    bounds.add(Bound(unknowns[i], 0, Bound::Side::lower, p.lo[i]), Nonnegative());
    bounds.add(Bound(unknowns[i], 0, Bound::Side::upper, p.up[i]), Nonnegative());
  }
  Problem problem(std::move(graph));
  problem.add(cost);
  problem.add(constraints);
  problem.add(bounds);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
  std::vector<double> z(problem.graph().rows(), 0.0);
  ASSERT_EQ(solver.solve(z), Status::solved);
  VectorXd x(n);
  for (int i = 0; i < n; ++i) x[i] = z[problem.graph().row(unknowns[i])];
  EXPECT_LE((p.lo - x).maxCoeff(), 1e-7);
  EXPECT_LE((x - p.up).maxCoeff(), 1e-7);
  for (int r = 0; r < m; ++r) EXPECT_NEAR(p.a.row(r).dot(x), p.b[r], 1e-7);
  EXPECT_NEAR(0.5 * x.dot(p.h * x) + p.c.dot(x), p.value, 1e-5 * (1 + std::abs(p.value)));
}

/// Where far bounds alone hold some direction, 1e-11 of the scale is on its diagonal and other constraints have pivots
/// as small as dependent ones: 3 of these fail where rows are left out by 1e-8 of that.
TEST(QuadraticPrograms, OfReducedRankInBoxesAreSolved) {
  for (unsigned seed = 1; seed <= 300; ++seed) expect_solved(seed);
}

/// min (x1 - c)^2/2 + k/2 (x1 - x2)^2: at x = 0 the gradient is c, next to a diagonal of k nothing, and c away.
TEST(QuadraticPrograms, AStiffCouplingHidesNoDistance) {
  for (const double k : {1e3, 1e6, 1e9})
    for (const double wanted : {1e-3, 1.0}) {
      BlockGraph graph;
      const std::vector<NodeId> both{graph.add_node("x1", 1), graph.add_node("x2", 1)};
      QuadraticCost cost;
      const double h[] = {1 + k, -k, -k, k}, c[] = {-wanted, 0};
      cost.add(both, h, c);
      Problem problem(std::move(graph));
      problem.add(cost);
      InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
      std::vector<double> x(2, 0.0);
      ASSERT_EQ(solver.solve(x), Status::solved);
      EXPECT_NEAR(x[0], wanted, 1e-6 * wanted) << k;
      EXPECT_NEAR(x[1], wanted, 1e-6 * wanted) << k;
    }
}

/// A double integrator over two steps whose velocity costs next to nothing: multipliers of size 1, rounded to 1e-16, over
/// a diagonal of 1e-10 are no residual.
TEST(QuadraticPrograms, AWeightOfNextToNothingIsNoFailure) {
  for (const double weight : {1e-6, 1e-9, 1e-10}) {
    BlockGraph graph;
    QuadraticCost cost;
    LinearConstraint dynamics;
    std::vector<NodeId> x, u;
    const double q[] = {1, weight}, r[] = {0.1}, none[] = {0, 0}, nothing[] = {0};
    for (int k = 0; k < 3; ++k) {
      x.push_back(graph.add_node("x" + std::to_string(k), 2));
      cost.add_diagonal(x[k], q, none);
    }
    for (int k = 0; k < 2; ++k) {
      u.push_back(graph.add_node("u" + std::to_string(k), 1));
      cost.add_diagonal(u[k], r, nothing);
      const NodeId row = graph.add_node("dynamics " + std::to_string(k), 2, NodeKind::saddle);
      dynamics.add(row,
                   std::vector<LinearConstraint::Part>{{x[k], {-1, 0, -1, -1}}, {u[k], {-0.5, -1}}, {x[k + 1], {1, 0, 0, 1}}},
                   none);
    }
    const NodeId first = graph.add_node("start", 2, NodeKind::saddle);
    const double start[] = {3, 1};
    dynamics.add(first, std::vector<LinearConstraint::Part>{{x[0], {1, 0, 0, 1}}}, start);
    Problem problem(std::move(graph));
    problem.add(cost);
    problem.add(dynamics);
    InteriorPoint solver(problem,
                         std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
    std::vector<double> z(problem.graph().rows(), 0.0);
    ASSERT_EQ(solver.solve(z), Status::solved) << weight;
    // The last input moves the last position alone; the first one moves both. By hand, without the weight:
    // d/du: 0.1 u0 + 0.5 (4 + u0/2) + 1.5 (5 + 1.5 u0 + u1/2) = 0,  0.1 u1 + 0.5 (5 + 1.5 u0 + u1/2) = 0
    const double a = 0.1 + 0.25 + 2.25, b = 0.75, d = 0.1 + 0.25, e = -(2 + 7.5), f = -2.5, det = a * d - b * b;
    EXPECT_NEAR(z[problem.graph().row(u[0])], (e * d - b * f) / det, 1e-4) << weight;
    EXPECT_NEAR(z[problem.graph().row(u[1])], (a * f - b * e) / det, 1e-4) << weight;
  }
}

}  // namespace test_quadratic_programs
