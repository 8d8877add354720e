#pragma once

#include <string_view>

#include "graphsolve/symbolic.hpp"

namespace graphsolve {

/// Has this Symbolic the nodes of this graph? Throws std::invalid_argument, "`who`: the graph has ...", where not. Couplings
/// are not compared: whoever asks for a block that is not there is told so.
void check_same_nodes(const Symbolic& symbolic, const BlockGraph& graph, std::string_view who);

}  // namespace graphsolve
