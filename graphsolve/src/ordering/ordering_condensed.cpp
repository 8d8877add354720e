#include "ordering/ordering_condensed.hpp"

#include <algorithm>

namespace graphsolve::packages {

namespace {

constexpr std::size_t most_neighbours = 8;  ///< of a node that is taken out: they become a clique

bool has_saddle_nodes(const BlockGraph& graph) {
  for (int i = 0; i < graph.size(); ++i)
    if (graph.kind({i}) == NodeKind::saddle) return true;
  return false;
}

}  // namespace

CondensedGraph::CondensedGraph(const BlockGraph& graph) : graph_(graph), gone_(graph.size(), 0), place_(graph.size(), -1) {
  const bool constrained = has_saddle_nodes(graph);
  for (int i = 0; i < graph.size(); ++i) {
    const auto edges = graph.edges({i});
    if (constrained && graph.kind({i}) == NodeKind::regular && edges.size() <= most_neighbours)
      gone_[i] = std::ranges::none_of(edges, [&](const BlockGraph::Edge& e) { return gone_[e.to.index] != 0; });
    if (gone_[i]) continue;
    place_[i] = size();
    node_.push_back(i);
    weights_.push_back(graph.dimension({i}));
  }
  std::vector<int> seen(size(), -1);
  adjacency_.begin.push_back(0);
  for (int k = 0; k < size(); ++k) {
    seen[k] = k;
    const auto add = [&](NodeId node) {
      const int j = place_[node.index];
      if (j < 0 || seen[j] == k) return;
      seen[j] = k;
      adjacency_.list.push_back(j);
    };
    for (const auto& edge : graph.edges({node_[k]})) {
      add(edge.to);
      if (gone_[edge.to.index])
        for (const auto& other : graph.edges(edge.to)) add(other.to);
    }
    std::sort(adjacency_.list.begin() + adjacency_.begin.back(), adjacency_.list.end());
    adjacency_.begin.push_back(static_cast<int>(adjacency_.list.size()));
  }
}

std::vector<NodeId> CondensedGraph::expand(std::span<const int> order) const {
  std::vector<NodeId> sequence;
  sequence.reserve(graph_.size());
  std::vector<char> waits = gone_;
  for (int i = 0; i < graph_.size(); ++i)
    if (gone_[i] && graph_.edges({i}).empty()) sequence.push_back({i});
  for (const int k : order) {
    for (const auto& edge : graph_.edges({node_[k]})) {
      if (!waits[edge.to.index]) continue;
      waits[edge.to.index] = 0;
      sequence.push_back(edge.to);
    }
    sequence.push_back({node_[k]});
  }
  return sequence;
}

}  // namespace graphsolve::packages
