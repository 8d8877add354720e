#pragma once

#include <cstdint>

#include "graphsolve/ordering.hpp"

namespace graphsolve {

struct CountedOrdering {
  Ordering ordering;
  std::int64_t walked = 0;   ///< entries of lists of neighbours that were looked at or moved
  std::int64_t waiting = 0;  ///< nodes that waited and were looked at, over all rounds
};

/// minimum_fill_ordering and wide_ordering, and what they cost.
CountedOrdering counted_minimum_fill_ordering(const BlockGraph& graph);
CountedOrdering counted_wide_ordering(const BlockGraph& graph);

}  // namespace graphsolve
