#pragma once

#include <array>
#include <span>

#include "graphsolve/factorization.hpp"
#include "graphsolve/ordering.hpp"

namespace graphsolve {

/// Few operations, wide levels, and both at once where graphs have short separators.
inline constexpr std::array methods_for_packs{OrderingMethod::best, OrderingMethod::wide, OrderingMethod::nested_dissection};

/// The ordering to take where equal pivots are done eight at a time: of these methods, as far as they are available, the one
/// of fewest operations so counted (Symbolic::Counts::pack_operations, symmetric_pack_operations), the first of equals.
/// Costs a Symbolic for each. Throws std::invalid_argument when none is available.
Ordering cheapest_in_packs(const BlockGraph& graph, FactorizationKind kind,
                           std::span<const OrderingMethod> methods = methods_for_packs);

}  // namespace graphsolve
