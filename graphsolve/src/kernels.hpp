#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

/// Dense kernels on column-major blocks without padding. A template argument 0 means "known at run time only";
/// the block sizes up to 6 have code of their own, chosen once per call through a table.
namespace graphsolve::kernels {

inline constexpr int max_fixed = 6;

/// C (m x n) -= A (m x k) B (k x n)
template <int M, int K>
void subtract_product(double* __restrict c, const double* __restrict a, const double* __restrict b, int m_, int k_,
                      int n) {
  const int m = M ? M : m_, k = K ? K : k_;
  for (int j = 0; j < n; ++j, c += m, b += k) {
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
    rows[p] = best;
    if (!(largest > 0) || !(largest < INFINITY)) return largest > 0 ? NAN : largest;
    smallest = largest < smallest ? largest : smallest;
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

/// C columns of X := A^-1 X at once: the chain of dependent operations is walked once for all of them.
template <int D, int C>
void solve_columns(const double* a, const int* rows, double* x) {
  double t[D][C];
  for (int p = 0; p < D; ++p)
    for (int c = 0; c < C; ++c) t[p][c] = x[c * D + p];
  if constexpr (D > 1)
    for (int p = 0; p < D; ++p)
      if (rows[p] != p)
        for (int c = 0; c < C; ++c) std::swap(t[p][c], t[rows[p]][c]);
  for (int p = 0; p < D; ++p)
    for (int i = p + 1; i < D; ++i)
      for (int c = 0; c < C; ++c) t[i][c] -= a[p * D + i] * t[p][c];
  for (int p = D - 1; p >= 0; --p) {
    for (int c = 0; c < C; ++c) t[p][c] *= a[p * D + p];
    for (int i = 0; i < p; ++i)
      for (int c = 0; c < C; ++c) t[i][c] -= a[p * D + i] * t[p][c];
  }
  for (int p = 0; p < D; ++p)
    for (int c = 0; c < C; ++c) x[c * D + p] = t[p][c];
}

/// X (d x n) := A^-1 X with the result of factor().
template <int D>
void solve_block(const double* a, const int* rows, double* x, int d_, int n) {
  const int d = D ? D : d_;
  if constexpr (D > 0) {
    for (; n >= 4; n -= 4, x += 4 * D) solve_columns<D, 4>(a, rows, x);
    if (n >= 2) {
      solve_columns<D, 2>(a, rows, x);
      n -= 2;
      x += 2 * D;
    }
  }
  for (int c = 0; c < n; ++c, x += d) {
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

/// y (m) -= A (m x k) x
template <int M, int K>
void subtract_times_vector(double* __restrict y, const double* __restrict a, const double* __restrict x, int m, int k) {
  subtract_product<M, K>(y, a, x, m, k, 1);
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
using FactorKernel = double (*)(double*, int*, int);
using SolveKernel = void (*)(const double*, const int*, double*, int, int);

ProductKernel product_kernel(int m, int k);
FactorKernel factor_kernel(int d);
SolveKernel solve_kernel(int d);

}  // namespace graphsolve::kernels
