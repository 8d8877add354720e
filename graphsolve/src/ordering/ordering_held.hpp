#pragma once

#include "graphsolve/ordering.hpp"

namespace graphsolve {

/// Regular nodes that are coupled with each other (a network of pipes, resistors or springs) are seldom definite together
/// where constraints on single nodes hold them. Such a constraint comes right after its node, and of a network some other
/// node comes last: when its turn comes all that holds the network is in place. Costs a coupling of that node with each
/// constraint that it used to precede; where regular nodes are not coupled directly nothing changes.
void hold_networks_early(const BlockGraph& graph, Ordering& ordering);

}  // namespace graphsolve
