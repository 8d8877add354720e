#include "ordering/ordering_packages.hpp"

#include <algorithm>

namespace graphsolve::packages {

Adjacency adjacency(const BlockGraph& graph) {
  Adjacency result;
  result.begin.reserve(graph.size() + 1);
  result.begin.push_back(0);
  for (int i = 0; i < graph.size(); ++i) {
    for (const auto& edge : graph.edges({i})) result.list.push_back(edge.to.index);
    std::sort(result.list.begin() + result.begin.back(), result.list.end());
    result.begin.push_back(static_cast<int>(result.list.size()));
  }
  return result;
}

std::vector<NodeId> to_nodes(const std::vector<int>& order) {
  std::vector<NodeId> nodes;
  nodes.reserve(order.size());
  for (const int i : order) nodes.push_back({i});
  return nodes;
}

}  // namespace graphsolve::packages
