#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "factorization/kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/block_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/definite-inl.hpp"
#include "factorization/thresholds.hpp"
#include "simd/products-inl.hpp"
#include "simd/spread-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::kernels::HWY_NAMESPACE {
namespace {

double factor_with_exchanges(double* a, int* rows, int d) {
  double smallest = std::numeric_limits<double>::infinity();
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
    if (std::abs(a[p * d + p]) >= thresholds::diagonal_preferred * largest) best = p;
    rows[p] = best;
    if (!(largest > 0) || !(largest < std::numeric_limits<double>::infinity()))
      return largest > 0 ? std::numeric_limits<double>::quiet_NaN() : largest;
    const double size = std::abs(a[p * d + best]);
    smallest = size < smallest ? size : smallest;
    if (best != p)
      for (int j = 0; j < d; ++j) std::swap(a[j * d + p], a[j * d + best]);
    const double reciprocal = 1.0 / a[p * d + p];
    a[p * d + p] = reciprocal;
    for (int i = p + 1; i < d; ++i) a[p * d + i] *= reciprocal;
    for (int j = p + 1; j < d; ++j) subtract(a + j * d + p + 1, a + p * d + p + 1, a[j * d + p], d - p - 1);
  }
  return smallest;
}

/// The same, by whole columns in registers; each step stores what the next ones read single numbers of.
template <int D>
double factor_by_columns(double* a, int* rows) {
  static constexpr auto below = [] {  // read from place D - 1 - p on: zeros up to row p, then ones
    std::array<double, 2 * D> ones{};
    for (int i = D; i < 2 * D; ++i) ones[i] = 1;
    return ones;
  }();
  double u[D * D];
  Rows<D> t[D];
#pragma GCC unroll 12
  for (int j = 0; j < D; ++j) t[j] = Rows<D>::load(a + j * D);
  double smallest = std::numeric_limits<double>::infinity();
  bool sound = true;
#pragma GCC unroll 12
  for (int p = 0; p < D; ++p) {
#pragma GCC unroll 12
    for (int j = p; j < D; ++j) t[j].store(u + j * D);
    double* column = u + p * D;
    const double size = std::abs(column[p]);
    double largest = 0;
    for (int i = p + 1; i < D; ++i) largest = std::max(largest, std::abs(column[i]));
    sound &= (size >= thresholds::diagonal_preferred * largest) & (size > 0) & (size < std::numeric_limits<double>::infinity());
    smallest = size < smallest ? size : smallest;
    const double reciprocal = 1.0 / column[p];
    const Rows<D> l = t[p].times_each(Rows<D>::load(below.data() + D - 1 - p)).times(reciprocal);
#pragma GCC unroll 12
    for (int j = p + 1; j < D; ++j) t[j].subtract(l, u[j * D + p]);
    double multipliers[D];
    l.store(multipliers);
    column[p] = reciprocal;
    for (int i = p + 1; i < D; ++i) column[i] = multipliers[i];
  }
  if (!sound) return factor_with_exchanges(a, rows, D);
  std::copy_n(u, D * D, a);
  for (int p = 0; p < D; ++p) rows[p] = p;
  return smallest;
}

/// First without exchanges, in registers; that is nearly always enough.
template <int D>
double factor(double* a, int* rows, int d) {
  if constexpr (D == 0) {
    return factor_with_exchanges(a, rows, d);
  } else if constexpr (D > max_fixed) {
    return factor_by_columns<D>(a, rows);
  } else {
    double t[D][D];
    for (int j = 0; j < D; ++j)
      for (int i = 0; i < D; ++i) t[j][i] = a[j * D + i];
    double smallest = std::numeric_limits<double>::infinity();
    bool sound = true;
#pragma GCC unroll 6
    for (int p = 0; p < D; ++p) {
      const double size = std::abs(t[p][p]);
      double largest = 0;
#pragma GCC unroll 6
      for (int i = p + 1; i < D; ++i) {
        const double candidate = std::abs(t[p][i]);
        largest = candidate > largest ? candidate : largest;
      }
      sound &= (size >= thresholds::diagonal_preferred * largest) & (size > 0) & (size < std::numeric_limits<double>::infinity());
      smallest = size < smallest ? size : smallest;
      const double reciprocal = 1.0 / t[p][p];
      t[p][p] = reciprocal;
#pragma GCC unroll 6
      for (int i = p + 1; i < D; ++i) t[p][i] *= reciprocal;
#pragma GCC unroll 6
      for (int j = p + 1; j < D; ++j)
#pragma GCC unroll 6
        for (int i = p + 1; i < D; ++i) t[j][i] -= t[p][i] * t[j][p];
    }
    if (!sound) return factor_with_exchanges(a, rows, D);
    for (int j = 0; j < D; ++j)
      for (int i = 0; i < D; ++i) a[j * D + i] = t[j][i];
    for (int p = 0; p < D; ++p) rows[p] = p;
    return smallest;
  }
}

/// All of X := (LU)^-1 X, or only L^-1 X, or what then remains.
enum class Half { both, first, second };

/// As many columns of it as the tag has lanes, of which `count` are there: the chain of dependent
/// operations is walked once for all of them.
template <int D, Half H, class Tag>
HWY_INLINE void solve_columns(Tag tag, const double* a, double* x, int d_, std::ptrdiff_t stride, int count) {
  using V = hn::VFromD<Tag>;
  const int d = D ? D : d_;
  V t[D ? D : largest_together];
  load_columns<D>(tag, x, d, stride, count, t);
  if constexpr (H != Half::second) {
#pragma GCC unroll 12
    for (int p = 0; p < d; ++p)
#pragma GCC unroll 12
      for (int i = p + 1; i < d; ++i) t[i] = hn::NegMulAdd(hn::Set(tag, a[p * d + i]), t[p], t[i]);
  }
  if constexpr (H != Half::first) {
#pragma GCC unroll 12
    for (int p = d - 1; p >= 0; --p) {
      t[p] = hn::Mul(t[p], hn::Set(tag, a[p * d + p]));
#pragma GCC unroll 12
      for (int i = 0; i < p; ++i) t[i] = hn::NegMulAdd(hn::Set(tag, a[p * d + i]), t[p], t[i]);
    }
  }
  store_columns<D>(tag, x, d, stride, count, t);
}

/// One column of any dimension.
template <Half H>
void solve_large(const double* a, double* x, int d) {
  if constexpr (H != Half::second)
    for (int p = 0; p < d; ++p) subtract(x + p + 1, a + p * d + p + 1, x[p], d - p - 1);
  if constexpr (H != Half::first)
    for (int p = d - 1; p >= 0; --p) {
      x[p] *= a[p * d + p];
      subtract(x, a + p * d, x[p], p);
    }
}

template <int D, Half H>
void solve(const double* a, const int* rows, double* x, int d_, int n, std::ptrdiff_t stride) {
  const int d = D ? D : d_;
  if constexpr (H == Half::both) {
    int exchanged = 0;
    for (int p = 0; p < d; ++p) exchanged |= rows[p] ^ p;
    if (HWY_UNLIKELY(exchanged != 0))
      for (int c = 0; c < n; ++c)
        for (int p = 0; p < d; ++p) std::swap(x[c * stride + p], x[c * stride + rows[p]]);
  }
  if (D == 0 && d > largest_together) {
    for (int c = 0; c < n; ++c, x += stride) solve_large<H>(a, x, d);
    return;
  }
  constexpr int together = static_cast<int>(hn::MaxLanes(Together()));
  for (; n >= together; n -= together, x += together * stride)
    solve_columns<D, H>(Together(), a, x, d, stride, together);
  if (n == 1) solve_columns<D, H>(Single(), a, x, d, stride, 1);
  else if (together == 1) return;
  else if (n == 2) solve_columns<D, H>(Pair(), a, x, d, stride, 2);
  else if (n > 2) solve_columns<D, H>(Together(), a, x, d, stride, n);
}

template <int... I>
constexpr void fill(Table& t, std::integer_sequence<int, I...>) {
  t.products = {&product<I>...};
  t.lower_products = {&lower_product<I>...};
}
template <int... I>
constexpr void fill_rows_of_blocks(Table& t, std::integer_sequence<int, I...>) {
  t.spreads = {&spread<I + 1>...};
  t.halve_and_spreads = {&halve_and_spread<I + 1>...};
  t.rows_of_blocks = {&row_of_blocks<I + 1>...};
  t.watched_blocks = {&watched_block<I + 1>...};
  t.columns_of_blocks = {&column_of_blocks<I + 1>...};
  t.transposes = {&transpose_blocks<I + 1>...};
  t.backward_halves = {&backward_half<I + 1>...};
}
template <int... I>
constexpr void fill_solves(Table& t, std::integer_sequence<int, I...>) {
  t.forwards = {&forward<I + 1>...};
  t.backwards = {&backward<I + 1>...};
}
template <int... I>
constexpr void fill_by_dimension(Table& t, std::integer_sequence<int, I...>) {
  t.factors = {&factor<I>...};
  t.also_product = &product<also_fixed>;
  t.definite_factors = {&factor_definite<I>...};
  t.halves = {&halve<I>...};
  t.solves = {&solve<I, Half::both>...};
  t.first_solves = {&solve<I, Half::first>...};
  t.second_solves = {&solve<I, Half::second>...};
}

constexpr Table make_table() {
  Table t{};
  fill(t, std::make_integer_sequence<int, max_rows + 1>{});
  fill_rows_of_blocks(t, std::make_integer_sequence<int, max_spread>{});
  fill_solves(t, std::make_integer_sequence<int, max_equal>{});
  fill_by_dimension(t, std::integer_sequence<int, 0, 1, 2, 3, 4, 5, 6, also_fixed>{});
  return t;
}
constexpr Table here = make_table();

}  // namespace

const Table* TableOfTarget() { return &here; }

}  // namespace graphsolve::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graphsolve/simd/lanes.hpp"

namespace graphsolve::kernels {

HWY_EXPORT(TableOfTarget);

const Table& table() {
  (void)simd::instruction_set();  // chosen before the first kernel runs
  return *HWY_DYNAMIC_DISPATCH(TableOfTarget)();
}

}  // namespace graphsolve::kernels
#endif
