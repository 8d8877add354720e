#pragma once

#include <algorithm>

#include "graphsolve/symbolic.hpp"
#include "kernels.hpp"

namespace graphsolve {

/// The dimension of all blocks coupled to this pivot, if it is one and small; else 0.
inline int equal_couplings(const Symbolic& symbolic, int pivot) {
  const auto coupled = symbolic.coupled(pivot);
  if (coupled.empty()) return 0;
  const int first = symbolic.dimension(coupled[0]);
  const bool equal = std::ranges::all_of(coupled, [&](int later) { return symbolic.dimension(later) == first; });
  return equal && first <= kernels::max_equal ? first : 0;
}

/// Are so many couplings of equal dimension updated row by row? Few are as fast one by one.
constexpr bool in_rows(int couplings, int equal) { return couplings >= 3 && equal > 0 && equal <= kernels::max_spread; }

/// Numbers of the panel of that pivot when spread (kernels::Spread).
inline int spread_size(const Symbolic& symbolic, int pivot) {
  const int equal = equal_couplings(symbolic, pivot);
  if (!in_rows(static_cast<int>(symbolic.coupled(pivot).size()), equal)) return 0;
  return symbolic.dimension(pivot) * equal * symbolic.pivot(pivot).coupled_rows;
}

}  // namespace graphsolve
