#pragma once

#include <cstdint>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/ordering.hpp"

namespace graphsolve {

/// Pivot number of every node. Throws std::invalid_argument when the ordering is not a permutation of the nodes.
std::vector<int> positions(const BlockGraph& graph, const Ordering& ordering);

/// Elimination tree in pivot numbers, and per pivot what stands under it in the factor. Enough to count by; costs
/// O(blocks of the factor) time, but memory for the nodes only.
struct EliminationTree {
  EliminationTree(const BlockGraph& graph, const Ordering& ordering, const std::vector<int>& position);
  std::vector<int> parent, rows_below, blocks_below;
};

/// What Symbolic::Counts would say.
struct PredictedCost {
  std::int64_t fill_blocks = 0, stored_scalars = 0, operations = 0;
};
PredictedCost predict_cost(const BlockGraph& graph, const Ordering& ordering);

}  // namespace graphsolve
