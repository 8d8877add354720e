// For the kernels of graphsolve and physics; outside the version promise (docs/architecture.md).
// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PACK_TRANSPOSED_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PACK_TRANSPOSED_INL_HPP_
#undef GRAPHSOLVE_SIMD_PACK_TRANSPOSED_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PACK_TRANSPOSED_INL_HPP_
#endif

#include "graphsolve/simd/pack-inl.hpp"

/// Packs from and to places of their own for each lane.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {

/// Rows become columns: in[r] lane c -> out[c] lane r, as many as V has lanes.
template <class V>
HWY_INLINE void transpose(const V* in, V* out) {
  constexpr hn::DFromV<V> tag;
  constexpr int W = static_cast<int>(hn::MaxLanes(tag));
  if constexpr (W == 1) {
    out[0] = in[0];
  }
#if HWY_TARGET != HWY_SCALAR
  else if constexpr (W == 2) {
    out[0] = hn::InterleaveLower(tag, in[0], in[1]);
    out[1] = hn::InterleaveUpper(tag, in[0], in[1]);
  } else {
    V pairs[W];  // even places: lower halves of rows 2k and 2k + 1, odd places: upper halves
    for (int r = 0; r < W; r += 2) {
      pairs[r] = hn::InterleaveLower(tag, in[r], in[r + 1]);
      pairs[r + 1] = hn::InterleaveUpper(tag, in[r], in[r + 1]);
    }
    if constexpr (W == 4) {
      for (int k = 0; k < 2; ++k) {
        out[k] = hn::ConcatLowerLower(tag, pairs[2 + k], pairs[k]);
        out[2 + k] = hn::ConcatUpperUpper(tag, pairs[2 + k], pairs[k]);
      }
    } else {
      static_assert(W == 8);
      for (int k = 0; k < 2; ++k) {
        const V a = hn::ConcatLowerLower(tag, pairs[4 + k], pairs[k]);
        const V b = hn::ConcatLowerLower(tag, pairs[6 + k], pairs[2 + k]);
        const V c = hn::ConcatUpperUpper(tag, pairs[4 + k], pairs[k]);
        const V d = hn::ConcatUpperUpper(tag, pairs[6 + k], pairs[2 + k]);
        out[k] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a);
        out[2 + k] = hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a));
        out[4 + k] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(d), c);
        out[6 + k] = hn::OddEvenBlocks(d, hn::SwapAdjacentBlocks(c));
      }
    }
  }
#endif
}

/// The first `count` (1 .. all) doubles; the rest is zero and not read.
template <class Tag>
HWY_INLINE hn::VFromD<Tag> load_first(Tag tag, const double* from, int count) {
  constexpr int W = static_cast<int>(hn::MaxLanes(tag));
  if (count == W) return hn::LoadU(tag, from);
#if HWY_TARGET != HWY_SCALAR
  if constexpr (W == 2) return hn::InsertLane(hn::Zero(tag), 0, from[0]);
  else if constexpr (W > 2) return hn::MaskedLoad(hn::FirstN(tag, count), tag, from);
#endif
  return hn::Zero(tag);
}

/// Does f(register, its place) with the first `count` (1 .. all) doubles of a, in halves: masked stores are slow on some
/// machines.
template <class V, class F>
HWY_INLINE void each_half(V a, double* to, int count, F&& f) {
  constexpr hn::DFromV<V> tag;
  constexpr int W = static_cast<int>(hn::MaxLanes(tag));
  if (count == W) {
    f(a, to);
  }
#if HWY_TARGET != HWY_SCALAR
  else if constexpr (W > 1) {
    constexpr hn::Half<decltype(tag)> half;
    constexpr int h = W / 2;
    if (count > h) {
      f(hn::LowerHalf(half, a), to);
      each_half(hn::UpperHalf(half, a), to + h, count - h, f);
    } else {
      each_half(hn::LowerHalf(half, a), to, count, f);
    }
  }
#endif
}

struct Store {
  template <class V>
  HWY_INLINE void operator()(V a, double* to) const {
    hn::StoreU(a, hn::DFromV<V>(), to);
  }
};
struct AddTimes {
  double factor;
  template <class V>
  HWY_INLINE void operator()(V a, double* to) const {
    constexpr hn::DFromV<V> tag;
    hn::StoreU(hn::MulAdd(hn::Set(tag, factor), a, hn::LoadU(tag, to)), tag, to);
  }
};
/// `width` consecutive doubles of L places.
template <int L>
HWY_INLINE void load_transposed_block(const double* const* from, int begin, PackOf<L>* to) {
  using P = PackOf<L>;
#pragma GCC unroll 8
  for (int q = 0; q < P::parts; ++q) {
    typename P::Vector rows[P::width], columns[P::width];
#pragma GCC unroll 8
    for (int r = 0; r < P::width; ++r) rows[r] = hn::LoadU(typename P::Tag(), from[q * P::width + r] + begin);
    transpose(rows, columns);
#pragma GCC unroll 8
    for (int c = 0; c < P::width; ++c) to[begin + c].part[q] = columns[c];
  }
}

/// `count` consecutive doubles of L places become `count` packs: to[i] lane l = from[l][i]. Where only lane 0 is
/// used, the others get its numbers.
template <int L>
HWY_INLINE void load_transposed(const double* const* from, int count, PackOf<L>* to, unsigned used) {
  using P = PackOf<L>;
  if (used == 1u) {
    for (int i = 0; i < count; ++i) to[i] = P(from[0][i]);
    return;
  }
  int begin = 0;
  for (; begin + P::width <= count; begin += P::width) load_transposed_block(from, begin, to);
  if (begin == count) return;
  if (count >= P::width) {  // some once more
    load_transposed_block(from, count - P::width, to);
    return;
  }
  for (int q = 0; q < P::parts; ++q) {
    typename P::Vector rows[P::width], columns[P::width];
#pragma GCC unroll 8
    for (int r = 0; r < P::width; ++r) rows[r] = load_first(typename P::Tag(), from[q * P::width + r], count);
    transpose(rows, columns);
#pragma GCC unroll 8
    for (int c = 0; c < P::width; ++c)
      if (c < count) to[c].part[q] = columns[c];
  }
}

/// f(to[l] + i, register of from[i ..] lane l) for the lanes whose bit is set in `active`, lane after lane.
template <int L, class F>
HWY_INLINE void each_row(const PackOf<L>* from, int count, double* const* to, unsigned active, F&& f) {
  using P = PackOf<L>;
  for (int begin = 0; begin < count; begin += P::width) {
    const int some = count - begin < P::width ? count - begin : P::width;
    for (int q = 0; q < P::parts; ++q) {
      typename P::Vector rows[P::width], columns[P::width];
#pragma GCC unroll 8
      for (int c = 0; c < P::width; ++c) columns[c] = from[begin + (c < some ? c : 0)].part[q];
      transpose(columns, rows);
#pragma GCC unroll 8
      for (int r = 0; r < P::width; ++r)
        if (active >> (q * P::width + r) & 1u) each_half(rows[r], to[q * P::width + r] + begin, some, f);
    }
  }
}

/// The reverse of load_transposed: to[l][i] = from[i] lane l, for the lanes whose bit is set in `active`.
template <int L>
HWY_INLINE void store_transposed(const PackOf<L>* from, int count, double* const* to, unsigned active) {
  if (active == 1u) {
    for (int i = 0; i < count; ++i) to[0][i] = hn::GetLane(from[i].part[0]);
    return;
  }
  each_row(from, count, to, active, Store());
}

/// to[l][i] += sign from[i] lane l, lane after lane: two lanes may have the same place.
template <int L>
HWY_INLINE void add_transposed(const PackOf<L>* from, int count, double* const* to, unsigned active, double sign) {
  if (active == 1u) {
    for (int i = 0; i < count; ++i) to[0][i] += sign * hn::GetLane(from[i].part[0]);
    return;
  }
  each_row(from, count, to, active, AddTimes{sign});
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
