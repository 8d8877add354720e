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

using VectorTag = hn::CappedTag<double, lanes>;
using Vector = hn::VFromD<VectorTag>;
using VectorMask = decltype(hn::Lt(Vector(), Vector()));
inline constexpr int width = static_cast<int>(hn::MaxLanes(VectorTag()));  ///< doubles in one register
inline constexpr int parts = lanes / width;

/// One number of each of eight independent problems, in as many registers as the machine needs for them. Behaves
/// like a double: a law or a kernel written for a scalar type runs on it. 64 bytes in memory, on every machine.
struct Pack {
  Vector part[parts];

  Pack() = default;
  HWY_INLINE Pack(double value) {  // NOLINT: a constant is a pack of equal numbers
    for (int i = 0; i < parts; ++i) part[i] = hn::Set(VectorTag(), value);
  }
};

/// One truth value per lane.
struct Mask {
  VectorMask part[parts];
};

/// Eight consecutive doubles, aligned to a register or not.
HWY_INLINE Pack load(const double* from) {
  Pack r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::LoadU(VectorTag(), from + i * width);
  return r;
}
HWY_INLINE void store(const Pack& a, double* to) {
  for (int i = 0; i < parts; ++i) hn::StoreU(a.part[i], VectorTag(), to + i * width);
}

#define GRAPHSOLVE_PACK_BINARY(name, operation)                                   \
  HWY_INLINE Pack name(const Pack& a, const Pack& b) {                            \
    Pack r;                                                                       \
    for (int i = 0; i < parts; ++i) r.part[i] = hn::operation(a.part[i], b.part[i]); \
    return r;                                                                     \
  }
GRAPHSOLVE_PACK_BINARY(operator+, Add)
GRAPHSOLVE_PACK_BINARY(operator-, Sub)
GRAPHSOLVE_PACK_BINARY(operator*, Mul)
GRAPHSOLVE_PACK_BINARY(operator/, Div)
GRAPHSOLVE_PACK_BINARY(min, Min)  ///< of a NaN: either
GRAPHSOLVE_PACK_BINARY(max, Max)
#undef GRAPHSOLVE_PACK_BINARY

#define GRAPHSOLVE_PACK_UNARY(name, operation)                         \
  HWY_INLINE Pack name(const Pack& a) {                                \
    Pack r;                                                            \
    for (int i = 0; i < parts; ++i) r.part[i] = hn::operation(a.part[i]); \
    return r;                                                          \
  }
GRAPHSOLVE_PACK_UNARY(operator-, Neg)
GRAPHSOLVE_PACK_UNARY(abs, Abs)
GRAPHSOLVE_PACK_UNARY(sqrt, Sqrt)
#undef GRAPHSOLVE_PACK_UNARY

HWY_INLINE Pack& operator+=(Pack& a, const Pack& b) { return a = a + b; }
HWY_INLINE Pack& operator-=(Pack& a, const Pack& b) { return a = a - b; }
HWY_INLINE Pack& operator*=(Pack& a, const Pack& b) { return a = a * b; }

/// a b + c and c - a b with one rounding where the machine has it.
HWY_INLINE Pack multiply_add(const Pack& a, const Pack& b, const Pack& c) {
  Pack r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::MulAdd(a.part[i], b.part[i], c.part[i]);
  return r;
}
HWY_INLINE Pack negative_multiply_add(const Pack& a, const Pack& b, const Pack& c) {
  Pack r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::NegMulAdd(a.part[i], b.part[i], c.part[i]);
  return r;
}

#define GRAPHSOLVE_PACK_COMPARE(name, operation)                                  \
  HWY_INLINE Mask name(const Pack& a, const Pack& b) {                            \
    Mask r;                                                                       \
    for (int i = 0; i < parts; ++i) r.part[i] = hn::operation(a.part[i], b.part[i]); \
    return r;                                                                     \
  }
GRAPHSOLVE_PACK_COMPARE(operator<, Lt)
GRAPHSOLVE_PACK_COMPARE(operator<=, Le)
GRAPHSOLVE_PACK_COMPARE(operator>, Gt)
GRAPHSOLVE_PACK_COMPARE(operator>=, Ge)
#undef GRAPHSOLVE_PACK_COMPARE

HWY_INLINE Mask operator&(const Mask& a, const Mask& b) {
  Mask r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::And(a.part[i], b.part[i]);
  return r;
}
HWY_INLINE Mask operator|(const Mask& a, const Mask& b) {
  Mask r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::Or(a.part[i], b.part[i]);
  return r;
}
HWY_INLINE Mask operator!(const Mask& a) {
  Mask r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::Not(a.part[i]);
  return r;
}

/// yes where the mask is true, no elsewhere.
HWY_INLINE Pack select(const Mask& mask, const Pack& yes, const Pack& no) {
  Pack r;
  for (int i = 0; i < parts; ++i) r.part[i] = hn::IfThenElse(mask.part[i], yes.part[i], no.part[i]);
  return r;
}

/// Bit l: lane l.
HWY_INLINE unsigned bits(const Mask& mask) {
  unsigned r = 0;
  for (int i = 0; i < parts; ++i) {
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(VectorTag(), mask.part[i], byte);
    r |= (byte[0] & ((1u << width) - 1)) << (i * width);
  }
  return r;
}

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void transpose(const Vector* in, Vector* out) { out[0] = in[0]; }
HWY_INLINE Vector load_first(const double* from, int) { return hn::LoadU(VectorTag(), from); }
HWY_INLINE void store_first(Vector a, double* to, int) { hn::StoreU(a, VectorTag(), to); }
HWY_INLINE void add_first(Vector factor, Vector a, double* to, int) {
  hn::StoreU(hn::MulAdd(factor, a, hn::LoadU(VectorTag(), to)), VectorTag(), to);
}

#else

/// Rows become columns: in[r] lane c -> out[c] lane r.
template <int W = width>
HWY_INLINE void transpose(const Vector* in, Vector* out) {
  if constexpr (W == 2) {
    out[0] = hn::InterleaveLower(VectorTag(), in[0], in[1]);
    out[1] = hn::InterleaveUpper(VectorTag(), in[0], in[1]);
  } else {
    Vector pairs[W];  // even places: lower halves of rows 2k and 2k + 1, odd places: upper halves
    for (int r = 0; r < W; r += 2) {
      pairs[r] = hn::InterleaveLower(VectorTag(), in[r], in[r + 1]);
      pairs[r + 1] = hn::InterleaveUpper(VectorTag(), in[r], in[r + 1]);
    }
    if constexpr (W == 4) {
      for (int k = 0; k < 2; ++k) {
        out[k] = hn::ConcatLowerLower(VectorTag(), pairs[2 + k], pairs[k]);
        out[2 + k] = hn::ConcatUpperUpper(VectorTag(), pairs[2 + k], pairs[k]);
      }
    } else {
      static_assert(W == 8);
      for (int k = 0; k < 2; ++k) {
        const Vector a = hn::ConcatLowerLower(VectorTag(), pairs[4 + k], pairs[k]);
        const Vector b = hn::ConcatLowerLower(VectorTag(), pairs[6 + k], pairs[2 + k]);
        const Vector c = hn::ConcatUpperUpper(VectorTag(), pairs[4 + k], pairs[k]);
        const Vector d = hn::ConcatUpperUpper(VectorTag(), pairs[6 + k], pairs[2 + k]);
        out[k] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a);
        out[2 + k] = hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a));
        out[4 + k] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(d), c);
        out[6 + k] = hn::OddEvenBlocks(d, hn::SwapAdjacentBlocks(c));
      }
    }
  }
}

/// The first `count` (1 .. width) doubles; the rest is zero and not read.
template <int W = width>
HWY_INLINE Vector load_first(const double* from, int count) {
  if (count == W) return hn::LoadU(VectorTag(), from);
  if constexpr (W == 2) return hn::InsertLane(hn::Zero(VectorTag()), 0, from[0]);
  else return hn::MaskedLoad(hn::FirstN(VectorTag(), count), VectorTag(), from);
}

/// Writes only the first `count` (1 .. width) doubles, in halves: masked stores are slow on some machines.
template <class V>
HWY_INLINE void store_first(V a, double* to, int count) {
  constexpr hn::DFromV<V> tag;
  constexpr int lanes_here = static_cast<int>(hn::MaxLanes(tag));
  if (count == lanes_here) {
    hn::StoreU(a, tag, to);
  } else if constexpr (lanes_here > 1) {
    constexpr hn::Half<decltype(tag)> half;
    constexpr int h = lanes_here / 2;
    if (count > h) {
      hn::StoreU(hn::LowerHalf(half, a), half, to);
      store_first(hn::UpperHalf(half, a), to + h, count - h);
    } else {
      store_first(hn::LowerHalf(half, a), to, count);
    }
  }
}

/// to += factor a, for the first `count` (1 .. width) doubles.
template <class V>
HWY_INLINE void add_first(V factor, V a, double* to, int count) {
  constexpr hn::DFromV<V> tag;
  constexpr int lanes_here = static_cast<int>(hn::MaxLanes(tag));
  if (count == lanes_here) {
    hn::StoreU(hn::MulAdd(factor, a, hn::LoadU(tag, to)), tag, to);
  } else if constexpr (lanes_here > 1) {
    constexpr hn::Half<decltype(tag)> half;
    constexpr int h = lanes_here / 2;
    const auto low = hn::LowerHalf(half, factor);
    if (count > h) {
      hn::StoreU(hn::MulAdd(low, hn::LowerHalf(half, a), hn::LoadU(half, to)), half, to);
      add_first(low, hn::UpperHalf(half, a), to + h, count - h);
    } else {
      add_first(low, hn::LowerHalf(half, a), to, count);
    }
  }
}

#endif

/// `width` consecutive doubles of eight places.
HWY_INLINE void load_transposed_block(const double* const* from, int begin, Pack* to) {
#pragma GCC unroll 8
  for (int q = 0; q < parts; ++q) {
    Vector rows[width], columns[width];
#pragma GCC unroll 8
    for (int r = 0; r < width; ++r) rows[r] = hn::LoadU(VectorTag(), from[q * width + r] + begin);
    transpose(rows, columns);
#pragma GCC unroll 8
    for (int c = 0; c < width; ++c) to[begin + c].part[q] = columns[c];
  }
}

/// `count` consecutive doubles of eight places become `count` packs: to[i] lane l = from[l][i]. Where only lane 0 is
/// used, the others get its numbers.
HWY_INLINE void load_transposed(const double* const* from, int count, Pack* to, unsigned used) {
  if (used == 1u) {
    for (int i = 0; i < count; ++i) to[i] = Pack(from[0][i]);
    return;
  }
  int begin = 0;
  for (; begin + width <= count; begin += width) load_transposed_block(from, begin, to);
  if (begin == count) return;
  if (count >= width) {  // some once more
    load_transposed_block(from, count - width, to);
    return;
  }
  for (int q = 0; q < parts; ++q) {
    Vector rows[width], columns[width];
#pragma GCC unroll 8
    for (int r = 0; r < width; ++r) rows[r] = load_first(from[q * width + r], count);
    transpose(rows, columns);
#pragma GCC unroll 8
    for (int c = 0; c < width; ++c)
      if (c < count) to[c].part[q] = columns[c];
  }
}

/// from[begin .. begin + some - 1], packs of one register each, as `width` rows; beyond `some` anything.
HWY_INLINE void rows_of_block(const Pack* from, int begin, int some, int q, Vector* rows) {
  Vector columns[width];
#pragma GCC unroll 8
  for (int c = 0; c < width; ++c) columns[c] = from[begin + (c < some ? c : 0)].part[q];
  transpose(columns, rows);
}

/// The reverse: to[l][i] = from[i] lane l, for the lanes whose bit is set in `active`.
HWY_INLINE void store_transposed(const Pack* from, int count, double* const* to, unsigned active) {
  if (active == 1u) {
    for (int i = 0; i < count; ++i) to[0][i] = hn::GetLane(from[i].part[0]);
    return;
  }
  for (int begin = 0; begin < count; begin += width) {
    const int some = count - begin < width ? count - begin : width;
    for (int q = 0; q < parts; ++q) {
      Vector rows[width];
      rows_of_block(from, begin, some, q, rows);
#pragma GCC unroll 8
      for (int r = 0; r < width; ++r)
        if (active >> (q * width + r) & 1u) store_first(rows[r], to[q * width + r] + begin, some);
    }
  }
}

/// to[l][i] += sign from[i] lane l, lane after lane: two lanes may have the same place.
HWY_INLINE void add_transposed(const Pack* from, int count, double* const* to, unsigned active, double sign) {
  if (active == 1u) {
    for (int i = 0; i < count; ++i) to[0][i] += sign * hn::GetLane(from[i].part[0]);
    return;
  }
  const Vector factor = hn::Set(VectorTag(), sign);
  for (int begin = 0; begin < count; begin += width) {
    const int some = count - begin < width ? count - begin : width;
    for (int q = 0; q < parts; ++q) {
      Vector rows[width];
      rows_of_block(from, begin, some, q, rows);
#pragma GCC unroll 8
      for (int r = 0; r < width; ++r)
        if (active >> (q * width + r) & 1u) add_first(factor, rows[r], to[q * width + r] + begin, some);
    }
  }
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
