#include "graphsolve/cheapest_ordering.hpp"

#include <optional>
#include <stdexcept>
#include <utility>

namespace graphsolve {

Ordering cheapest_in_packs(const BlockGraph& graph, FactorizationKind kind, std::span<const OrderingMethod> methods) {
  std::optional<Ordering> cheapest;
  std::int64_t least = 0;
  for (const OrderingMethod method : methods) {
    if (!available(method)) continue;
    Ordering ordering = make_ordering(graph, method);
    // A singular pivot costs more than any fill: an order that breaks the rule oftener is never better.
    if (cheapest && ordering.forced > cheapest->forced) continue;
    const Symbolic::Counts counts = Symbolic(graph, ordering).counts();
    const std::int64_t cost = kind == FactorizationKind::ldu ? counts.pack_operations : counts.symmetric_pack_operations;
    if (cheapest && ordering.forced == cheapest->forced && cost >= least) continue;
    least = cost;
    cheapest = std::move(ordering);
  }
  if (!cheapest) throw std::invalid_argument("ordering: none of the methods given is available in this build");
  return *std::move(cheapest);
}

}  // namespace graphsolve
