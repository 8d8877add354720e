#pragma once

#include <algorithm>

#include "graphsolve/symbolic.hpp"
#include "kernels.hpp"

namespace graphsolve {

inline constexpr int fewest_equal = 3;  ///< couplings; below, the products one by one are as fast

/// The dimension of all blocks coupled to this pivot, if it is one and small and they are several; else 0.
inline int equal_couplings(const Symbolic& symbolic, int pivot) {
  const auto coupled = symbolic.coupled(pivot);
  if (coupled.size() < fewest_equal) return 0;
  const int first = symbolic.dimension(coupled[0]);
  const bool equal = std::ranges::all_of(coupled, [&](int later) { return symbolic.dimension(later) == first; });
  return equal && first <= kernels::max_spread ? first : 0;
}

/// Numbers of the panel of that pivot when spread (kernels::Spread).
inline int spread_size(const Symbolic& symbolic, int pivot) {
  return symbolic.dimension(pivot) * equal_couplings(symbolic, pivot) * symbolic.pivot(pivot).coupled_rows;
}

}  // namespace graphsolve
