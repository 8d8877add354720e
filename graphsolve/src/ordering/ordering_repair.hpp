#pragma once

#include <span>

#include "graphsolve/ordering.hpp"

namespace graphsolve {

/// The sequence (every node once), with every node that comes too early deferred to the moment it becomes eligible.
Ordering repaired(const BlockGraph& graph, std::span<const NodeId> sequence);

}  // namespace graphsolve
