// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_ROWS_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_ROWS_INL_HPP_
#undef GRAPHSOLVE_SIMD_ROWS_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_ROWS_INL_HPP_
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace graphsolve::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int largest_register(int rows) {
  int lanes = static_cast<int>(hn::MaxLanes(hn::CappedTag<double, 8>()));
  while (lanes > rows) lanes /= 2;
  return lanes;
}

/// M consecutive numbers in as few registers as hold exactly these: 6 are 4 and 2, and nothing beyond them is touched.
template <int M>
struct Rows {
  static constexpr int width = largest_register(M);
  static constexpr int registers = 1 + Rows<M - width>::registers;
  using Tag = hn::CappedTag<double, width>;

  hn::VFromD<Tag> head;
  Rows<M - width> tail;

  HWY_INLINE static Rows load(const double* from) {
    Rows r;
    r.head = hn::LoadU(Tag(), from);
    r.tail = Rows<M - width>::load(from + width);
    return r;
  }
  HWY_INLINE static Rows zero() {
    Rows r;
    r.head = hn::Zero(Tag());
    r.tail = Rows<M - width>::zero();
    return r;
  }
  HWY_INLINE void store(double* to) const {
    hn::StoreU(head, Tag(), to);
    tail.store(to + width);
  }
  [[nodiscard]] HWY_INLINE double last() const {
    if constexpr (M == 1) {
      return hn::GetLane(head);
    } else if constexpr (M == width) {
      double all[M];
      store(all);
      return all[M - 1];
    } else {
      return tail.last();
    }
  }
  /// this -= a s
  HWY_INLINE void subtract(const Rows& a, double s) {
    head = hn::NegMulAdd(a.head, hn::Set(Tag(), s), head);
    tail.subtract(a.tail, s);
  }
  [[nodiscard]] HWY_INLINE Rows times(double s) const {
    Rows r;
    r.head = hn::Mul(head, hn::Set(Tag(), s));
    r.tail = tail.times(s);
    return r;
  }
  /// Number by number.
  [[nodiscard]] HWY_INLINE Rows times_each(const Rows& a) const {
    Rows r;
    r.head = hn::Mul(head, a.head);
    r.tail = tail.times_each(a.tail);
    return r;
  }
  /// this -= a b, number by number
  HWY_INLINE void subtract_each(const Rows& a, const Rows& b) {
    head = hn::NegMulAdd(a.head, b.head, head);
    tail.subtract_each(a.tail, b.tail);
  }
};
template <>
struct Rows<0> {
  static constexpr int registers = 0;
  HWY_INLINE static Rows load(const double*) { return {}; }
  HWY_INLINE static Rows zero() { return {}; }
  HWY_INLINE void store(double*) const {}
  HWY_INLINE void subtract(const Rows&, double) {}
  [[nodiscard]] HWY_INLINE Rows times(double) const { return {}; }
  [[nodiscard]] HWY_INLINE Rows times_each(const Rows&) const { return {}; }
  HWY_INLINE void subtract_each(const Rows&, const Rows&) {}
};

using Together = hn::CappedTag<double, 4>;  ///< columns that are worked on at once
using Pair = hn::CappedTag<double, 2>;
using Single = hn::CappedTag<double, 1>;
inline constexpr int largest_together = 32;  ///< rows

#if HWY_TARGET == HWY_SCALAR

template <int D, class Tag>
HWY_INLINE void load_columns(Tag tag, const double* x, int d_, std::ptrdiff_t, int, hn::VFromD<Tag>* to) {
  const int d = D ? D : d_;
  for (int i = 0; i < d; ++i) to[i] = hn::Set(tag, x[i]);
}
template <int D, class Tag>
HWY_INLINE void store_columns(Tag, double* x, int d_, std::ptrdiff_t, int, const hn::VFromD<Tag>* from) {
  const int d = D ? D : d_;
  for (int i = 0; i < d; ++i) x[i] = hn::GetLane(from[i]);
}

#else

/// The same row of up to four columns, as one vector.
template <class Tag>
HWY_INLINE hn::VFromD<Tag> load_row(Tag tag, const double* const* column, int row) {
  if constexpr (hn::MaxLanes(Tag()) == 1) {
    return hn::Set(tag, column[0][row]);
  } else {
    const auto low = hn::InterleaveLower(Pair(), hn::Set(Pair(), column[0][row]), hn::Set(Pair(), column[1][row]));
    if constexpr (hn::MaxLanes(Tag()) == 2) return low;
    else
      return hn::Combine(tag, hn::InterleaveLower(Pair(), hn::Set(Pair(), column[2][row]), hn::Set(Pair(), column[3][row])),
                         low);
  }
}

/// The reverse.
template <class Tag>
HWY_INLINE void store_row(Tag, double* const* column, int row, hn::VFromD<Tag> v) {
  static_assert(hn::MaxLanes(Tag()) == 4);
  const auto low = hn::LowerHalf(Pair(), v), high = hn::UpperHalf(Pair(), v);
  column[0][row] = hn::GetLane(low);
  column[1][row] = hn::GetLane(hn::InterleaveUpper(Pair(), low, low));
  column[2][row] = hn::GetLane(high);
  column[3][row] = hn::GetLane(hn::InterleaveUpper(Pair(), high, high));
}

/// to[i] lane c = x[c stride + i], i < d. Columns from `count` on repeat the last one.
template <int D, class Tag>
HWY_INLINE void load_columns(Tag tag, const double* x, int d_, std::ptrdiff_t stride, int count,
                             hn::VFromD<Tag>* to) {
  constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));
  const int d = D ? D : d_;
  const double* column[lanes];
  for (int c = 0; c < lanes; ++c) column[c] = x + (c < count ? c : count - 1) * stride;
  int i = 0;
  if constexpr (lanes == 4) {
#pragma GCC unroll 3
    for (; i + 4 <= d; i += 4) {
      const auto a = hn::LoadU(tag, column[0] + i), b = hn::LoadU(tag, column[1] + i);
      const auto e = hn::LoadU(tag, column[2] + i), f = hn::LoadU(tag, column[3] + i);
      const auto ab = hn::InterleaveLower(tag, a, b), ab2 = hn::InterleaveUpper(tag, a, b);
      const auto ef = hn::InterleaveLower(tag, e, f), ef2 = hn::InterleaveUpper(tag, e, f);
      to[i] = hn::ConcatLowerLower(tag, ef, ab);
      to[i + 1] = hn::ConcatLowerLower(tag, ef2, ab2);
      to[i + 2] = hn::ConcatUpperUpper(tag, ef, ab);
      to[i + 3] = hn::ConcatUpperUpper(tag, ef2, ab2);
    }
  }
#pragma GCC unroll 6
  for (; i < d; ++i) to[i] = load_row(tag, column, i);
}

/// The reverse, for the first `count` columns.
template <int D, class Tag>
HWY_INLINE void store_columns([[maybe_unused]] Tag tag, double* x, int d_, std::ptrdiff_t stride, int count,
                              const hn::VFromD<Tag>* from) {
  constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));
  const int d = D ? D : d_;
  int i = 0;
  if constexpr (lanes == 4) {
#pragma GCC unroll 3
    for (; i + 4 <= d; i += 4) {
      const auto ab = hn::InterleaveLower(tag, from[i], from[i + 1]), ab2 = hn::InterleaveUpper(tag, from[i], from[i + 1]);
      const auto ef = hn::InterleaveLower(tag, from[i + 2], from[i + 3]);
      const auto ef2 = hn::InterleaveUpper(tag, from[i + 2], from[i + 3]);
      hn::StoreU(hn::ConcatLowerLower(tag, ef, ab), tag, x + i);
      if (count > 1) hn::StoreU(hn::ConcatLowerLower(tag, ef2, ab2), tag, x + stride + i);
      if (count > 2) hn::StoreU(hn::ConcatUpperUpper(tag, ef, ab), tag, x + 2 * stride + i);
      if (count > 3) hn::StoreU(hn::ConcatUpperUpper(tag, ef2, ab2), tag, x + 3 * stride + i);
    }
  }
#pragma GCC unroll 6
  for (; i < d; ++i) {
    if constexpr (lanes == 1) {
      x[i] = hn::GetLane(from[i]);
    } else if constexpr (lanes == 2) {
      x[i] = hn::GetLane(from[i]);
      if (count > 1) x[stride + i] = hn::GetLane(hn::InterleaveUpper(tag, from[i], from[i]));
    } else {
      const auto low = hn::LowerHalf(Pair(), from[i]), high = hn::UpperHalf(Pair(), from[i]);
      x[i] = hn::GetLane(low);
      if (count > 1) x[stride + i] = hn::GetLane(hn::InterleaveUpper(Pair(), low, low));
      if (count > 2) x[2 * stride + i] = hn::GetLane(high);
      if (count > 3) x[3 * stride + i] = hn::GetLane(hn::InterleaveUpper(Pair(), high, high));
    }
  }
}

#endif

}  // namespace graphsolve::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
