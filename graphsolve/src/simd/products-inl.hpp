// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(GRAPHSOLVE_SIMD_PRODUCTS_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef GRAPHSOLVE_SIMD_PRODUCTS_INL_HPP_
#undef GRAPHSOLVE_SIMD_PRODUCTS_INL_HPP_
#else
#define GRAPHSOLVE_SIMD_PRODUCTS_INL_HPP_
#endif

#include <algorithm>
#include <cstdint>
#include <span>

#include "graphsolve/symbolic.hpp"
#include "factorization/kernels.hpp"
#include "simd/rows-inl.hpp"

/// Products of single blocks, as kernels.hpp describes them.
HWY_BEFORE_NAMESPACE();
namespace graphsolve::kernels::HWY_NAMESPACE {

/// J columns of C (M rows) -= A B, kept in registers meanwhile.
template <int M, int J>
HWY_INLINE void product_columns(double* HWY_RESTRICT c, std::ptrdiff_t ldc, const double* HWY_RESTRICT a,
                                std::ptrdiff_t lda, const double* HWY_RESTRICT b, std::ptrdiff_t ldb, int k) {
  Rows<M> sum[J];
#pragma GCC unroll 8
  for (int j = 0; j < J; ++j) sum[j] = Rows<M>::load(c + j * ldc);
  for (int p = 0; p < k; ++p) {
    const Rows<M> column = Rows<M>::load(a + p * lda);
#pragma GCC unroll 8
    for (int j = 0; j < J; ++j) sum[j].subtract(column, b[j * ldb + p]);
  }
#pragma GCC unroll 8
  for (int j = 0; j < J; ++j) sum[j].store(c + j * ldc);
}

template <int M, int J>
HWY_INLINE void product_rest(double* c, std::ptrdiff_t ldc, const double* a, std::ptrdiff_t lda, const double* b,
                             std::ptrdiff_t ldb, int k, int n) {
  if constexpr (J > 0) {
    if (n == J) product_columns<M, J>(c, ldc, a, lda, b, ldb, k);
    else product_rest<M, J - 1>(c, ldc, a, lda, b, ldb, k, n);
  }
}

template <int M>
void product_rows(double* c, std::ptrdiff_t ldc, const double* a, std::ptrdiff_t lda, const double* b,
                  std::ptrdiff_t ldb, int k, int n) {
  constexpr int J = std::max(1, std::min(6, 12 / Rows<M>::registers));
  for (; n >= J; n -= J, c += J * ldc, b += J * ldb) product_columns<M, J>(c, ldc, a, lda, b, ldb, k);
  product_rest<M, J - 1>(c, ldc, a, lda, b, ldb, k, n);
}

/// Eight rows at a time.
void product_any(double* c, std::ptrdiff_t ldc, const double* a, std::ptrdiff_t lda, const double* b,
                 std::ptrdiff_t ldb, int m, int k, int n) {
  for (; m >= 8; m -= 8, c += 8, a += 8) product_rows<8>(c, ldc, a, lda, b, ldb, k, n);
  switch (m) {
    case 1: return product_rows<1>(c, ldc, a, lda, b, ldb, k, n);
    case 2: return product_rows<2>(c, ldc, a, lda, b, ldb, k, n);
    case 3: return product_rows<3>(c, ldc, a, lda, b, ldb, k, n);
    case 4: return product_rows<4>(c, ldc, a, lda, b, ldb, k, n);
    case 5: return product_rows<5>(c, ldc, a, lda, b, ldb, k, n);
    case 6: return product_rows<6>(c, ldc, a, lda, b, ldb, k, n);
    case 7: return product_rows<7>(c, ldc, a, lda, b, ldb, k, n);
    default: return;
  }
}

template <int M>
void product(double* c, std::ptrdiff_t ldc, const double* a, const double* b, std::ptrdiff_t ldb, int m, int k, int n) {
  if constexpr (M > 0) product_rows<M>(c, ldc, a, M, b, ldb, k, n);
  else product_any(c, ldc, a, m, b, ldb, m, k, n);
}

template <int M>
void lower_product(double* c, const double* a, const double* b, int m, int k) {
  if constexpr (M > 0) {
    product_rows<M>(c, M, a, M, b, k, k, M);
  } else {
    for (int j = 0; j < m; j += 8)
      product_any(c + j * (m + 1), m, a + j, m, b + j * k, k, m - j, k, std::min(8, m - j));
  }
}

/// S x S blocks transposed, one after the other.
template <int S>
void transpose_blocks(const double* HWY_RESTRICT from, double* HWY_RESTRICT to, int blocks) {
#if HWY_TARGET <= HWY_AVX3
  if constexpr (S == 3) {
    using Eight = hn::CappedTag<double, 8>;
    alignas(64) static constexpr std::int64_t order[8] = {0, 3, 6, 1, 4, 7, 2, 5};
    const auto places = hn::SetTableIndices(Eight(), order);
    for (int k = 0; k < blocks; ++k, from += 9, to += 9) {
      hn::StoreU(hn::TableLookupLanes(hn::LoadU(Eight(), from), places), Eight(), to);
      to[8] = from[8];
    }
    return;
  }
#endif
  for (int k = 0; k < blocks; ++k, from += S * S, to += S * S)
#pragma GCC unroll 4
    for (int i = 0; i < S; ++i)
#pragma GCC unroll 4
      for (int q = 0; q < S; ++q) to[i * S + q] = from[q * S + i];
}

template <int S, int D>
HWY_INLINE void forward_rows(double* x, const int* places, std::span<const int> coupled,
                             const double* HWY_RESTRICT lower, const double* y, int d_) {
  const int d = D ? D : d_;
  double known[D ? D : 1];
  if (D > 0)
    for (int p = 0; p < d; ++p) known[p] = y[p];
  for (const int later : coupled) {
    double* rows = x + ~places[later];
    Rows<S> sum = Rows<S>::load(rows);
#pragma GCC unroll 6
    for (int p = 0; p < d; ++p) sum.subtract(Rows<S>::load(lower + p * S), D ? known[p] : y[p]);
    sum.store(rows);
    lower += S * d;
  }
}
template <int S>
void forward(double* x, const int* places, std::span<const int> coupled, const double* lower, const double* y,
             int d) {
  switch (d) {
    case 3: return forward_rows<S, 3>(x, places, coupled, lower, y, d);
    case 6: return forward_rows<S, 6>(x, places, coupled, lower, y, d);
    default: return forward_rows<S, 0>(x, places, coupled, lower, y, d);
  }
}

template <int S, int D>
HWY_INLINE void backward_rows(double* y, const int* places, std::span<const int> coupled,
                              const double* HWY_RESTRICT upper, const double* x) {
  Rows<D> sum = Rows<D>::load(y);
  for (const int later : coupled) {
    const double* rows = x + ~places[later];
#pragma GCC unroll 6
    for (int c = 0; c < S; ++c) sum.subtract(Rows<D>::load(upper + c * D), rows[c]);
    upper += S * D;
  }
  sum.store(y);
}
template <int S>
void backward(double* y, const int* places, std::span<const int> coupled, const double* upper, const double* x,
              int d) {
  switch (d) {
    case 1: return backward_rows<S, 1>(y, places, coupled, upper, x);
    case 2: return backward_rows<S, 2>(y, places, coupled, upper, x);
    case 3: return backward_rows<S, 3>(y, places, coupled, upper, x);
    case 4: return backward_rows<S, 4>(y, places, coupled, upper, x);
    case 6: return backward_rows<S, 6>(y, places, coupled, upper, x);
    default: break;
  }
  for (const int later : coupled) {
    product_any(y, d, upper, d, x + ~places[later], S, d, S, 1);
    upper += S * d;
  }
}

/// As BackwardHalf describes it. Sums of one row each stay apart until all couplings are through.
template <int S>
void backward_half(const double* a, double* y, const int* places, std::span<const int> coupled, const double* HWY_RESTRICT lower,
                   const double* x) {
  Rows<S> sum[S];
#pragma GCC unroll 4
  for (int p = 0; p < S; ++p) sum[p] = Rows<S>::zero();
  for (const int later : coupled) {
    const Rows<S> rows = Rows<S>::load(x + ~places[later]);
#pragma GCC unroll 4
    for (int p = 0; p < S; ++p) sum[p].subtract_each(Rows<S>::load(lower + p * S), rows);
    lower += S * S;
  }
#pragma GCC unroll 4
  for (int p = S - 1; p >= 0; --p) {
    double part[S];
    sum[p].store(part);
    y[p] *= a[p * (S + 1)];
#pragma GCC unroll 4
    for (int i = 0; i < S; ++i) y[p] += part[i];
#pragma GCC unroll 4
    for (int i = p + 1; i < S; ++i) y[p] -= a[p * S + i] * y[i];
  }
}

}  // namespace graphsolve::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
