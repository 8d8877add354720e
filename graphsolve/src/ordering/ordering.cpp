#include "graphsolve/ordering.hpp"

#include <stdexcept>
#include <string>

#include "ordering/ordering_held.hpp"
#include "ordering/ordering_repair.hpp"

namespace graphsolve {

Ordering repaired(const BlockGraph& graph, std::span<const NodeId> sequence) {
  Ordering result;
  result.sequence.reserve(sequence.size());
  Eligibility rule(graph);
  std::vector<char> deferred(graph.size(), 0), done(graph.size(), 0);
  std::vector<NodeId> waiting;  // deferred nodes in their own order
  std::vector<NodeId> freed, pending;
  const auto take = [&](NodeId first) {
    pending.assign(1, first);
    for (std::size_t k = 0; k < pending.size(); ++k) {
      done[pending[k].index] = 1;
      result.sequence.push_back(pending[k]);
      freed.clear();
      rule.eliminate(pending[k], freed);
      for (const NodeId node : freed)
        if (deferred[node.index]) pending.push_back(node);
    }
  };
  for (const NodeId node : sequence) {
    if (rule.eligible(node)) {
      take(node);
    } else {
      deferred[node.index] = 1;
      ++result.repairs;
      waiting.push_back(node);
    }
  }
  for (const NodeId node : waiting) {
    if (done[node.index]) continue;
    ++result.forced;
    take(node);
  }
  return result;
}

Ordering natural_ordering(const BlockGraph& graph) {
  std::vector<NodeId> sequence(graph.size());
  for (int i = 0; i < graph.size(); ++i) sequence[i] = {i};
  Ordering result = repaired(graph, sequence);
  hold_networks_early(graph, result);
  result.method = OrderingMethod::natural;
  return result;
}

Ordering depth_first_ordering(const BlockGraph& graph, NodeId root) {
  const int n = graph.size();
  if (root.index >= n)
    throw std::invalid_argument("ordering: root " + std::to_string(root.index) + " is not in the graph");
  std::vector<char> found(n, 0);
  std::vector<NodeId> order;  // first found first
  struct Visit {
    int node;
    std::size_t next;
  };
  std::vector<Visit> stack;
  const auto search = [&](int start) {
    if (found[start]) return;
    found[start] = 1;
    order.push_back({start});
    stack.push_back({start, 0});
    while (!stack.empty()) {
      Visit& top = stack.back();
      const auto edges = graph.edges({top.node});
      while (top.next < edges.size() && found[edges[top.next].to.index]) ++top.next;
      if (top.next == edges.size()) {
        stack.pop_back();
        continue;
      }
      const int child = edges[top.next].to.index;
      found[child] = 1;
      order.push_back({child});
      stack.push_back({child, 0});
    }
  };
  if (root.index >= 0) search(root.index);
  for (int i = 0; i < n; ++i) search(i);
  Ordering result = repaired(graph, std::vector<NodeId>(order.rbegin(), order.rend()));
  hold_networks_early(graph, result);
  result.method = OrderingMethod::depth_first;
  return result;
}

Ordering user_ordering(const BlockGraph& graph, std::span<const NodeId> sequence) {
  std::vector<char> seen(graph.size(), 0);
  for (const NodeId node : sequence) {
    if (node.index < 0 || node.index >= graph.size() || seen[node.index])
      throw std::invalid_argument("ordering: node " + std::to_string(node.index) +
                                  " is not in the graph or comes twice");
    seen[node.index] = 1;
  }
  if (static_cast<int>(sequence.size()) != graph.size())
    throw std::invalid_argument("ordering has " + std::to_string(sequence.size()) + " nodes, the graph " +
                                std::to_string(graph.size()));
  return repaired(graph, sequence);
}

}  // namespace graphsolve
