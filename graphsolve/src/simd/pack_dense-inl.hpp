// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_
#undef GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PACK_DENSE_INL_HPP_
#endif

#include <limits>

#include "graphsolve/simd/pack-inl.hpp"
#include "simd/pivot_kernels.hpp"

/// Dense blocks of packs: eight blocks of one shape at once, column-major. A template argument 0 is a size known at run
/// time only.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {

/// A pivot block whose elimination without exchanges grows by more than this, or loses more than that, is left to
/// the path that exchanges rows. Both compare a pivot with its own diagonal entry, so that units do not matter.
constexpr double most_growth = 64;
constexpr double least_rest = 1e-13;

/// Columns of a panel that are worked on at once: as many as the registers hold.
constexpr int columns_at_once = parts == 1 ? 2 : 1;

Pack* packs(double* p) { return reinterpret_cast<Pack*>(p); }
const Pack* packs(const double* p) { return reinterpret_cast<const Pack*>(p); }

/// LU in place, column-major, reciprocals of the pivots on the diagonal. Lanes that should have been pivoted.
template <int D>
HWY_INLINE unsigned factor(Pack* a, int d_) {
  const int d = D ? D : d_;
  Pack start[D ? D : largest_dimension], growth[D ? D : largest_dimension];
  for (int p = 0; p < d; ++p) {
    start[p] = abs(a[p * d + p]);
    growth[p] = Pack(0.0);
  }
  Mask sound = start[0] >= Pack(0.0);  // false for NaN
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p) {
    const Pack pivot = a[p * d + p];
    sound = sound & (abs(pivot) > Pack(least_rest) * start[p]) & (growth[p] <= Pack(most_growth) * start[p]) &
            (start[p] < Pack(1e300));
    const Pack reciprocal = Pack(1.0) / pivot;
    a[p * d + p] = reciprocal;
#pragma GCC unroll 6
    for (int i = p + 1; i < d; ++i) a[p * d + i] *= reciprocal;
#pragma GCC unroll 6
    for (int j = p + 1; j < d; ++j) {
      const Pack u = a[j * d + p];
      growth[j] += abs(a[p * d + j] * u);
#pragma GCC unroll 6
      for (int i = p + 1; i < d; ++i) a[j * d + i] = negative_multiply_add(a[p * d + i], u, a[j * d + i]);
    }
  }
  return ~bits(sound);
}

/// LDL^T from the lower triangle, into the form that factor() leaves. Lanes that are not definite.
template <int D>
HWY_INLINE unsigned factor_definite(Pack* a, const Pack* reference, const Definite& definite, int d_) {
  const int d = D ? D : d_;
  const Pack sign(definite.sign), smallest(definite.smallest), infinity(std::numeric_limits<double>::infinity());
  Mask sound = Pack(0.0) <= Pack(0.0);
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p) {
    const Pack size = sign * a[p * d + p];
    sound = sound & (size > smallest * reference[p]) & (size < infinity);
    const Pack reciprocal = Pack(1.0) / a[p * d + p];
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

/// X (d x C) := (LU)^-1 X.
template <int D, int C>
HWY_INLINE void solve_columns(const Pack* a, Pack* x, int d_) {
  const int d = D ? D : d_;
  Pack t[(D ? D : largest_dimension) * C];
#pragma GCC unroll 12
  for (int i = 0; i < d * C; ++i) t[i] = x[i];
#pragma GCC unroll 6
  for (int p = 0; p < d; ++p)
#pragma GCC unroll 6
    for (int i = p + 1; i < d; ++i)
      for (int c = 0; c < C; ++c) t[c * d + i] = negative_multiply_add(a[p * d + i], t[c * d + p], t[c * d + i]);
#pragma GCC unroll 6
  for (int p = d - 1; p >= 0; --p) {
    for (int c = 0; c < C; ++c) t[c * d + p] *= a[p * d + p];
#pragma GCC unroll 6
    for (int i = 0; i < p; ++i)
      for (int c = 0; c < C; ++c) t[c * d + i] = negative_multiply_add(a[p * d + i], t[c * d + p], t[c * d + i]);
  }
#pragma GCC unroll 12
  for (int i = 0; i < d * C; ++i) x[i] = t[i];
}

template <int D>
HWY_INLINE void solve_all(const Pack* lu, Pack* w, int d, int columns) {
  int column = 0;
  for (; column + columns_at_once <= columns; column += columns_at_once)
    solve_columns<D, columns_at_once>(lu, w + column * d, d);
  for (; column < columns; ++column) solve_columns<D, 1>(lu, w + column * d, d);
}

/// T (rows x C, leading dimension rows) := L (rows x d) W (d x C), from row `first` on.
template <int D, int C>
HWY_INLINE void product(const Pack* l, const Pack* w, Pack* t, int rows, int d_, int first = 0) {
  const int d = D ? D : d_;
  Pack column[(D ? D : largest_dimension) * C];
#pragma GCC unroll 12
  for (int i = 0; i < d * C; ++i) column[i] = w[i];
  for (int r = first; r < rows; ++r) {
    Pack sum[C];
    const Pack left = l[r];
    for (int c = 0; c < C; ++c) sum[c] = left * column[c * d];
#pragma GCC unroll 6
    for (int p = 1; p < d; ++p) {
      const Pack factor = l[p * rows + r];
      for (int c = 0; c < C; ++c) sum[c] = multiply_add(factor, column[c * d + p], sum[c]);
    }
    for (int c = 0; c < C; ++c) t[c * rows + r] = sum[c];
  }
}

template <int D>
HWY_INLINE void product_block(const Pack* l, const Pack* w, Pack* t, int rows, int columns, int d) {
  int c = 0;
  for (; c + columns_at_once <= columns; c += columns_at_once)
    product<D, columns_at_once>(l, w + c * d, t + c * rows, rows, d);
  for (; c < columns; ++c) product<D, 1>(l, w + c * d, t + c * rows, rows, d);
}

/// The lower triangle, zeros above.
template <int D>
HWY_INLINE void product_lower(const Pack* l, const Pack* w, Pack* t, int rows, int d) {
  for (int c = 0; c < rows; ++c) {
    for (int r = 0; r < c; ++r) t[c * rows + r] = Pack(0.0);
    product<D, 1>(l, w + c * d, t + c * rows, rows, d, c);
  }
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
