#include "graphsolve/block_graph.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace graphsolve {

namespace {

EdgeRank join(EdgeRank a, EdgeRank b) {
  if (a == b || b == EdgeRank::unknown) return a;
  if (a == EdgeRank::unknown) return b;
  return EdgeRank::full;
}

}  // namespace

void BlockGraph::reserve(int nodes) {
  nodes_.reserve(nodes);
  adjacency_.reserve(nodes);
}

NodeId BlockGraph::add_node(std::string name, int dimension, NodeKind kind) {
  if (dimension < 1) throw std::invalid_argument("node '" + name + "': dimension " + std::to_string(dimension) + " < 1");
  if (dimension > largest_dimension)
    throw std::invalid_argument("node '" + name + "': dimension " + std::to_string(dimension) +
                                " is more than a dense block may have (" + std::to_string(largest_dimension) + ")");
  if (dimension > std::numeric_limits<int>::max() - rows_)
    throw std::invalid_argument("node '" + name + "': with its " + std::to_string(dimension) + " rows the graph has too many");
  nodes_.push_back({std::move(name), dimension, rows_, kind});
  adjacency_.emplace_back();
  rows_ += dimension;
  return {size() - 1};
}

void BlockGraph::add_edge(NodeId a, NodeId b, EdgeRank rank) {
  if (a.index < 0 || b.index < 0 || a.index >= size() || b.index >= size())
    throw std::invalid_argument("edge to a node that is not in the graph");
  if (a == b) throw std::invalid_argument("node '" + nodes_[a.index].name + "': edge to itself");
  // The shorter list is searched, so that a hub with many neighbours costs nothing extra.
  if (adjacency_[a.index].size() > adjacency_[b.index].size()) std::swap(a, b);
  auto& from = adjacency_[a.index];
  const auto known = std::find_if(from.begin(), from.end(), [&](const Edge& e) { return e.to == b; });
  if (known == from.end()) {
    from.push_back({b, rank});
    adjacency_[b.index].push_back({a, rank});
    return;
  }
  if (rank == EdgeRank::unknown) return;
  known->rank = join(known->rank, rank);
  auto& back = adjacency_[b.index];
  std::find_if(back.begin(), back.end(), [&](const Edge& e) { return e.to == a; })->rank = known->rank;
}

Components connected_components(const BlockGraph& graph) {
  Components result;
  result.of_node.assign(graph.size(), -1);
  std::vector<int> stack;
  for (int start = 0; start < graph.size(); ++start) {
    if (result.of_node[start] >= 0) continue;
    result.of_node[start] = result.count;
    stack.push_back(start);
    while (!stack.empty()) {
      const int node = stack.back();
      stack.pop_back();
      for (const auto& edge : graph.edges({node})) {
        if (result.of_node[edge.to.index] >= 0) continue;
        result.of_node[edge.to.index] = result.count;
        stack.push_back(edge.to.index);
      }
    }
    ++result.count;
  }
  return result;
}

}  // namespace graphsolve
