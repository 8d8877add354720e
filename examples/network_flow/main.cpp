// Least-cost flow through a network with capacities: a linear program on a graph.
//
//   minimise  sum_e c_e q_e   over the flows q   subject to  outflow - inflow = supply at every town,  0 <= q_e <= cap_e
//
// Roads without quadratic cost have nothing on their diagonal but what their bounds add: regular nodes all the same.
// All supplies together are zero, so one conservation row depends on the others, and prices are known up to a constant;
// nothing has to be done about it.
// Run: build/release/bin/network_flow.
//
// Checked in the output, by code that does not know the solver: with whole supplies and capacities the least cost
// is reached by whole flows; and the duality gap  sum_e (reduced cost)+ q_e + (reduced cost)- (cap_e - q_e),
// which is zero only at an optimum. With a quadratic cost (congestion) added the flows are not whole, the gap still zero.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <random>
#include <string>
#include <vector>

#include "../no_arguments.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"

using namespace graphsolve;

namespace {

constexpr int width = 12, height = 8, towns = width * height;

struct Road {
  int from, to;
  double cost, congestion, capacity;  ///< pays cost q + 1/2 congestion q^2
};

struct Network {
  std::vector<Road> roads;
  std::vector<double> supply = std::vector<double>(towns, 0.0);
};

/// Roads both ways between neighbours on a grid; every third town trades.
Network make_network() {
  std::mt19937 random(20);
  const auto whole = [&](int low, int high) { return low + static_cast<int>(random() % (high - low + 1)); };
  Network network;
  const auto connect = [&](int a, int b) {
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, a}})
      network.roads.push_back({from, to, 0.001 * whole(1000, 20000), 0.0, 1.0 * whole(6, 12)});
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width) connect(y * width + x, y * width + x + 1);
      if (y + 1 < height) connect(y * width + x, (y + 1) * width + x);
    }
  for (int from = 0, to = towns - 1; from < to; from += 3, to -= 3) {
    const int amount = whole(1, 9);
    network.supply[from] += amount;
    network.supply[to] -= amount;
  }
  return network;
}

struct Flow {
  std::vector<double> q, price;  ///< by road, by town
  int iterations = 0;
  bool solved = false;
};

Flow solve(const Network& network) {
  BlockGraph graph;
  QuadraticCost cost;
  LinearConstraint conservation;
  PortLawBatch<Bound, Nonnegative> bounds;
  std::vector<NodeId> flow, row;
  std::vector<std::vector<LinearConstraint::Part>> parts(towns);
  for (const Road& road : network.roads) {
    const std::string name = std::to_string(road.from) + "-" + std::to_string(road.to);
    const NodeId node = graph.add_node("road " + name, 1);
    flow.push_back(node);
    cost.add_diagonal(node, {&road.congestion, 1}, {&road.cost, 1});
    parts[road.from].push_back({node, {1}});
    parts[road.to].push_back({node, {-1}});
    bounds.add(Bound(node, 0, Bound::Side::lower, 0), Nonnegative());
    bounds.add(Bound(node, 0, Bound::Side::upper, road.capacity), Nonnegative());
  }
  for (int town = 0; town < towns; ++town) {
    row.push_back(graph.add_node("town " + std::to_string(town), 1, NodeKind::saddle));
    for (const auto& part : parts[town]) graph.add_edge(row[town], part.node, EdgeRank::full);
    conservation.add(row[town], parts[town], {&network.supply[town], 1});
  }
  Problem problem(graph);
  problem.add(cost);
  problem.add(conservation);
  problem.add(bounds);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
  std::vector<double> x(graph.rows(), 0.0);
  const Status status = solver.solve(x);
  if (status != Status::solved) std::printf("%s: %s\n", name(status).data(), explanation(status).data());
  Flow result{{}, {}, solver.reports()[0].iterations, status == Status::solved};
  for (const NodeId node : flow) result.q.push_back(x[graph.row(node)]);
  for (const NodeId node : row) result.price.push_back(x[graph.row(node)]);
  return result;
}

void report(const char* title, const Network& network, const Flow& flow) {
  double total = 0, gap = 0, lost = 0, fraction = 0;
  std::vector<double> balance = network.supply;
  for (double& b : balance) b = -b;
  for (std::size_t e = 0; e < network.roads.size(); ++e) {
    const Road& road = network.roads[e];
    const double q = flow.q[e];
    total += road.cost * q + 0.5 * road.congestion * q * q;
    const double reduced = road.cost + road.congestion * q - (flow.price[road.from] - flow.price[road.to]);
    gap += std::max(reduced, 0.0) * q + std::max(-reduced, 0.0) * (road.capacity - q);
    balance[road.from] += q;
    balance[road.to] -= q;
    fraction = std::max(fraction, std::abs(q - std::round(q)));
  }
  for (const double b : balance) lost = std::max(lost, std::abs(b));
  std::printf("%s: cost %.4f, %s flows\n", title, total, fraction < 1e-5 ? "whole" : "broken");
  std::printf("  duality gap over cost %s, lost at a town %s\n", std::abs(gap) / total < 1e-7 ? "< 1e-7" : "too large",
              lost < 1e-7 ? "< 1e-7" : "too much");
  std::printf("  %d iterations\n", flow.iterations);
}

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words, "Least-cost flow through a network with capacities: a linear program on a graph.");
  Network network = make_network();
  const Flow linear = solve(network);
  report("linear cost", network, linear);
  for (Road& road : network.roads) road.congestion = 1;
  const Flow congested = solve(network);
  report("with congestion", network, congested);
  return linear.solved && congested.solved ? 0 : 1;
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "network_flow: %s\n", error.what());
  return 2;
}
