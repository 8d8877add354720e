#pragma once

#include <optional>
#include <vector>

#include "graphsolve/fill_analysis.hpp"

namespace graphsolve {

/// The edge whose removal saves most operations, among those of the causes that are components; `causes` is sorted,
/// most expensive first. Nothing where no edge tried saves any.
std::optional<EdgeSaving> find_edge_saving(const BlockGraph& graph, const Symbolic& symbolic,
                                           const std::vector<FillCause>& causes);

}  // namespace graphsolve
