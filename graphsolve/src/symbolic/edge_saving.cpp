#include "symbolic/edge_saving.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <tuple>

#include "symbolic/elimination_tree.hpp"

namespace graphsolve {

namespace {

constexpr std::int64_t budget = 100'000;  ///< nodes ordered afresh, over all trials

struct Candidate {
  int a, b;   ///< nodes
  int reach;  ///< steps in the elimination tree from the first of them to the later
  bool operator<(const Candidate& other) const {
    return std::tie(other.reach, a, b) < std::tie(reach, other.a, other.b);  // furthest first
  }
};

/// Distance of every pivot from its root. The later ends of a pivot's couplings are its ancestors in the elimination
/// tree, and an edge fills at most what lies between its ends.
std::vector<int> depths(const Symbolic& symbolic) {
  std::vector<int> depth(symbolic.pivots(), 0);
  for (int k = symbolic.pivots() - 1; k >= 0; --k)
    if (symbolic.parent(k) >= 0) depth[k] = depth[symbolic.parent(k)] + 1;
  return depth;
}

/// A component as a graph of its own, with or without one edge.
class Part {
 public:
  Part(const BlockGraph& graph, const std::vector<NodeId>& nodes, std::vector<int>& local)
      : graph_(graph), nodes_(nodes), local_(local) {
    for (std::size_t k = 0; k < nodes.size(); ++k) local_[nodes[k].index] = static_cast<int>(k);
  }
  ~Part() {
    for (const NodeId node : nodes_) local_[node.index] = -1;
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  [[nodiscard]] std::vector<Candidate> edges(const Symbolic& symbolic, const std::vector<int>& depth) const {
    std::vector<Candidate> result;
    each_edge([&](NodeId a, const BlockGraph::Edge& edge) {
      const int reach = depth[symbolic.position(a)] - depth[symbolic.position(edge.to)];
      result.push_back({a.index, edge.to.index, std::abs(reach)});
    });
    std::sort(result.begin(), result.end());
    return result;
  }

  [[nodiscard]] PredictedCost cost_without(NodeId a, NodeId b) const {
    BlockGraph part;
    for (const NodeId node : nodes_) part.add_node({}, graph_.dimension(node), graph_.kind(node));
    each_edge([&](NodeId from, const BlockGraph::Edge& edge) {
      if (from == a && edge.to == b) return;
      part.add_edge({local_[from.index]}, {local_[edge.to.index]}, edge.rank);
    });
    return predict_cost(part, minimum_fill_ordering(part));
  }

 private:
  template <class F>
  void each_edge(F&& f) const {
    for (const NodeId node : nodes_)
      for (const auto& edge : graph_.edges(node))
        if (node.index < edge.to.index && local_[edge.to.index] >= 0) f(node, edge);
  }
  const BlockGraph& graph_;
  const std::vector<NodeId>& nodes_;
  std::vector<int>& local_;  ///< number of a node within the part, or -1
};

}  // namespace

std::optional<EdgeSaving> find_edge_saving(const BlockGraph& graph, const Symbolic& symbolic,
                                           const std::vector<FillCause>& causes) {
  EdgeSaving best;
  const std::vector<int> depth = depths(symbolic);
  std::vector<int> local(graph.size(), -1);
  std::int64_t left = budget;
  for (const FillCause& cause : causes) {
    if (cause.cycles == 0) continue;
    best.edges += cause.edges;
    const auto size = static_cast<std::int64_t>(cause.nodes.size());
    if (left < 2 * size) continue;
    const Part part(graph, cause.nodes, local);
    const PredictedCost with = part.cost_without({}, {});
    left -= size;
    for (const Candidate& c : part.edges(symbolic, depth)) {
      if (left < size) break;
      left -= size;
      ++best.tried;
      const PredictedCost without = part.cost_without({c.a}, {c.b});
      const std::int64_t saved = with.operations - without.operations;
      if (saved <= best.operations) continue;
      best.a = {c.a};
      best.b = {c.b};
      best.operations = saved;
      best.blocks = with.fill_blocks - without.fill_blocks;
      best.scalars = with.stored_scalars - without.stored_scalars;
    }
  }
  if (best.operations <= 0) return std::nullopt;
  return best;
}

}  // namespace graphsolve
