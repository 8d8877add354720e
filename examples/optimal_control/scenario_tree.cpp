// Bounded optimal control under uncertain wind: a tree of scenarios instead of a chain.
//
//   minimise  E[ sum_k 1/2 x_k' Q x_k + 1/2 R u_k^2 ]
//   subject to  x_n = A x_p + B u_p + B w_n  for every tree node n with parent p,  x_root given,  |u| <= bound
//
// In each of the first `branching` steps the wind w is -1, 0 or 1 with equal probability, afterwards 0. An input is
// chosen before the wind of its step is known: there is one per tree node, not one per scenario.
// State and input of a tree node are *one* block of the graph: then the graph is a tree and nothing fills in. As blocks
// of their own they close a cycle with every two children.
//
// Run: build/release/bin/scenario_tree. Checked in the output, by code that does not know the solver:
//   without bounds, u_root is the -K x of the Riccati recursion (certainty equivalence);
//   with bounds, no input can be improved: u = clip(u - gradient), the gradient from a backward pass over the tree.

#include <algorithm>
#include <array>
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

constexpr int horizon = 12, branching = 4;
constexpr double dt = 0.25, r = 0.1, q[2] = {1.0, 0.1};
constexpr double b[2] = {0.5 * dt * dt, dt};
using State = std::array<double, 2>;
constexpr State start{3.0, 0.0};

State next(const State& x, double push) { return {x[0] + dt * x[1] + b[0] * push, x[1] + b[1] * push}; }

struct TreeNode {
  int parent, step;
  double probability, wind;
};

/// Parents come before their children.
std::vector<TreeNode> make_tree() {
  std::vector<TreeNode> tree{{-1, 0, 1.0, 0.0}};
  for (int n = 0; n < static_cast<int>(tree.size()); ++n) {
    const TreeNode parent = tree[n];
    if (parent.step == horizon) continue;
    if (parent.step >= branching) tree.push_back({n, parent.step + 1, parent.probability, 0.0});
    else
      for (const double wind : {-1.0, 0.0, 1.0}) tree.push_back({n, parent.step + 1, parent.probability / 3, wind});
  }
  return tree;
}

struct Solution {
  std::vector<double> input;  ///< by tree node; leaves have none that matters
  int iterations = 0;
  long long fill = 0;
};

/// Every tree node is one block: position, velocity, input.
Solution solve(const std::vector<TreeNode>& tree, double bound) {
  BlockGraph graph;
  QuadraticCost cost;
  LinearConstraint dynamics;
  PortLawBatch<Bound, Nonnegative> bounds;
  std::vector<NodeId> block;
  for (std::size_t n = 0; n < tree.size(); ++n) {
    const std::string name = std::to_string(n);
    const double p = tree[n].probability;
    block.push_back(graph.add_node("state and input " + name, 3));
    cost.add_diagonal(block[n], std::vector{p * q[0], p * q[1], p * r});
    const NodeId row = graph.add_node("dynamics " + name, 2, NodeKind::saddle);
    graph.add_edge(row, block[n], EdgeRank::full_row);
    std::vector<LinearConstraint::Part> parts{{block[n], {1, 0, 0, 1, 0, 0}}};
    State constant = start;
    if (n > 0) {
      const NodeId parent = block[tree[n].parent];
      graph.add_edge(row, parent, EdgeRank::full_row);
      parts.push_back({parent, {-1, 0, -dt, -1, -b[0], -b[1]}});
      constant = {b[0] * tree[n].wind, b[1] * tree[n].wind};
    }
    dynamics.add(row, parts, constant);
    bounds.add(Bound(block[n], 2, Bound::Side::lower, -bound), Nonnegative(p));
    bounds.add(Bound(block[n], 2, Bound::Side::upper, bound), Nonnegative(p));
  }
  Problem problem(graph);
  problem.add(cost);
  problem.add(dynamics);
  problem.add(bounds);
  const auto symbolic = std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph()));
  InteriorPoint solver(problem, symbolic);
  std::vector<double> x(symbolic->rows(), 0.0);
  const Status status = solver.solve(x);
  if (status != Status::solved) std::printf("%s: %s\n", name(status).data(), explanation(status).data());
  Solution solution{{}, solver.reports()[0].iterations, symbolic->counts().fill_blocks};
  for (const NodeId node : block) solution.input.push_back(x[graph.row(node) + 2]);
  return solution;
}

/// Expected cost of these inputs, and its derivative by every input divided by the node's probability.
double evaluate(const std::vector<TreeNode>& tree, const std::vector<double>& input, std::vector<double>& slope) {
  const int size = static_cast<int>(tree.size());
  std::vector<State> x(size, start), price(size, State{});  // price: derivative of the cost by the state
  double cost = 0;
  for (int n = 0; n < size; ++n) {
    if (n > 0) x[n] = next(x[tree[n].parent], input[tree[n].parent] + tree[n].wind);
    cost += 0.5 * tree[n].probability * (q[0] * x[n][0] * x[n][0] + q[1] * x[n][1] * x[n][1] + r * input[n] * input[n]);
  }
  slope.assign(size, 0.0);
  for (int n = size - 1; n >= 0; --n) {
    const double p = tree[n].probability;
    for (int k = 0; k < 2; ++k) price[n][k] += p * q[k] * x[n][k];
    slope[n] = r * input[n] + slope[n] / p;
    if (n == 0) break;
    const int parent = tree[n].parent;
    price[parent][0] += price[n][0];
    price[parent][1] += dt * price[n][0] + price[n][1];
    slope[parent] += b[0] * price[n][0] + b[1] * price[n][1];
  }
  return cost;
}

/// First input of the unbounded problem without wind, by the Riccati recursion.
double riccati_input() {
  double p[3] = {q[0], 0, q[1]}, k[2] = {0, 0};  // p: (0,0), (0,1), (1,1)
  for (int step = 0; step < horizon; ++step) {
    const double pb[2] = {p[0] * b[0] + p[1] * b[1], p[1] * b[0] + p[2] * b[1]};
    const double weight = r + b[0] * pb[0] + b[1] * pb[1];
    k[0] = pb[0] / weight, k[1] = (dt * pb[0] + pb[1]) / weight;
    const double pa[4] = {p[0], p[0] * dt + p[1], p[1], p[1] * dt + p[2]};  // P A by rows
    p[0] = q[0] + pa[0] - weight * k[0] * k[0];
    p[1] = pa[1] - weight * k[0] * k[1];
    p[2] = q[1] + dt * pa[1] + pa[3] - weight * k[1] * k[1];
  }
  return -k[0] * start[0] - k[1] * start[1];
}

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words, "Bounded optimal control under uncertain wind: a tree of scenarios instead of a chain.");
  const std::vector<TreeNode> tree = make_tree();
  std::vector<double> slope;
  const Solution free = solve(tree, 100.0), bounded = solve(tree, 1.0);
  const double free_cost = evaluate(tree, free.input, slope), cost = evaluate(tree, bounded.input, slope);
  double worst = 0;
  int at_bound = 0;
  for (std::size_t n = 0; n < tree.size(); ++n) {
    const double u = bounded.input[n];
    worst = std::max(worst, std::abs(u - std::clamp(u - slope[n], -1.0, 1.0)));
    at_bound += std::abs(u) > 1 - 1e-5;
  }
  std::printf("%zu tree nodes, %zu unknowns, fill blocks: %lld\n", tree.size(), 5 * tree.size(), bounded.fill);
  std::printf("without bounds: first input %.6f, by Riccati %.6f, expected cost %.6f\n", free.input[0], riccati_input(),
              free_cost);
  std::printf("|u| <= 1: first input %.6f, %d inputs at their bound, expected cost %.6f\n", bounded.input[0], at_bound,
              cost);
  std::printf("any input could still be improved by %s\n", worst <= 1e-6 ? "less than 1e-6" : "more than 1e-6");
  std::printf("bounded in %d iterations\n", bounded.iterations);
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "scenario_tree: %s\n", error.what());
  return 2;
}
