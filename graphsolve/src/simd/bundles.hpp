#pragma once

#include <array>
#include <bit>
#include <span>
#include <vector>

#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/symbolic.hpp"

namespace graphsolve::simd {

/// Pivots of one component, of one shape and one level of the elimination tree, in lanes. Lanes that are not used
/// repeat one that is.
struct Bundle {
  int lanes;                           ///< 1, 2, 4 or 8
  unsigned used;                       ///< bit per lane that has a pivot
  std::array<int, simd::lanes> pivot;  ///< from the first of the component on
  /// In the first lane that is used; one always is.
  [[nodiscard]] int first_pivot() const { return pivot[std::countr_zero(used) % simd::lanes]; }
};

/// The elimination of the pivots begin .. end - 1, a component, in the order in which it goes and lies in memory: bundles
/// of pivots that do not depend on each other, subtree after subtree. shape: by pivot.
///
/// All that a pivot changes are its ancestors. Pivots therefore take the lanes of their parents where that fills a
/// bundle well enough: then subtrees of one form lie lane by lane side by side, and what eight pivots change are eight
/// lanes of one bundle again.
std::vector<Bundle> bundles(const Symbolic& symbolic, int begin, int end, std::span<const int> shape);

/// Smallest number of lanes for so many pivots.
constexpr int lanes_for(int pivots) { return pivots > 4 ? 8 : pivots > 2 ? 4 : pivots; }

}  // namespace graphsolve::simd
