#pragma once

#include <algorithm>

#include "graphsolve/symbolic.hpp"
#include "factorization/kernels.hpp"

namespace graphsolve {

inline constexpr int smallest_group = 6;  ///< couplings from which pivots are worth updating together

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

/// How many pivots from this one on couple what the one before couples, but for itself, and are of the size `equal` of
/// their couplings: they update what follows them together. 1: no group.
inline int group_size(const Symbolic& symbolic, int pivot, int equal) {
  const int couplings = static_cast<int>(symbolic.coupled(pivot).size());
  if (symbolic.dimension(pivot) != equal || equal > kernels::max_spread || couplings < smallest_group) return 1;
  int size = 1;
  while ((size + 1) * equal <= kernels::at_once && size < couplings && symbolic.coupled(pivot + size - 1)[0] == pivot + size &&
         static_cast<int>(symbolic.coupled(pivot + size).size()) == couplings - size)
    ++size;
  return size;
}

/// Numbers that the update of this pivot, or of the group it may begin, needs room for.
inline int spread_size(const Symbolic& symbolic, int pivot) {
  const int equal = equal_couplings(symbolic, pivot), blocks = static_cast<int>(symbolic.coupled(pivot).size());
  const int group = equal > 0 ? group_size(symbolic, pivot, equal) : 1, depth = group * symbolic.dimension(pivot);
  if (group == 1 && !in_rows(blocks, equal)) return 0;
  return kernels::spread_size(depth, blocks, equal) + (group > 1 ? blocks * depth * equal : 0);
}

}  // namespace graphsolve
