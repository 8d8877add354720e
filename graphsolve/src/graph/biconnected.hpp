#pragma once

#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"

namespace graphsolve {

/// Biconnected components of three nodes and more, by Boost.Graph. Two of them share one node at most.
class Biconnected {
 public:
  explicit Biconnected(const BlockGraph& graph);
  struct Part {
    std::vector<NodeId> nodes;  ///< ascending
    int edges = 0;
  };
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  /// The part that holds both nodes, or -1.
  [[nodiscard]] int common(NodeId a, NodeId b) const;

 private:
  [[nodiscard]] std::span<const int> parts_of(NodeId node) const {
    return {list_.data() + begin_[node.index], list_.data() + begin_[node.index + 1]};
  }
  std::vector<Part> parts_;
  std::vector<int> begin_, list_;  ///< parts of each node, ascending
};

}  // namespace graphsolve
