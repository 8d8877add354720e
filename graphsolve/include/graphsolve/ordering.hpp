#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "graphsolve/block_graph.hpp"

namespace graphsolve {

/// An elimination order. Made by one of the functions below, all of which obey the eligibility rule:
///
///   A saddle node may be eliminated when all its regular neighbours are eliminated, or when one of them,
///   across a full-row-rank edge, was eliminated whose other saddle neighbours had all been eliminated
///   before it. (A semidefinite node likewise, with the roles and the rank of the edge exchanged.)
///
/// Under it no pivot block of a regular saddle system with monotone terms is singular. An order that knows
/// nothing of the rule is repaired by deferring the ineligible node until it becomes eligible.
struct Ordering {
  std::vector<NodeId> sequence;  ///< every node once, first eliminated first
  int repairs = 0;               ///< nodes that were deferred by the rule
  int forced = 0;                ///< nodes taken against the rule because nothing was eligible
};

/// Follows an elimination and answers which nodes may come next.
class Eligibility {
 public:
  explicit Eligibility(const BlockGraph& graph);
  [[nodiscard]] bool eligible(NodeId node) const { return eligible_[node.index] != 0; }
  /// Marks the node eliminated; nodes that become eligible by it are appended to `freed`.
  void eliminate(NodeId node, std::vector<NodeId>& freed);

 private:
  void free_node(int node, std::vector<NodeId>& freed);
  const BlockGraph& graph_;
  std::vector<char> eliminated_, eligible_;
  std::vector<int> waiting_;  ///< per saddle or semidefinite node: counterparts still to be eliminated
};

/// The order in which the nodes were added.
Ordering natural_ordering(const BlockGraph& graph);

/// Depth-first search from `root` (default: the first node of each component), the first found node last
/// (paper, section III-B).
Ordering depth_first_ordering(const BlockGraph& graph, NodeId root = {});

/// Repeatedly eliminates the eligible node that adds the fewest scalars of fill; among equals the one that
/// became free first, which lays independent neighbours side by side. Exact for nodes of small degree,
/// an upper bound for the others. The default everywhere.
Ordering minimum_fill_ordering(const BlockGraph& graph);

/// The user's own sequence, repaired where it breaks the rule. Throws std::invalid_argument when it is not
/// a permutation of the nodes.
Ordering user_ordering(const BlockGraph& graph, std::span<const NodeId> sequence);

}  // namespace graphsolve
