#pragma once

#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "ordering/ordering_packages.hpp"

namespace graphsolve::packages {

/// What is left of a graph of constraints when regular nodes are gone that may go at once: no two of them coupled, none with
/// many neighbours. Their neighbours are coupled with each other instead. Who looks for separators finds those of few rows
/// here, which consist of constraints, and the eligibility rule has nothing to defer. A graph without saddle nodes stays whole.
class CondensedGraph {
 public:
  explicit CondensedGraph(const BlockGraph& graph);

  [[nodiscard]] int size() const { return static_cast<int>(node_.size()); }
  [[nodiscard]] const Adjacency& adjacency() const { return adjacency_; }
  [[nodiscard]] const std::vector<int>& weights() const { return weights_; }  ///< rows of each node

  /// The sequence of all nodes for one of those that are left: each that is gone goes right before the first of its neighbours.
  [[nodiscard]] std::vector<NodeId> expand(std::span<const int> order) const;

 private:
  const BlockGraph& graph_;
  std::vector<char> gone_;  ///< by node of the graph
  std::vector<int> node_, place_;  ///< of the graph by number here, and back (-1: gone)
  std::vector<int> weights_;
  Adjacency adjacency_;
};

}  // namespace graphsolve::packages
