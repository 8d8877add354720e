#include "symbolic/elimination_tree.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "symbolic/operations.hpp"

namespace graphsolve {

std::vector<int> positions(const BlockGraph& graph, const Ordering& ordering) {
  std::vector<int> position(graph.size(), -1);
  if (static_cast<int>(ordering.sequence.size()) != graph.size())
    throw std::invalid_argument("ordering has " + std::to_string(ordering.sequence.size()) + " nodes, the graph " +
                                std::to_string(graph.size()));
  for (int k = 0; k < graph.size(); ++k) {
    const int node = ordering.sequence[k].index;
    if (node < 0 || node >= graph.size() || position[node] >= 0)
      throw std::invalid_argument("ordering is not a permutation of the nodes");
    position[node] = k;
  }
  return position;
}

EliminationTree::EliminationTree(const BlockGraph& graph, const Ordering& ordering, const std::vector<int>& position,
                                 std::int64_t most_blocks)
    : parent(graph.size(), -1), rows_below(graph.size(), 0), blocks_below(graph.size(), 0) {
  const int n = graph.size();
  std::vector<int> seen(n, -1);
  std::int64_t blocks = 0;
  // Row k of the factor: from each earlier neighbour up the tree.
  for (int k = 0; k < n && blocks <= most_blocks; ++k) {
    const NodeId node = ordering.sequence[k];
    seen[k] = k;
    for (const auto& edge : graph.edges(node))
      for (int i = position[edge.to.index]; i < k && seen[i] != k; i = parent[i]) {
        seen[i] = k;
        rows_below[i] += graph.dimension(node);
        ++blocks_below[i];
        ++blocks;
        if (parent[i] < 0) parent[i] = k;
      }
  }
}

PredictedCost predict_cost(const BlockGraph& graph, const Ordering& ordering, std::int64_t most_blocks) {
  const EliminationTree tree(graph, ordering, positions(graph, ordering), most_blocks);
  PredictedCost cost;
  std::int64_t ends = 0;  // of edges
  for (int k = 0; k < graph.size(); ++k) {
    const NodeId node = ordering.sequence[k];
    const std::int64_t d = graph.dimension(node), rows = tree.rows_below[k];
    add_operations(cost.operations, lu_pivot_operations(d, rows));
    cost.stored_scalars += d * d + 2 * d * rows;
    cost.fill_blocks += tree.blocks_below[k];
    ends += static_cast<std::int64_t>(graph.edges(node).size());
  }
  cost.fill_blocks = std::max(cost.fill_blocks - ends / 2, std::int64_t{0});
  return cost;
}

}  // namespace graphsolve
