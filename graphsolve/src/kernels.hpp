#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

/// Dense kernels on column-major blocks without padding. A template argument 0 means "known at run time only";
/// the block sizes up to 6 have code of their own, chosen once per call through a table.
namespace graphsolve::kernels {

inline constexpr int max_fixed = 6;

/// C (m x n) -= A (m x k) B (k x n); the columns of C and B lie `ldc` and `ldb` apart.
template <int M, int K>
void subtract_product_strided(double* __restrict c, std::ptrdiff_t ldc, const double* __restrict a,
                              const double* __restrict b, std::ptrdiff_t ldb, int m_, int k_, int n) {
  const int m = M ? M : m_, k = K ? K : k_;
  for (int j = 0; j < n; ++j, c += ldc, b += ldb) {
    if constexpr (M > 0 && K > 0) {
      double column[M];
      for (int i = 0; i < M; ++i) column[i] = c[i];
      for (int p = 0; p < K; ++p)
        for (int i = 0; i < M; ++i) column[i] -= a[p * M + i] * b[p];
      for (int i = 0; i < M; ++i) c[i] = column[i];
    } else {
      for (int p = 0; p < k; ++p) {
        const double s = b[p];
        for (int i = 0; i < m; ++i) c[i] -= a[p * m + i] * s;
      }
    }
  }
}

/// C (m x n) -= A (m x k) B (k x n), all without gaps.
template <int M, int K>
void subtract_product(double* __restrict c, const double* __restrict a, const double* __restrict b, int m, int k,
                      int n) {
  subtract_product_strided<M, K>(c, M ? M : m, a, b, K ? K : k, m, k, n);
}

/// Lower triangle of C (m x m) -= A (m x k) B (k x m)
template <int M, int K>
void subtract_product_lower(double* __restrict c, const double* __restrict a, const double* __restrict b, int m_,
                            int k_) {
  if constexpr (M > 0 && K > 0) {
#pragma GCC unroll 6
    for (int j = 0; j < M; ++j) {
      double column[M];
#pragma GCC unroll 6
      for (int i = j; i < M; ++i) column[i] = c[j * M + i];
      for (int p = 0; p < K; ++p)
#pragma GCC unroll 6
        for (int i = j; i < M; ++i) column[i] -= a[p * M + i] * b[j * K + p];
#pragma GCC unroll 6
      for (int i = j; i < M; ++i) c[j * M + i] = column[i];
    }
  } else {
    const int m = m_, k = k_;
    for (int j = 0; j < m; ++j)
      for (int p = 0; p < k; ++p) {
        const double s = b[j * k + p];
        for (int i = j; i < m; ++i) c[j * m + i] -= a[p * m + i] * s;
      }
  }
}

/// The diagonal entry is taken when it is at least this part of the largest: definite blocks then need no exchanges,
/// whose branches cost more than the arithmetic. Entries grow at most by 1 + 1 / this per stage.
inline constexpr double diagonal_preferred = 0.1;

/// LU with row exchanges in place: L unit below the diagonal, reciprocals of the pivots on it. `rows[p]` is
/// the row that took place p. Returns the smallest pivot magnitude; 0 or NaN means not usable.
template <int D>
double factor(double* a, int* rows, int d_) {
  const int d = D ? D : d_;
  double smallest = INFINITY;
  for (int p = 0; p < d; ++p) {
    int best = p;
    double largest = std::abs(a[p * d + p]);
    for (int i = p + 1; i < d; ++i) {
      const double candidate = std::abs(a[p * d + i]);
      if (candidate > largest) {
        largest = candidate;
        best = i;
      }
    }
    if (std::abs(a[p * d + p]) >= diagonal_preferred * largest) best = p;
    rows[p] = best;
    if (!(largest > 0) || !(largest < INFINITY)) return largest > 0 ? NAN : largest;
    const double size = std::abs(a[p * d + best]);
    smallest = size < smallest ? size : smallest;
    if (best != p)
      for (int j = 0; j < d; ++j) std::swap(a[j * d + p], a[j * d + best]);
    const double reciprocal = 1.0 / a[p * d + p];
    a[p * d + p] = reciprocal;
    for (int i = p + 1; i < d; ++i) a[p * d + i] *= reciprocal;
    for (int j = p + 1; j < d; ++j) {
      const double s = a[j * d + p];
      for (int i = p + 1; i < d; ++i) a[j * d + i] -= a[p * d + i] * s;
    }
  }
  return smallest;
}

/// LDL^T of a definite block without exchanges, from its lower triangle, into the form that factor() leaves: L unit
/// below the diagonal, reciprocals of the pivots on it, D L^T above. True when all pivots have the given sign (1 or
/// -1) and are larger than `tiny` times their reference; else the block is as it was (blocks larger than max_fixed:
/// spoilt). Definite blocks need no exchanges: their elements do not grow.
template <int D>
bool factor_definite(double* a, const double* reference, double sign, double tiny, int d_) {
  if constexpr (D > 0) {
    double t[D][D], l[D][D];
    for (int p = 0; p < D; ++p)
      for (int i = p; i < D; ++i) t[p][i] = a[p * D + i];
#pragma GCC unroll 6
    for (int p = 0; p < D; ++p) {
      const double size = sign * t[p][p];
      if (!(size > tiny * reference[p]) || !(size < INFINITY)) return false;
      t[p][p] = 1.0 / t[p][p];
#pragma GCC unroll 6
      for (int i = p + 1; i < D; ++i) l[p][i] = t[p][i] * t[p][p];
#pragma GCC unroll 6
      for (int j = p + 1; j < D; ++j)
#pragma GCC unroll 6
        for (int i = j; i < D; ++i) t[j][i] -= t[p][i] * l[p][j];
    }
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
  } else {
    const int d = d_;
    for (int p = 0; p < d; ++p) {
      double* column = a + p * d;
      const double size = sign * column[p];
      if (!(size > tiny * reference[p]) || !(size < INFINITY)) return false;
      column[p] = 1.0 / column[p];
      for (int i = p + 1; i < d; ++i) {
        a[i * d + p] = column[i];
        column[i] *= column[p];
      }
      for (int j = p + 1; j < d; ++j) {
        const double s = a[j * d + p];
        for (int i = j; i < d; ++i) a[j * d + i] -= column[i] * s;
      }
    }
    return true;
  }
}

/// C columns of X := A^-1 X at once: the chain of dependent operations is walked once for all of them.
template <int D, int C>
void solve_columns(const double* a, const int* rows, double* x, std::ptrdiff_t stride) {
  double t[D][C];
  for (int p = 0; p < D; ++p)
    for (int c = 0; c < C; ++c) t[p][c] = x[c * stride + p];
  if constexpr (D > 1)
    for (int p = 0; p < D; ++p)
      if (rows[p] != p)
        for (int c = 0; c < C; ++c) std::swap(t[p][c], t[rows[p]][c]);
#pragma GCC unroll 6
  for (int p = 0; p < D; ++p)
#pragma GCC unroll 6
    for (int i = p + 1; i < D; ++i)
      for (int c = 0; c < C; ++c) t[i][c] -= a[p * D + i] * t[p][c];
#pragma GCC unroll 6
  for (int p = D - 1; p >= 0; --p) {
    for (int c = 0; c < C; ++c) t[p][c] *= a[p * D + p];
#pragma GCC unroll 6
    for (int i = 0; i < p; ++i)
      for (int c = 0; c < C; ++c) t[i][c] -= a[p * D + i] * t[p][c];
  }
  for (int p = 0; p < D; ++p)
    for (int c = 0; c < C; ++c) x[c * stride + p] = t[p][c];
}

/// X (d x n) := A^-1 X with the result of factor() or factor_definite(); columns of X lie `stride` apart.
template <int D>
void solve_block(const double* a, const int* rows, double* x, int d_, int n, std::ptrdiff_t stride) {
  const int d = D ? D : d_;
  if constexpr (D > 0) {
    for (; n >= 4; n -= 4, x += 4 * stride) solve_columns<D, 4>(a, rows, x, stride);
    if (n >= 2) {
      solve_columns<D, 2>(a, rows, x, stride);
      n -= 2;
      x += 2 * stride;
    }
    if (n > 0) solve_columns<D, 1>(a, rows, x, stride);
    return;
  }
  for (int c = 0; c < n; ++c, x += stride) {
    for (int p = 0; p < d; ++p)
      if (rows[p] != p) std::swap(x[p], x[rows[p]]);
    for (int p = 0; p < d; ++p)
      for (int i = p + 1; i < d; ++i) x[i] -= a[p * d + i] * x[p];
    for (int p = d - 1; p >= 0; --p) {
      x[p] *= a[p * d + p];
      for (int i = 0; i < p; ++i) x[i] -= a[p * d + i] * x[p];
    }
  }
}

/// x := A^-T x with the result of factor().
inline void solve_block_transposed(const double* a, const int* rows, double* x, int d) {
  for (int p = 0; p < d; ++p) {
    for (int i = 0; i < p; ++i) x[p] -= a[p * d + i] * x[i];
    x[p] *= a[p * d + p];
  }
  for (int p = d - 1; p >= 0; --p)
    for (int i = p + 1; i < d; ++i) x[p] -= a[p * d + i] * x[i];
  for (int p = d - 1; p >= 0; --p)
    if (rows[p] != p) std::swap(x[p], x[rows[p]]);
}

/// y (k) -= A^T x,  A (m x k)
inline void subtract_transposed_times_vector(double* __restrict y, const double* __restrict a,
                                             const double* __restrict x, int m, int k) {
  for (int p = 0; p < k; ++p) {
    double sum = 0;
    for (int i = 0; i < m; ++i) sum += a[p * m + i] * x[i];
    y[p] -= sum;
  }
}

using ProductKernel = void (*)(double*, const double*, const double*, int, int, int);
using StridedKernel = void (*)(double*, std::ptrdiff_t, const double*, const double*, std::ptrdiff_t, int, int, int);
using LowerKernel = void (*)(double*, const double*, const double*, int, int);
using FactorKernel = double (*)(double*, int*, int);
using DefiniteKernel = bool (*)(double*, const double*, double, double, int);
using SolveKernel = void (*)(const double*, const int*, double*, int, int, std::ptrdiff_t);

ProductKernel product_kernel(int m, int k);
StridedKernel strided_kernel(int m, int k);
LowerKernel lower_kernel(int m, int k);
FactorKernel factor_kernel(int d);
DefiniteKernel definite_kernel(int d);
SolveKernel solve_kernel(int d);

}  // namespace graphsolve::kernels
