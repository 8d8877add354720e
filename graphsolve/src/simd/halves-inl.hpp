// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_HALVES_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_HALVES_INL_HPP_
#undef GRAPHSOLVE_SIMD_HALVES_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_HALVES_INL_HPP_
#endif

#include "simd/pack_dense-inl.hpp"

/// Pivots of an even dimension whose halves nothing couples: two of half the size.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {

/// The halves on the diagonal of a block.
template <int D, int L>
struct Halves {
  static_assert(D % 2 == 0);
  static constexpr int half = D / 2;
  PackOf<L> first[half * half], second[half * half];
};

/// Does nothing couple the halves of a block, in any lane? NaN couples.
template <int D, int L>
HWY_INLINE bool halves_apart(const double* a) {
  constexpr int half = D / 2;
  PackOf<L> below(0.0), right(0.0);
#pragma GCC unroll 6
  for (int c = 0; c < half; ++c)
#pragma GCC unroll 6
    for (int r = half; r < D; ++r) {
      below = bit_or(below, load<L>(a + (c * D + r) * L));
      right = bit_or(right, load<L>(a + (r * D + c) * L));
    }
  return bits(abs(bit_or(below, right)) <= PackOf<L>(0.0)) == all_lanes<L>;
}

template <int D, int L>
HWY_INLINE void load_halves(const double* from, Halves<D, L>& halves) {
  constexpr int half = D / 2;
#pragma GCC unroll 6
  for (int c = 0; c < half; ++c)
#pragma GCC unroll 6
    for (int r = 0; r < half; ++r) {
      halves.first[c * half + r] = load<L>(from + (c * D + r) * L);
      halves.second[c * half + r] = load<L>(from + ((half + c) * D + half + r) * L);
    }
}

template <int D, int L>
HWY_INLINE void store_halves(const Halves<D, L>& halves, double* to) {
  constexpr int half = D / 2;
#pragma GCC unroll 6
  for (int c = 0; c < half; ++c)
#pragma GCC unroll 6
    for (int r = 0; r < half; ++r) {
      store(halves.first[c * half + r], to + (c * D + r) * L);
      store(halves.second[c * half + r], to + ((half + c) * D + half + r) * L);
    }
}

template <int D, int L>
HWY_INLINE void solve_all_halves(const Halves<D, L>& lu, double* w, int columns) {
  constexpr int half = D / 2;
  for (int c = 0; c < 2 * columns; c += 2) {
    solve_in_place<half, 1>(lu.first, w + c * half * L, half);
    solve_in_place<half, 1>(lu.second, w + (c + 1) * half * L, half);
  }
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
