// For the kernels of graphsolve and physics; outside the version promise (docs/architecture.md).
// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PACK_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PACK_INL_HPP_
#undef GRAPHSOLVE_SIMD_PACK_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PACK_INL_HPP_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "graphsolve/simd/lanes.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One number of each of L independent problems, in as many registers as the machine needs for them. Behaves like a
/// double: a law or a kernel written for a scalar type runs on it.
template <int L>
struct PackOf {
  using Tag = hn::CappedTag<double, L>;
  using Vector = hn::VFromD<Tag>;
  static constexpr int width = static_cast<int>(hn::MaxLanes(Tag()));  ///< doubles in one register
  static constexpr int parts = L / width;
  Vector part[parts];

  PackOf() = default;
  HWY_INLINE PackOf(double value) {  // NOLINT: a constant is a pack of equal numbers
    for (int i = 0; i < parts; ++i) part[i] = hn::Set(Tag(), value);
  }

#define GRAPHSOLVE_PACK_BINARY(name, operation)                                       \
  friend HWY_INLINE HWY_ATTR PackOf name(const PackOf& a, const PackOf& b) {                   \
    PackOf r;                                                                         \
    for (int i = 0; i < parts; ++i) r.part[i] = hn::operation(a.part[i], b.part[i]);  \
    return r;                                                                         \
  }
  GRAPHSOLVE_PACK_BINARY(operator+, Add)
  GRAPHSOLVE_PACK_BINARY(operator-, Sub)
  GRAPHSOLVE_PACK_BINARY(operator*, Mul)
  GRAPHSOLVE_PACK_BINARY(operator/, Div)
#undef GRAPHSOLVE_PACK_BINARY

  friend HWY_INLINE HWY_ATTR PackOf operator-(const PackOf& a) {
    PackOf r;
    for (int i = 0; i < parts; ++i) r.part[i] = hn::Neg(a.part[i]);
    return r;
  }
  friend HWY_INLINE HWY_ATTR PackOf& operator+=(PackOf& a, const PackOf& b) { return a = a + b; }
  friend HWY_INLINE HWY_ATTR PackOf& operator-=(PackOf& a, const PackOf& b) { return a = a - b; }
  friend HWY_INLINE HWY_ATTR PackOf& operator*=(PackOf& a, const PackOf& b) { return a = a * b; }
};

#define GRAPHSOLVE_PACK_FUNCTION(name, operation)                                                             \
  template <int L>                                                                                            \
  HWY_INLINE PackOf<L> name(const PackOf<L>& a) {                                                             \
    PackOf<L> r;                                                                                              \
    for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = hn::operation(a.part[i]);                          \
    return r;                                                                                                 \
  }
GRAPHSOLVE_PACK_FUNCTION(abs, Abs)
GRAPHSOLVE_PACK_FUNCTION(sqrt, Sqrt)
#undef GRAPHSOLVE_PACK_FUNCTION

#define GRAPHSOLVE_PACK_FUNCTION(name, operation)                                                             \
  template <int L>                                                                                            \
  HWY_INLINE PackOf<L> name(const PackOf<L>& a, const PackOf<L>& b) {                                         \
    PackOf<L> r;                                                                                              \
    for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = hn::operation(a.part[i], b.part[i]);               \
    return r;                                                                                                 \
  }
GRAPHSOLVE_PACK_FUNCTION(min, Min)  ///< of a NaN: either
GRAPHSOLVE_PACK_FUNCTION(max, Max)
GRAPHSOLVE_PACK_FUNCTION(bit_or, Or)  ///< of the representations: zero, but for its sign, where both are
#undef GRAPHSOLVE_PACK_FUNCTION

/// a b + c and c - a b with one rounding where the machine has it.
template <int L>
HWY_INLINE PackOf<L> multiply_add(const PackOf<L>& a, const PackOf<L>& b, const PackOf<L>& c) {
  PackOf<L> r;
  for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = hn::MulAdd(a.part[i], b.part[i], c.part[i]);
  return r;
}
template <int L>
HWY_INLINE PackOf<L> negative_multiply_add(const PackOf<L>& a, const PackOf<L>& b, const PackOf<L>& c) {
  PackOf<L> r;
  for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = hn::NegMulAdd(a.part[i], b.part[i], c.part[i]);
  return r;
}

/// One truth value per lane.
template <int L>
struct MaskOf {
  using Value = decltype(hn::Lt(typename PackOf<L>::Vector(), typename PackOf<L>::Vector()));
  static constexpr int parts = PackOf<L>::parts;
  Value part[parts];

  friend HWY_INLINE HWY_ATTR MaskOf operator&(const MaskOf& a, const MaskOf& b) {
    MaskOf r;
    for (int i = 0; i < parts; ++i) r.part[i] = hn::And(a.part[i], b.part[i]);
    return r;
  }
  friend HWY_INLINE HWY_ATTR MaskOf operator|(const MaskOf& a, const MaskOf& b) {
    MaskOf r;
    for (int i = 0; i < parts; ++i) r.part[i] = hn::Or(a.part[i], b.part[i]);
    return r;
  }
  friend HWY_INLINE HWY_ATTR MaskOf operator!(const MaskOf& a) {
    MaskOf r;
    for (int i = 0; i < parts; ++i) r.part[i] = hn::Not(a.part[i]);
    return r;
  }
};

#define GRAPHSOLVE_PACK_COMPARE(name, operation)                                                 \
  template <int L>                                                                               \
  HWY_INLINE MaskOf<L> name(const PackOf<L>& a, const PackOf<L>& b) {                            \
    MaskOf<L> r;                                                                                 \
    for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = hn::operation(a.part[i], b.part[i]);  \
    return r;                                                                                    \
  }
GRAPHSOLVE_PACK_COMPARE(operator<, Lt)
GRAPHSOLVE_PACK_COMPARE(operator<=, Le)
GRAPHSOLVE_PACK_COMPARE(operator>, Gt)
GRAPHSOLVE_PACK_COMPARE(operator>=, Ge)
#undef GRAPHSOLVE_PACK_COMPARE

/// yes where the mask is true, no elsewhere.
template <int L>
HWY_INLINE PackOf<L> select(const MaskOf<L>& mask, const PackOf<L>& yes, const PackOf<L>& no) {
  PackOf<L> r;
  for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = hn::IfThenElse(mask.part[i], yes.part[i], no.part[i]);
  return r;
}

/// Bit l: lane l.
template <int L>
HWY_INLINE unsigned bits(const MaskOf<L>& mask) {
  constexpr int width = PackOf<L>::width;
  unsigned r = 0;
  for (int i = 0; i < PackOf<L>::parts; ++i) {
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(typename PackOf<L>::Tag(), mask.part[i], byte);
    r |= (byte[0] & ((1u << width) - 1)) << (i * width);
  }
  return r;
}

/// L consecutive doubles, aligned to a register or not.
template <int L>
HWY_INLINE PackOf<L> load(const double* from) {
  using P = PackOf<L>;
  P r;
  for (int i = 0; i < P::parts; ++i) r.part[i] = hn::LoadU(typename P::Tag(), from + i * P::width);
  return r;
}
template <int L>
HWY_INLINE void store(const PackOf<L>& a, double* to) {
  using P = PackOf<L>;
  for (int i = 0; i < P::parts; ++i) hn::StoreU(a.part[i], typename P::Tag(), to + i * P::width);
}

/// W numbers of their own, f(first), f(first + 1), ...
template <int W, class F>
HWY_INLINE hn::VFromD<hn::CappedTag<double, W>> vector_of(F&& f, int first) {
  constexpr hn::CappedTag<double, W> tag;
#if HWY_TARGET != HWY_SCALAR
  if constexpr (W == 2) return hn::InterleaveLower(tag, hn::Set(tag, f(first)), hn::Set(tag, f(first + 1)));
  else if constexpr (W > 2) return hn::Combine(tag, vector_of<W / 2>(f, first + W / 2), vector_of<W / 2>(f, first));
  else
#endif
    return hn::Set(tag, f(first));
}
/// Lane l: f(l).
template <int L, class F>
HWY_INLINE PackOf<L> each_lane(F&& f) {
  PackOf<L> r;
  for (int i = 0; i < PackOf<L>::parts; ++i) r.part[i] = vector_of<PackOf<L>::width>(f, i * PackOf<L>::width);
  return r;
}

template <int L>
inline constexpr unsigned all_lanes = (1u << L) - 1;

/// True where the bit is set.
template <int L>
HWY_INLINE MaskOf<L> lanes_of(unsigned set) {
  MaskOf<L> r;
  for (int i = 0; i < PackOf<L>::parts; ++i) {
    const std::uint8_t byte[8] = {static_cast<std::uint8_t>(set >> (i * PackOf<L>::width))};
    r.part[i] = hn::LoadMaskBits(typename PackOf<L>::Tag(), byte);
  }
  return r;
}

using Pack = PackOf<lanes>;  ///< 64 bytes in memory, on every machine
using Mask = MaskOf<lanes>;

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
