// Bounded optimal control on a chain: graphsolve without any mechanics.
//
//   minimise  sum_k 1/2 x_k' Q x_k + 1/2 R u_k^2     x_k in R^2 (position, velocity), u_k in R
//   subject to  x_{k+1} = A x_k + B u_k,  x_0 given,  -1 <= u_k <= 1
//
// Every state, input and dynamics row is a node of the graph; the graph is a tree, so nothing fills in and the cost
// is linear in the horizon. Run: build/release/bin/optimal_control. Expected: it prints the first inputs (at the
// bound, then braking), how many inputs are at their bound, and that there is no fill.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "../no_arguments.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"

using namespace graphsolve;

namespace {

constexpr int horizon = 40;
constexpr double dt = 0.25;
const std::vector<double> q{1.0, 0.1}, r{0.1};
constexpr double x0[2] = {8.0, 0.0};
const std::vector<double> minus_a{-1, 0, -dt, -1};        // column-major, as all matrices
const std::vector<double> minus_b{-0.5 * dt * dt, -dt};
const std::vector<double> identity{1, 0, 0, 1};

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words, "Bounded optimal control on a chain: graphsolve without any mechanics.");
  BlockGraph graph;
  QuadraticCost cost;
  LinearConstraint dynamics;
  PortLawBatch<Bound, Nonnegative> bounds;
  std::vector<NodeId> state, input;
  for (int k = 0; k < horizon; ++k) {
    const NodeId u = graph.add_node("u" + std::to_string(k), 1), x = graph.add_node("x" + std::to_string(k + 1), 2);
    const NodeId row = graph.add_node("dynamics " + std::to_string(k), 2, NodeKind::saddle);
    cost.add_diagonal(x, q);
    cost.add_diagonal(u, r);
    std::vector<LinearConstraint::Part> parts{{x, identity}, {u, minus_b}};
    std::vector<double> right_hand_side{0, 0};
    // The identity in front of x_{k+1} makes the rows independent on it alone; A does the same for x_k.
    graph.add_edge(row, x, EdgeRank::full);
    if (k > 0) {
      graph.add_edge(row, state.back(), EdgeRank::full);
      parts.push_back({state.back(), minus_a});
    } else {  // x_0 is a number, not a node
      right_hand_side = {x0[0] + dt * x0[1], x0[1]};
    }
    dynamics.add(row, parts, right_hand_side);
    bounds.add(Bound(u, 0, Bound::Side::lower, -1), Nonnegative());
    bounds.add(Bound(u, 0, Bound::Side::upper, 1), Nonnegative());
    input.push_back(u);
    state.push_back(x);
  }

  Problem problem(graph);
  problem.add(cost);
  problem.add(dynamics);
  problem.add(bounds);
  auto symbolic = std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph()));
  InteriorPoint solver(problem, symbolic);
  std::vector<double> x(symbolic->rows(), 0.0);
  const Status status = solver.solve(x);
  if (status != Status::solved) {
    std::printf("%s: %s\n", name(status).data(), explanation(status).data());
    return 1;
  }
  std::printf("solved in %d iterations\n", solver.reports()[0].iterations);

  int at_bound = 0;
  double worst = 0, objective = 0;
  for (int k = 0; k < horizon; ++k) {
    const double u = x[graph.row(input[k])];
    const double* at = &x[graph.row(state[k])];
    at_bound += std::abs(u) > 1 - 1e-6;
    worst = std::max(worst, std::abs(u) - 1);
    objective += 0.5 * (r[0] * u * u + q[0] * at[0] * at[0] + q[1] * at[1] * at[1]);
    if (k % 8 == 0) std::printf("  t = %4.1f  position %7.4f  input %7.4f\n", (k + 1) * dt, at[0], u);
  }
  std::printf("objective %.6f\n", objective);
  std::printf("inputs at their bound: %d of %d\n", at_bound, horizon);
  std::printf("largest bound violation %.1e\n", std::max(worst, 0.0));
  std::printf("%s\n", symbolic->counts().fill_blocks == 0 ? "no fill" : "fill");
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "optimal_control: %s\n", error.what());
  return 2;
}
