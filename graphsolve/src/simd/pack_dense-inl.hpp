// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_
#undef GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_
#endif

#include <array>
#include <limits>
#include <utility>

#include "graphsolve/simd/pack_memory-inl.hpp"
#include "factorization/thresholds.hpp"
#include "simd/pivot_kernels.hpp"

/// Dense blocks of packs: L blocks of one shape at once, column-major, scalar i of lane l at [i L + l]. D: their
/// dimension; 0 is one known at run time only.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {

/// Columns of a panel that are worked on at once: as many as the registers hold.
template <int L>
inline constexpr int columns_at_once = PackOf<L>::parts == 1 ? 2 : 1;

template <int D, int L>
HWY_INLINE void load_diagonal(const double* from, PackOf<L>* to, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 36
  for (int i = 0; i < d * d; ++i) to[i] = load<L>(from + i * L);
}

/// The lower triangle only.
template <int D, int L>
HWY_INLINE void load_lower(const double* from, PackOf<L>* to, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 6
  for (int c = 0; c < d; ++c)
#pragma GCC unroll 6
    for (int r = c; r < d; ++r) to[c * d + r] = load<L>(from + (c * d + r) * L);
}
template <int D, int L>
HWY_INLINE void store_lower(const PackOf<L>* from, double* to, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 6
  for (int c = 0; c < d; ++c)
#pragma GCC unroll 6
    for (int r = c; r < d; ++r) store(from[c * d + r], to + (c * d + r) * L);
}

/// LU in place, column-major, reciprocals of the pivots on the diagonal. Lanes that should have been pivoted.
template <int D, int L>
HWY_INLINE unsigned factor(PackOf<L>* a, int d_) {
  using P = PackOf<L>;
  const int d = D ? D : d_;
  P start[D ? D : largest_dimension], growth[D ? D : largest_dimension];
  for (int p = 0; p < d; ++p) {
    start[p] = abs(a[p * d + p]);
    growth[p] = P(0.0);
  }
  MaskOf<L> sound = start[0] >= P(0.0);  // false for NaN
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p) {
    const P pivot = a[p * d + p];
    sound = sound & (abs(pivot) > multiply_add(P(thresholds::least_rest), start[p], P(thresholds::least_pivot))) & (growth[p] <= P(thresholds::most_growth) * start[p]) &
            (start[p] < P(1e300));
    const P reciprocal = P(1.0) / pivot;
    a[p * d + p] = reciprocal;
#pragma GCC unroll 6
    for (int i = p + 1; i < d; ++i) a[p * d + i] *= reciprocal;
#pragma GCC unroll 6
    for (int j = p + 1; j < d; ++j) {
      const P u = a[j * d + p];
      growth[j] += abs(a[p * d + j] * u);
#pragma GCC unroll 6
      for (int i = p + 1; i < d; ++i) a[j * d + i] = negative_multiply_add(a[p * d + i], u, a[j * d + i]);
    }
  }
  return ~bits(sound);
}

/// LDL^T from the lower triangle, into the form that factor() leaves. Lanes that are not definite.
template <int D, int L>
HWY_INLINE unsigned factor_definite(PackOf<L>* a, const PackOf<L>* reference, const Definite& definite, int d_) {
  using P = PackOf<L>;
  const int d = D ? D : d_;
  const P sign(definite.sign), smallest(definite.smallest), infinity(std::numeric_limits<double>::infinity());
  MaskOf<L> sound = P(0.0) <= P(0.0);
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p) {
    const P size = sign * a[p * d + p];
    sound = sound & (size > multiply_add(smallest, reference[p], P(thresholds::least_pivot))) & (size < infinity);
    const P reciprocal = P(1.0) / a[p * d + p];
    a[p * d + p] = reciprocal;
#pragma GCC unroll 6
    for (int i = p + 1; i < d; ++i) {
      a[i * d + p] = a[p * d + i];
      a[p * d + i] *= reciprocal;
    }
#pragma GCC unroll 6
    for (int j = p + 1; j < d; ++j)
#pragma GCC unroll 6
      for (int i = j; i < d; ++i) a[j * d + i] = negative_multiply_add(a[p * d + j], a[i * d + p], a[j * d + i]);
  }
  return ~bits(sound);
}

/// A factored block that is read where it lies: whoever solves for one column takes every number once.
template <int L>
struct Stored {
  const double* numbers;
  HWY_INLINE PackOf<L> operator[](int i) const { return load<L>(numbers + i * L); }
};

/// X (d x C) := L^-1 X. a, here and below: packs in an array, or Stored.
template <int D, int C, int L, class A>
HWY_INLINE void solve_lower(const A& a, PackOf<L>* t, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p)
#pragma GCC unroll 6
    for (int i = p + 1; i < d; ++i)
      for (int c = 0; c < C; ++c) t[c * d + i] = negative_multiply_add(a[p * d + i], t[c * d + p], t[c * d + i]);
}

/// X (d x C) := U^-1 X.
template <int D, int C, int L, class A>
HWY_INLINE void solve_upper(const A& a, PackOf<L>* t, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 6
  for (int p = d - 1; p >= 0; --p) {
    for (int c = 0; c < C; ++c) t[c * d + p] *= a[p * d + p];
#pragma GCC unroll 6
    for (int i = 0; i < p; ++i)
      for (int c = 0; c < C; ++c) t[c * d + i] = negative_multiply_add(a[p * d + i], t[c * d + p], t[c * d + i]);
  }
}

/// X (d x C) := (LU)^-1 X.
template <int D, int C, int L, class A>
HWY_INLINE void solve_columns(const A& a, PackOf<L>* t, int d) {
  solve_lower<D, C>(a, t, d);
  solve_upper<D, C>(a, t, d);
}

/// X (d) := U^-T X.
template <int D, int L, class A>
HWY_INLINE void solve_upper_transposed(const A& a, PackOf<L>* x, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p) {
#pragma GCC unroll 6
    for (int i = 0; i < p; ++i) x[p] = negative_multiply_add(a[p * d + i], x[i], x[p]);
    x[p] *= a[p * d + p];
  }
}

/// X (d) := L^-T X. What is known last comes last.
template <int D, int L, class A>
HWY_INLINE void solve_lower_transposed(const A& a, PackOf<L>* x, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 6
  for (int p = d - 1; p >= 0; --p)
#pragma GCC unroll 6
    for (int i = d - 1; i > p; --i) x[p] = negative_multiply_add(a[p * d + i], x[i], x[p]);
}

/// C columns of W in memory := (LU)^-1 W.
template <int D, int C, int L>
HWY_INLINE void solve_in_place(const PackOf<L>* lu, double* w, int d_) {
  const int d = D ? D : d_;
  PackOf<L> t[(D ? D : largest_dimension) * C];
#pragma GCC unroll 12
  for (int i = 0; i < d * C; ++i) t[i] = load<L>(w + i * L);
  solve_columns<D, C>(lu, t, d);
#pragma GCC unroll 12
  for (int i = 0; i < d * C; ++i) store(t[i], w + i * L);
}

template <int D, int L>
HWY_INLINE void solve_all(const PackOf<L>* lu, double* w, int d, int columns) {
  constexpr int some = columns_at_once<L>;
  int column = 0;
  for (; column + some <= columns; column += some) solve_in_place<D, some>(lu, w + column * d * L, d);
  for (; column < columns; ++column) solve_in_place<D, 1>(lu, w + column * d * L, d);
}

/// C rows of a panel P (`rows` rows in memory): W := L^-1 P^T, P := W^T D^-1.
template <int D, int C, int L>
HWY_INLINE void halve_rows(const PackOf<L>* ldl, double* panel, double* w, int rows, int d_) {
  const int d = D ? D : d_;
  const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(rows) * L;  // column
  PackOf<L> t[(D ? D : largest_dimension) * C];
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p)
    for (int c = 0; c < C; ++c) t[c * d + p] = load<L>(panel + p * next + c * L);
  solve_lower<D, C>(ldl, t, d);
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p)
    for (int c = 0; c < C; ++c) {
      store(t[c * d + p], w + (c * d + p) * L);
      store(t[c * d + p] * ldl[p * d + p], panel + p * next + c * L);
    }
}

template <int D, int L>
HWY_INLINE void halve_panel(const PackOf<L>* ldl, double* panel, double* w, int rows, int d) {
  constexpr int some = columns_at_once<L>;
  int r = 0;
  for (; r + some <= rows; r += some) halve_rows<D, some>(ldl, panel + r * L, w + r * d * L, rows, d);
  for (; r < rows; ++r) halve_rows<D, 1>(ldl, panel + r * L, w + r * d * L, rows, d);
}

/// f(i, scalar i of L (rows x d) W (d x C)), column-major, from row `first` of each column on.
template <int D, int C, int L, class F>
HWY_INLINE void product(const double* l, const double* w, int rows, int d_, int first, int from, F&& f) {
  const int d = D ? D : d_;
  PackOf<L> column[(D ? D : largest_dimension) * C];
#pragma GCC unroll 12
  for (int i = 0; i < d * C; ++i) column[i] = load<L>(w + i * L);
  const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(rows) * L;  // column
  l += first * L;
  for (int r = first; r < rows; ++r, l += L) {
    PackOf<L> sum[C];
    const PackOf<L> left = load<L>(l);
    for (int c = 0; c < C; ++c) sum[c] = left * column[c * d];
#pragma GCC unroll 6
    for (int p = 1; p < d; ++p) {
      const PackOf<L> factor = load<L>(l + p * next);
      for (int c = 0; c < C; ++c) sum[c] = multiply_add(factor, column[c * d + p], sum[c]);
    }
    for (int c = 0; c < C; ++c) f(from + c * rows + r, sum[c]);
  }
}

template <int D, int L, class F>
HWY_INLINE void product_block(const double* l, const double* w, int rows, int columns, int d, F&& f) {
  constexpr int some = columns_at_once<L>;
  int c = 0;
  for (; c + some <= columns; c += some) product<D, some, L>(l, w + c * d * L, rows, d, 0, c * rows, f);
  for (; c < columns; ++c) product<D, 1, L>(l, w + c * d * L, rows, d, 0, c * rows, f);
}

/// The lower triangle only.
template <int D, int L, class F>
HWY_INLINE void product_lower(const double* l, const double* w, int rows, int d, F&& f) {
  for (int c = 0; c < rows; ++c) product<D, 1, L>(l, w + c * d * L, rows, d, c, c * rows, f);
}

/// Which dimensions are constants: the usual ones, where a pack is one register or two. Where it is more (plain code, which
/// hardly any machine falls back to) that gains a tenth to a half, and takes longer to compile than all else here.
template <int D, int L>
inline constexpr int compiled_dimension = PackOf<L>::parts > 2 ? 0 : D;

/// of<D, L>() for every kind of pack.
template <class Of, int... K>
constexpr auto by_kind(Of of, std::integer_sequence<int, K...>) {
  return std::array{
      of.template operator()<compiled_dimension<K % pack_dimensions, 1 << K / pack_dimensions>, 1 << K / pack_dimensions>()...};
}
template <class Of>
constexpr auto by_kind(Of of) {
  return by_kind(of, std::make_integer_sequence<int, pack_kinds>{});
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
