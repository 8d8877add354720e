// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_DEFINITE_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_DEFINITE_INL_HPP_
#undef GRAPHSOLVE_SIMD_DEFINITE_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_DEFINITE_INL_HPP_
#endif

#include <limits>

#include "factorization/thresholds.hpp"
#include "simd/rows-inl.hpp"

/// Definite blocks and the panels below them, as kernels.hpp describes them.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::kernels::HWY_NAMESPACE {

/// to -= from s
HWY_INLINE void subtract(double* HWY_RESTRICT to, const double* HWY_RESTRICT from, double s, int count) {
  const auto some = [&]<int M>() {
    Rows<M> sum = Rows<M>::load(to);
    sum.subtract(Rows<M>::load(from), s);
    sum.store(to);
    to += M;
    from += M;
  };
  for (; count >= 8; count -= 8) some.template operator()<8>();
  if (count & 4) some.template operator()<4>();
  if (count & 2) some.template operator()<2>();
  if (count & 1) some.template operator()<1>();
}

/// In registers, number by number.
template <int D>
bool factor_definite_small(double* a, const double* reference, double sign, double tiny) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double t[D][D], l[D][D];
  for (int p = 0; p < D; ++p)
    for (int i = p; i < D; ++i) t[p][i] = a[p * D + i];
  bool sound = true;
#pragma GCC unroll 6
  for (int p = 0; p < D; ++p) {
    const double size = sign * t[p][p];
    sound &= (size > tiny * reference[p] + thresholds::least_pivot) & (size < infinity);
    t[p][p] = 1.0 / t[p][p];
#pragma GCC unroll 6
    for (int i = p + 1; i < D; ++i) l[p][i] = t[p][i] * t[p][p];
#pragma GCC unroll 6
    for (int j = p + 1; j < D; ++j)
#pragma GCC unroll 6
      for (int i = j; i < D; ++i) t[j][i] -= t[p][i] * l[p][j];
  }
  if (!sound) return false;
#pragma GCC unroll 6
  for (int p = 0; p < D; ++p) {
    a[p * D + p] = t[p][p];
#pragma GCC unroll 6
    for (int i = p + 1; i < D; ++i) {
      a[p * D + i] = l[p][i];
      a[i * D + p] = t[p][i];
    }
  }
  return true;
}

/// In registers, column by column; what stands above the diagonal goes along and means nothing. The pivots are kept up on the
/// side: the next one waits for its division only.
template <int D>
bool factor_definite_columns(double* a, const double* reference, double sign, double tiny) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Rows<D> t[D];
  double pivot[D], reciprocal[D], column[D * D], l[D * D];
  for (int p = 0; p < D; ++p) {
    t[p] = Rows<D>::load(a + p * D);
    pivot[p] = a[p * (D + 1)];
  }
  bool sound = true;
#pragma GCC unroll 16
  for (int p = 0; p < D; ++p) {
    const double size = sign * pivot[p];
    sound &= (size > tiny * reference[p] + thresholds::least_pivot) & (size < infinity);
    reciprocal[p] = 1.0 / pivot[p];
    t[p].store(column + p * D);
    const Rows<D> multipliers = t[p].times(reciprocal[p]);
    multipliers.store(l + p * D);
#pragma GCC unroll 16
    for (int j = p + 1; j < D; ++j) {
      const double c = column[p * D + j];
      pivot[j] -= c * reciprocal[p] * c;
      t[j].subtract(multipliers, c);
    }
  }
  if (!sound) return false;
  for (int p = 0; p < D; ++p) Rows<D>::load(l + p * D).store(a + p * D);
  for (int p = 0; p < D; ++p) {
    a[p * (D + 1)] = reciprocal[p];
    for (int i = p + 1; i < D; ++i) a[i * D + p] = column[p * D + i];
  }
  return true;
}

inline bool factor_definite_large(double* a, const double* reference, double sign, double tiny, int d) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (int p = 0; p < d; ++p) {
    double* column = a + p * d;
    const double size = sign * column[p];
    if (!(size > tiny * reference[p] + thresholds::least_pivot) || !(size < infinity)) return false;
    column[p] = 1.0 / column[p];
    for (int i = p + 1; i < d; ++i) {
      a[i * d + p] = column[i];
      column[i] *= column[p];
    }
    for (int j = p + 1; j < d; ++j) subtract(a + j * d + j, column + j, a[j * d + p], d - j);
  }
  return true;
}

template <int D>
bool factor_definite(double* a, const double* reference, double sign, double tiny, int d) {
  if constexpr (D == 0) return factor_definite_large(a, reference, sign, tiny, d);
  else if constexpr (D > max_fixed) return factor_definite_columns<D>(a, reference, sign, tiny);
  else return factor_definite_small<D>(a, reference, sign, tiny);
}

/// to (D x M) := from^T, M x D.
template <int M, int D>
HWY_INLINE void transpose_into(const double* from, double* to) {
  for (int i = 0; i < M; ++i)
#pragma GCC unroll 12
    for (int q = 0; q < D; ++q) to[i * D + q] = from[q * M + i];
}

/// M rows of a panel P, columns `ld` apart: `lower` gets P L^-T D^-1, `upper` L^-1 P^T.
template <int M, int D>
HWY_INLINE void halve_rows(const double* a, double* lower, std::ptrdiff_t ld, double* upper) {
  Rows<M> x[D];
  double kept[D * M];
#pragma GCC unroll 12
  for (int q = 0; q < D; ++q) x[q] = Rows<M>::load(lower + q * ld);
#pragma GCC unroll 12
  for (int p = 0; p < D; ++p)
#pragma GCC unroll 12
    for (int q = p + 1; q < D; ++q) x[q].subtract(x[p], a[p * D + q]);
#pragma GCC unroll 12
  for (int q = 0; q < D; ++q) {
    x[q].store(kept + q * M);
    x[q].times(a[q * (D + 1)]).store(lower + q * ld);
  }
  transpose_into<M, D>(kept, upper);
}

/// Of any dimension.
inline void halve_large(const double* a, double* lower, double* upper, int rows, int d) {
  for (int p = 0; p < d; ++p)
    for (int q = p + 1; q < d; ++q) subtract(lower + q * rows, lower + p * rows, a[p * d + q], rows);
  for (int q = 0; q < d; ++q)
    for (int i = 0; i < rows; ++i) {
      upper[i * d + q] = lower[q * rows + i];
      lower[q * rows + i] *= a[q * (d + 1)];
    }
}

template <int D>
void halve(const double* a, double* lower, double* upper, int rows, int d, int blocks) {
  for (; blocks > 0; --blocks, lower += rows * d, upper += rows * d) {
    if constexpr (D == 0) {
      halve_large(a, lower, upper, rows, d);
    } else {
      int done = 0;
      const auto some = [&]<int M>() HWY_ATTR {
        halve_rows<M, D>(a, lower + done, rows, upper + done * D);
        done += M;
      };
      while (rows - done >= 8) some.template operator()<8>();
      if (rows - done == 6) some.template operator()<6>();
      if (rows - done >= 4) some.template operator()<4>();
      if (rows - done == 3) some.template operator()<3>();
      if (rows - done == 2) some.template operator()<2>();
      if (rows - done == 1) some.template operator()<1>();
    }
  }
}

}  // namespace graphsolve::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
