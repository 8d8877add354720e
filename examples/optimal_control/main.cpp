// Bounded optimal control on a chain: graphsolve without any mechanics.
//
//   minimise  sum_k 1/2 x_k' Q x_k + 1/2 R u_k^2     x_k in R^2 (position, velocity), u_k in R
//   subject to  x_{k+1} = A x_k + B u_k,  x_0 given,  -1 <= u_k <= 1
//
// Every state, input and dynamics row is a node of the graph; the graph is a tree, so nothing fills in and the cost
// is linear in the horizon. Run: build/release/bin/optimal_control. Expected: it prints the first inputs (at the
// bound, then braking), how many inputs are at their bound, and that there is no fill.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"

using namespace graphsolve;

namespace {

constexpr int horizon = 40;
constexpr double dt = 0.25;
constexpr double q[2] = {1.0, 0.1}, r = 0.1;
constexpr double x0[2] = {8.0, 0.0};
constexpr double a[2][2] = {{1, dt}, {0, 1}}, b[2] = {0.5 * dt * dt, dt};

/// F = w x, one diagonal block per node: the gradient of a quadratic cost.
class DiagonalCost final : public Term {
 public:
  void add(NodeId node, std::vector<double> weight) {
    nodes_.push_back(node);
    weight_.push_back(std::move(weight));
  }
  [[nodiscard]] int size() const override { return static_cast<int>(nodes_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override { return {&nodes_[i], 1}; }
  void wire(const Wiring& wiring) override {
    for (const NodeId node : nodes_) {
      row_.push_back(wiring.row(node));
      block_.push_back(wiring.block(node, node));
    }
  }
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override {
    for (const int i : instances.index)
      for (int k = 0; k < static_cast<int>(weight_[i].size()); ++k) {
        residual[row_[i] + k] += weight_[i][k] * x[row_[i] + k];
        if (values) values[block_[i].offset + k * (block_[i].rows + 1)] += weight_[i][k];
      }
  }

 private:
  std::vector<NodeId> nodes_;
  std::vector<std::vector<double>> weight_;
  std::vector<int> row_;
  std::vector<BlockHandle> block_;
};

/// g = x_{k+1} - A x_k - B u_k with multiplier lambda_k: residual rows +g, stationarity rows -J' lambda.
class Dynamics final : public Term {
 public:
  void add(NodeId lambda, NodeId next, NodeId state, NodeId input) {
    // x_0 is a number, not a node: the first row gets A x_0 as a constant.
    nodes_.push_back({lambda, next, input, state});
  }
  [[nodiscard]] int size() const override { return static_cast<int>(nodes_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override {
    return {nodes_[i].data(), nodes_[i][3].index < 0 ? 3u : 4u};
  }
  [[nodiscard]] Coupling coupling() const override { return Coupling::star; }
  void wire(const Wiring& wiring) override {
    for (const auto& n : nodes_) {
      Place p{};
      for (int k = 0; k < 4; ++k) {
        if (n[k].index < 0) continue;
        p.row[k] = wiring.row(n[k]);
        if (k == 0) continue;
        p.down[k] = wiring.block(n[0], n[k]).offset;
        p.across[k] = wiring.block(n[k], n[0]).offset;
      }
      place_.push_back(p);
    }
  }
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override {
    for (const int i : instances.index) {
      const Place& p = place_[i];
      const bool first = nodes_[i][3].index < 0;
      for (int row = 0; row < 2; ++row) {
        const double lambda = x[p.row[0] + row];
        residual[p.row[0] + row] += x[p.row[1] + row] - b[row] * x[p.row[2]];
        residual[p.row[1] + row] -= lambda;
        residual[p.row[2]] += b[row] * lambda;
        for (int k = 0; k < 2; ++k) {
          residual[p.row[0] + row] -= a[row][k] * (first ? x0[k] : x[p.row[3] + k]);
          if (!first) residual[p.row[3] + k] += a[row][k] * lambda;
        }
        if (!values) continue;
        add(values, p, 1, row, row, 2, 1.0);
        add(values, p, 2, row, 0, 1, -b[row]);
        for (int k = 0; k < 2 && !first; ++k) add(values, p, 3, row, k, 2, -a[row][k]);
      }
    }
  }

 private:
  struct Place {
    int row[4];
    std::int64_t down[4], across[4];
  };
  /// Entry (row, column) of the constraint's block with node k, and its mirror image with the other sign.
  static void add(double* values, const Place& p, int k, int row, int column, int columns, double j) {
    values[p.down[k] + column * 2 + row] += j;
    values[p.across[k] + row * columns + column] -= j;
  }
  std::vector<std::array<NodeId, 4>> nodes_;
  std::vector<Place> place_;
};

}  // namespace

int main() {
  BlockGraph graph;
  std::vector<NodeId> state, input, lambda;
  for (int k = 0; k < horizon; ++k) {
    input.push_back(graph.add_node("u" + std::to_string(k), 1));
    state.push_back(graph.add_node("x" + std::to_string(k + 1), 2));
    lambda.push_back(graph.add_node("dynamics " + std::to_string(k), 2, NodeKind::saddle));
    // The identity in front of x_{k+1} makes the rows independent on it alone; A does the same for x_k.
    graph.add_edge(lambda[k], state[k], EdgeRank::full);
    if (k > 0) graph.add_edge(lambda[k], state[k - 1], EdgeRank::full);
  }

  DiagonalCost cost;
  Dynamics dynamics;
  PortLawBatch<Bound, Nonnegative> bounds;
  for (int k = 0; k < horizon; ++k) {
    cost.add(state[k], {q[0], q[1]});
    cost.add(input[k], {r});
    dynamics.add(lambda[k], state[k], k > 0 ? state[k - 1] : NodeId{}, input[k]);
    bounds.add(Bound(input[k], 0, Bound::Side::lower, -1), Nonnegative());
    bounds.add(Bound(input[k], 0, Bound::Side::upper, 1), Nonnegative());
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

  const auto& solved_graph = problem.graph();
  int at_bound = 0;
  double worst = 0, objective = 0;
  for (int k = 0; k < horizon; ++k) {
    const double u = x[solved_graph.row(input[k])];
    at_bound += std::abs(u) > 1 - 1e-6;
    worst = std::max(worst, std::abs(u) - 1);
    objective += 0.5 * r * u * u;
    for (int i = 0; i < 2; ++i) objective += 0.5 * q[i] * std::pow(x[solved_graph.row(state[k]) + i], 2);
    if (k % 8 == 0) std::printf("  t = %4.1f  position %7.4f  input %7.4f\n", (k + 1) * dt, x[solved_graph.row(state[k])], u);
  }
  std::printf("objective %.6f\n", objective);
  std::printf("inputs at their bound: %d of %d\n", at_bound, horizon);
  std::printf("largest bound violation %.1e\n", std::max(worst, 0.0));
  std::printf("%s\n", symbolic->counts().fill_blocks == 0 ? "no fill" : "fill");
}
