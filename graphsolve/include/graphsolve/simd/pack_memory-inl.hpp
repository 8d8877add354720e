// For the kernels of graphsolve and physics; outside the version promise (docs/architecture.md).
// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_
#undef GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PACK_MEMORY_INL_HPP_
#endif

#include "graphsolve/simd/lane_blocks.hpp"
#include "graphsolve/simd/pack_transposed-inl.hpp"

/// Packs into blocks of the matrix, however the lanes' blocks lie.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {

/// What becomes of what stands in a block: it is added to, or (of blocks that were claimed, Wiring::claim) replaced; then
/// the sign is 1.
enum class Put { add, assign };

/// put_entries where W lanes at a time lie side by side.
template <Put Way, int W, class Entry>
HWY_INLINE void put_runs(const Pack* from, int count, Entry&& entry, double* values, const LaneBlocks& to, unsigned active,
                         double sign) {
  using P = PackOf<W>;
  constexpr unsigned all = (1u << W) - 1;
  const P factor(sign);
  for (int h = 0; h < lanes / W; ++h) {
    const unsigned some = active >> (h * W) & all;
    int stride = 0;
    const std::int64_t place = to.run(h * W, stride);
    if (some == 0 || place < 0) continue;
    double* begin = values + place;
    const double* given = reinterpret_cast<const double*>(from) + h * W;  // packs of eight are eight doubles
    const auto changed = [&](int i, const double* at) HWY_ATTR {
      const P a = load<W>(given + i * lanes);
      if constexpr (Way == Put::add) return multiply_add(factor, a, load<W>(at));
      else return a;
    };
    if (some == all) {
#pragma GCC unroll 4
      for (int i = 0; i < count; ++i) {
        double* at = begin + entry(i) * stride;
        store(changed(i, at), at);
      }
      continue;
    }
    const MaskOf<W> mask = lanes_of<W>(some);
    for (int i = 0; i < count; ++i) {
      double* at = begin + entry(i) * stride;
      store(select(mask, changed(i, at), load<W>(at)), at);
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
    const double* lane = reinterpret_cast<const double*>(from) + l;
#pragma GCC unroll 4
    for (int i = 0; i < count; ++i) {
      double& value = at[entry(i) * stride];
      if constexpr (Way == Put::add) value += sign * lane[i * lanes];
      else value = lane[i * lanes];
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
    else return each_row(from, count, at, active, Store());
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
