#include "ordering/ordering_held.hpp"

#include <algorithm>
#include <vector>

namespace graphsolve {

namespace {

class HeldNetworks {
 public:
  HeldNetworks(const BlockGraph& graph, const Ordering& ordering)
      : graph_(graph), position_(graph.size()), held_(graph.size(), 0), seen_(graph.size(), 0), moved_(graph.size(), 0),
        before_(graph.size()) {
    for (int k = 0; k < graph.size(); ++k) position_[ordering.sequence[k].index] = k;
  }

  /// Is there anything to do?
  bool find() {
    std::vector<int> hosts;
    for (int i = 0; i < graph_.size(); ++i) {
      const auto edges = graph_.edges({i});
      if (graph_.kind({i}) != NodeKind::saddle || edges.size() != 1) continue;
      const int host = edges[0].to.index;
      if (graph_.kind({host}) != NodeKind::regular || !is_coupled(host)) continue;
      if (!held_[host]) hosts.push_back(host);
      held_[host] = 1;
      moved_[i] = 1;
    }
    for (const int host : hosts)
      if (!seen_[host]) arrange_network(host);
    return !hosts.empty();
  }

  std::vector<NodeId> sequence(const Ordering& ordering) {
    std::vector<NodeId> result;
    result.reserve(ordering.sequence.size());
    const auto take = [&](int node) {
      result.push_back({node});
      if (!held_[node]) return;
      for (const auto& edge : graph_.edges({node}))
        if (graph_.kind(edge.to) == NodeKind::saddle && graph_.edges(edge.to).size() == 1) result.push_back(edge.to);
    };
    for (const NodeId node : ordering.sequence) {
      for (const int earlier : before_[node.index]) take(earlier);
      if (!moved_[node.index]) take(node.index);
    }
    return result;
  }

 private:
  /// With another regular node?
  [[nodiscard]] bool is_coupled(int node) const {
    return std::ranges::any_of(graph_.edges({node}),
                               [&](const auto& edge) { return graph_.kind(edge.to) == NodeKind::regular; });
  }

  /// Held nodes that come after all others of their network go before the last of these.
  void arrange_network(int host) {
    std::vector<int> network{host}, held;
    seen_[host] = 1;
    int last = -1;  // that nothing holds
    for (std::size_t k = 0; k < network.size(); ++k) {
      const int node = network[k];
      if (held_[node]) held.push_back(node);
      else if (last < 0 || position_[node] > position_[last]) last = node;
      for (const auto& edge : graph_.edges({node})) {
        if (graph_.kind(edge.to) != NodeKind::regular || seen_[edge.to.index]) continue;
        seen_[edge.to.index] = 1;
        network.push_back(edge.to.index);
      }
    }
    if (last < 0) return;
    std::ranges::sort(held, {}, [&](int node) { return position_[node]; });
    for (const int node : held) {
      if (position_[node] < position_[last]) continue;
      moved_[node] = 1;
      before_[last].push_back(node);
    }
  }

  const BlockGraph& graph_;
  std::vector<int> position_;
  std::vector<char> held_;   ///< by a constraint of its own
  std::vector<char> seen_;
  std::vector<char> moved_;  ///< does not stay where it is in the sequence
  std::vector<std::vector<int>> before_;  ///< held nodes that come right before this one
};

}  // namespace

void hold_networks_early(const BlockGraph& graph, Ordering& ordering) {
  const bool any = std::ranges::any_of(ordering.sequence, [&](NodeId node) {
    return graph.kind(node) == NodeKind::saddle && graph.edges(node).size() == 1;
  });
  if (!any) return;
  HeldNetworks networks(graph, ordering);
  if (networks.find()) ordering.sequence = networks.sequence(ordering);
}

}  // namespace graphsolve
