#include "support/graph_families.hpp"

#include <algorithm>
#include <random>

#include "graphsolve/io/block_view.hpp"

namespace families {

using graphsolve::BlockGraph;
using graphsolve::EdgeRank;
using graphsolve::NodeId;
using graphsolve::NodeKind;

namespace {

std::vector<NodeId> regular_nodes(BlockGraph& graph, int n) {
  std::vector<NodeId> nodes;
  for (int i = 0; i < n; ++i) nodes.push_back(graph.add_node("node " + std::to_string(i), 6));
  return nodes;
}

void connect(BlockGraph& graph, NodeId a, NodeId b, int rows = 3) {
  const NodeId link = graph.add_node("link " + std::to_string(graph.size()), rows, NodeKind::saddle);
  const auto rank = [&](NodeId host) { return rows <= graph.dimension(host) ? EdgeRank::full_row : EdgeRank::unknown; };
  graph.add_edge(link, a, rank(a));
  if (b.index >= 0) graph.add_edge(link, b, rank(b));
}

}  // namespace

BlockGraph chain(int n) {
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, n);
  for (int i = 0; i + 1 < n; ++i) connect(graph, nodes[i], nodes[i + 1]);
  return graph;
}

BlockGraph anchored_chain(int n) {
  BlockGraph graph = chain(n);
  connect(graph, {0}, {});
  connect(graph, {n - 1}, {});
  return graph;
}

BlockGraph balanced_tree(int n) {
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, n);
  for (int i = 1; i < n; ++i) connect(graph, nodes[i], nodes[(i - 1) / 2]);
  return graph;
}

BlockGraph quadruped() {
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, 13);
  for (int leg = 0; leg < 4; ++leg)
    for (int k = 0; k < 3; ++k) connect(graph, nodes[1 + 3 * leg + k], nodes[k == 0 ? 0 : 3 * leg + k]);
  return graph;
}

BlockGraph star(int leaves) {
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, leaves + 1);
  for (int i = 1; i <= leaves; ++i) connect(graph, nodes[i], nodes[0]);
  return graph;
}

BlockGraph loop(int n) {
  BlockGraph graph = chain(n);
  connect(graph, {n - 1}, {0});
  return graph;
}

BlockGraph ladder(int n) {
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, n);
  for (int i = 0; i + 2 < n; ++i) connect(graph, nodes[i], nodes[i + 2]);
  for (int i = 0; i + 1 < n; i += 2) connect(graph, nodes[i], nodes[i + 1]);
  return graph;
}

BlockGraph grid(int side, int rows) {
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, side * side);
  for (int r = 0; r < side; ++r)
    for (int c = 0; c < side; ++c) {
      if (c + 1 < side) connect(graph, nodes[r * side + c], nodes[r * side + c + 1], rows);
      if (r + 1 < side) connect(graph, nodes[r * side + c], nodes[(r + 1) * side + c], rows);
    }
  return graph;
}

BlockGraph random_tree(int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto pick = [&](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
  BlockGraph graph;
  std::vector<NodeId> nodes;
  for (int i = 0; i < n; ++i) nodes.push_back(graph.add_node("node " + std::to_string(i), pick(1, 6)));
  for (int i = 1; i < n; ++i) {
    const NodeId other = nodes[pick(0, i - 1)];
    connect(graph, nodes[i], other, pick(1, std::min(graph.dimension(nodes[i]), graph.dimension(other))));
  }
  return graph;
}

BlockGraph random_with_loops(int n, int extra, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto pick = [&](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
  BlockGraph graph;
  const auto nodes = regular_nodes(graph, n);
  for (int i = 1; i < n; ++i) connect(graph, nodes[i], nodes[pick(0, i - 1)], pick(1, 3));
  for (int k = 0; k < extra; ++k) {
    const int a = pick(0, n - 1), b = pick(0, n - 1);
    if (a != b) connect(graph, nodes[a], nodes[b], 1);
  }
  return graph;
}

BlockGraph control(int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  BlockGraph graph;
  NodeId state;
  for (int k = 0; k < n; ++k) {
    const std::string step = std::to_string(k);
    const NodeId u = graph.add_node("control " + step, 1);
    const NodeId dynamics = graph.add_node("dynamics " + step, 2, NodeKind::saddle);
    const bool costs = k + 1 == n || random() % 2 == 0;
    const NodeId next = graph.add_node("state " + step, 2, costs ? NodeKind::regular : NodeKind::semidefinite);
    graph.add_edge(dynamics, u, EdgeRank::full_column);
    graph.add_edge(dynamics, next, EdgeRank::full);
    if (k > 0) graph.add_edge(dynamics, state, EdgeRank::full);
    state = next;
  }
  return graph;
}

namespace {

template <class F>
void each_block(const BlockGraph& graph, F&& f) {
  for (int a = 0; a < graph.size(); ++a) {
    f(NodeId{a}, NodeId{a});
    for (const auto& edge : graph.edges({a})) f(NodeId{a}, edge.to);
  }
}

}  // namespace

Eigen::MatrixXd saddle_matrix(const BlockGraph& graph, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(graph.rows(), graph.rows());
  each_block(graph, [&](NodeId a, NodeId b) {
    const int ra = graph.row(a), rb = graph.row(b), da = graph.dimension(a), db = graph.dimension(b);
    if (a == b && (graph.kind(a) == NodeKind::regular || graph.kind(a) == NodeKind::shared)) {
      const Eigen::MatrixXd m = Eigen::MatrixXd::NullaryExpr(da, da, [&] { return normal(random); });
      f.block(ra, ra, da, da) = m * m.transpose() + 0.5 * Eigen::MatrixXd::Identity(da, da);
    } else if (graph.kind(a) == NodeKind::saddle && a != b) {
      const Eigen::MatrixXd j = Eigen::MatrixXd::NullaryExpr(da, db, [&] { return normal(random); });
      f.block(ra, rb, da, db) = j;
      f.block(rb, ra, db, da) = -j.transpose();
    }
  });
  return f;
}

Eigen::MatrixXd dominant_matrix(const BlockGraph& graph, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(graph.rows(), graph.rows());
  each_block(graph, [&](NodeId a, NodeId b) {
    auto block = f.block(graph.row(a), graph.row(b), graph.dimension(a), graph.dimension(b));
    for (Eigen::Index j = 0; j < block.cols(); ++j)
      for (Eigen::Index i = 0; i < block.rows(); ++i) block(i, j) = uniform(random);
  });
  for (Eigen::Index i = 0; i < f.rows(); ++i) f(i, i) = 1 + f.row(i).cwiseAbs().sum();
  return f;
}

void load(const Eigen::MatrixXd& dense, const BlockGraph& graph, const graphsolve::Symbolic& symbolic,
          std::span<double> values) {
  std::fill(values.begin(), values.end(), 0.0);
  each_block(graph, [&](NodeId a, NodeId b) {
    const auto handle = symbolic.block(a, b);
    graphsolve::block_view(values, handle) =
        dense.block(graph.row(a), graph.row(b), handle.rows, handle.columns);
  });
}

double fill_factor(const graphsolve::Symbolic& symbolic) {
  // Diagonal blocks count with their lower triangle, couplings once.
  double diagonal = 0;
  for (int k = 0; k < symbolic.pivots(); ++k) {
    const double d = symbolic.dimension(k);
    diagonal += d * (d + 1) / 2 - d * d / 2;  // what (stored - diagonal squares) / 2 below leaves out
  }
  const auto& c = symbolic.counts();
  return (static_cast<double>(c.stored_scalars) / 2 + diagonal) /
         (static_cast<double>(c.matrix_scalars) / 2 + diagonal);
}

}  // namespace families
