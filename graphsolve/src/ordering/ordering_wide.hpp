#pragma once

#include <cstdint>

#include "graphsolve/ordering.hpp"

namespace graphsolve {

struct CountedOrdering {
  Ordering ordering;
  std::int64_t walked = 0;  ///< entries of lists of neighbours that were looked at
};

/// wide_ordering, and what it cost.
CountedOrdering counted_wide_ordering(const BlockGraph& graph);

}  // namespace graphsolve
