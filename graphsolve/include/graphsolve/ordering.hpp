#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/ordering_method.hpp"

namespace graphsolve {

/// An elimination order. Made by one of the functions below, all of which obey the eligibility rule:
///
///   A saddle node may be eliminated when all its regular and semidefinite neighbours are eliminated, or when
///   one of them, across a full-row-rank edge, was eliminated whose other saddle neighbours had all been
///   eliminated before it. A semidefinite node likewise waits for its saddle neighbours: for all of them, or
///   for one across a full-column-rank edge whose other semidefinite neighbours had all been eliminated before.
///   Nobody waits for shared nodes.
///
/// Under it no pivot of a regular saddle system is singular whose terms are positive definite on all regular nodes
/// together: the eliminated rows of J are independent on the eliminated columns (block triangular in the private hosts,
/// for the others complete rows, but for shared nodes, as that kind promises), and so are the costless columns on the
/// eliminated rows. An order that knows nothing of the rule is repaired by deferring the ineligible node until it
/// becomes eligible.
///
/// Regular nodes that are coupled with each other, and definite only together with constraints on single ones of them
/// (a network whose level one constraint holds), end at a singular pivot where a held node comes last. So each such
/// constraint comes right after its node, and another node of the network last. The user's own order is not changed.
///
/// Without semidefinite nodes some node is always eligible. With them all may come to wait for each other: in
/// [0 -J^T; J 0] no block by itself can be a pivot, and an order may use up a host while several saddle nodes wait at
/// it. Then one node is taken against the rule, and counted.
struct Ordering {
  std::vector<NodeId> sequence = {};  ///< every node once, first eliminated first
  int repairs = 0;                    ///< nodes that were deferred by the rule
  int forced = 0;                     ///< nodes taken against the rule because nothing was eligible
  OrderingMethod method = OrderingMethod::user;  ///< who made it; of `best` the one that was chosen
};

/// Follows an elimination and answers which nodes may come next.
class Eligibility {
 public:
  /// Refers to the graph, which must outlive it.
  explicit Eligibility(const BlockGraph& graph);
  [[nodiscard]] bool eligible(NodeId node) const { return eligible_[node.index] != 0; }
  /// Marks the node eliminated; nodes that become eligible by it are appended to `freed`.
  void eliminate(NodeId node, std::vector<NodeId>& freed);

 private:
  void free_node(int node, std::vector<NodeId>& freed);
  const BlockGraph& graph_;
  std::vector<char> eliminated_, eligible_;
  std::vector<int> waiting_;  ///< per saddle or semidefinite node: neighbours it waits for
};

/// The order by the method asked for. Equal graphs get equal orders.
/// Throws std::invalid_argument when the method is not available in this build, or is `user`.
Ordering make_ordering(const BlockGraph& graph, OrderingMethod method);

/// The order in which the nodes were added.
Ordering natural_ordering(const BlockGraph& graph);

/// Depth-first search from `root` (default: the first node of each component), the first found node last
/// (paper, section III-B). Throws std::invalid_argument when the root is not in the graph.
Ordering depth_first_ordering(const BlockGraph& graph, NodeId root = {});

/// Repeatedly eliminates the eligible node that adds the fewest scalars of fill; among equals the one that
/// became free first, which lays independent neighbours side by side. Exact for nodes of at most 12 neighbours,
/// an upper bound for the others. Where none is eligible the ineligible node of least fill is taken. The default
/// everywhere.
Ordering minimum_fill_ordering(const BlockGraph& graph);

/// Rounds of independent nodes, for a low elimination tree with wide levels: a round takes eligible nodes of at most
/// two neighbours, no two of them coupled (rake and compress); where there are none, those of about the least fill.
/// Within a round equal shapes (dimension, rows of the neighbours) stand side by side: equal pivots that do not wait
/// for each other. A chain of n nodes gets a tree of height O(log n), at most 2.5 times the operations of no fill.
Ordering wide_ordering(const BlockGraph& graph);

/// The user's own sequence, repaired where it breaks the rule. Throws std::invalid_argument when it is not
/// a permutation of the nodes.
Ordering user_ordering(const BlockGraph& graph, std::span<const NodeId> sequence);

/// What Symbolic::Counts would say.
struct PredictedCost {
  std::int64_t fill_blocks = 0, stored_scalars = 0, operations = 0;
};
/// Costs O(blocks of the factor) time, but memory for the nodes only. Stops soon after most_blocks blocks off the
/// diagonal, one triangle, and is a lower bound then. Throws std::invalid_argument when the ordering is not one of the
/// graph.
PredictedCost predict_cost(const BlockGraph& graph, const Ordering& ordering,
                           std::int64_t most_blocks = std::numeric_limits<std::int64_t>::max());

}  // namespace graphsolve
