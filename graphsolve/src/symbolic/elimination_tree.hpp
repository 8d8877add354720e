#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/ordering.hpp"

namespace graphsolve {

/// Pivot number of every node. Throws std::invalid_argument when the ordering is not a permutation of the nodes.
std::vector<int> positions(const BlockGraph& graph, const Ordering& ordering);

/// Elimination tree in pivot numbers, and per pivot what stands under it in the factor. Enough to count by; costs
/// O(blocks of the factor) time, but memory for the nodes only.
struct EliminationTree {
  /// Stops after the node that brings the blocks off the diagonal above `most_blocks`.
  EliminationTree(const BlockGraph& graph, const Ordering& ordering, const std::vector<int>& position,
                  std::int64_t most_blocks = std::numeric_limits<std::int64_t>::max());
  std::vector<int> parent, rows_below, blocks_below;
};

}  // namespace graphsolve
