// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_
#undef GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_
#endif

#include "graphsolve/simd/lane_blocks.hpp"
#include "graphsolve/simd/pack-inl.hpp"

/// Packs from and to places of their own for each lane, and blocks of the matrix.
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
struct StoreTimes {
  double factor;
  template <class V>
  HWY_INLINE void operator()(V a, double* to) const {
    constexpr hn::DFromV<V> tag;
    hn::StoreU(hn::Mul(hn::Set(tag, factor), a), tag, to);
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

/// Lanes h W .. h W + W - 1 of a pack of eight.
template <int W>
HWY_INLINE PackOf<W> part_of(const Pack& a, int h) {
  using P = PackOf<W>;
  if constexpr (W == lanes) {
    return a;
  } else if constexpr (Pack::width <= W) {
    P r;
    for (int i = 0; i < P::parts; ++i) r.part[i] = a.part[h * P::parts + i];
    return r;
  }
#if HWY_TARGET != HWY_SCALAR
  else if constexpr (Pack::width == 2 * W) {
    P r;
    const auto& part = a.part[h / 2];
    r.part[0] = h % 2 == 0 ? hn::LowerHalf(typename P::Tag(), part) : hn::UpperHalf(typename P::Tag(), part);
    return r;
  }
#endif
  else {
    HWY_ALIGN double all[lanes];
    store(a, all);
    return load<W>(all + h * W);
  }
}

/// What becomes of what stands in a block: it is added to, or (of blocks that were claimed, Wiring::claim) replaced.
enum class Put { add, assign };

/// put_entries where W lanes at a time lie side by side.
template <Put Way, int W, class Entry>
HWY_INLINE void put_runs(const Pack* from, int count, Entry&& entry, double* values, const LaneBlocks& to, unsigned active,
                         double sign) {
  using P = PackOf<W>;
  constexpr unsigned all = (1u << W) - 1;
  const P factor(sign);
  const auto changed = [&](const double* at, const P& a) HWY_ATTR {
    if constexpr (Way == Put::add) return multiply_add(factor, a, load<W>(at));
    else return factor * a;
  };
  for (int h = 0; h < lanes / W; ++h) {
    const unsigned some = active >> (h * W) & all;
    int stride = 0;
    const std::int64_t place = to.run(h * W, stride);
    if (some == 0 || place < 0) continue;
    double* begin = values + place;
    if (some == all) {
      for (int i = 0; i < count; ++i) {
        double* at = begin + entry(i) * stride;
        store(changed(at, part_of<W>(from[i], h)), at);
      }
      continue;
    }
    const MaskOf<W> mask = lanes_of<W>(some);
    for (int i = 0; i < count; ++i) {
      double* at = begin + entry(i) * stride;
      store(select(mask, changed(at, part_of<W>(from[i], h)), load<W>(at)), at);
    }
  }
}

/// Entry entry(i) of each lane's block: sign from[i] is put there, lane after lane; two lanes may add to the same block.
template <Put Way = Put::add, class Entry>
HWY_INLINE void put_entries(const Pack* from, int count, Entry&& entry, double* values, const LaneBlocks& to,
                            unsigned active, double sign) {
  active &= to.present();
  if (to.together() == 8) return put_runs<Way, 8>(from, count, entry, values, to, active, sign);
  if (to.together() == 4) return put_runs<Way, 4>(from, count, entry, values, to, active, sign);
  if (to.together() == 2) return put_runs<Way, 2>(from, count, entry, values, to, active, sign);
  for (int l = 0; l < lanes; ++l) {
    if (!(active >> l & 1u)) continue;
    double* at = values + to.place(l);
    const int stride = to.stride(l);
    const double* lane = reinterpret_cast<const double*>(from) + l;  // packs of eight are eight doubles
    for (int i = 0; i < count; ++i) {
      double& value = at[entry(i) * stride];
      value = (Way == Put::add ? value : 0.0) + sign * lane[i * lanes];
    }
  }
}

/// All `count` entries of the lanes' blocks, column after column. A call of its own: it is long, and joints have four.
template <Put Way = Put::add>
HWY_NOINLINE void put_blocks(const Pack* from, int count, double* values, const LaneBlocks& to, unsigned active, double sign) {
  if (to.dense() && to.together() == 1) {
    double* at[lanes];
    for (int l = 0; l < lanes; ++l) at[l] = values + to.place(l);
    active &= to.present();
    if constexpr (Way == Put::add) return add_transposed(from, count, at, active, sign);
    else return each_row(from, count, at, active, StoreTimes{sign});
  }
  put_entries<Way>(from, count, [](int i) HWY_ATTR { return i; }, values, to, active, sign);
}

/// Assigns `Count` entries of the lanes' blocks, which were claimed, one by one: in place where all eight lie side by side,
/// else by way of a copy.
template <int Count>
class BlockAssignment {
 public:
  HWY_INLINE BlockAssignment(double* values, const LaneBlocks& to, unsigned active)
      : values_(values), to_(to), active_(active), in_place_(to.together() == lanes && (to.present() & active) == 0xffu),
        at_(in_place_ ? values + to.place(0) : reinterpret_cast<double*>(copy_)) {}
  BlockAssignment(const BlockAssignment&) = delete;
  BlockAssignment& operator=(const BlockAssignment&) = delete;
  HWY_INLINE void operator()(int entry, const Pack& a) { store(a, at_ + entry * lanes); }
  /// Once every entry was assigned.
  HWY_INLINE void finish() {
    if (!in_place_) put_blocks<Put::assign>(copy_, Count, values_, to_, active_, 1.0);
  }

 private:
  double* values_;
  const LaneBlocks& to_;
  unsigned active_;
  bool in_place_;
  double* at_;
  Pack copy_[Count];
};

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
