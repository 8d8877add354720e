#include "simd/pivot_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/pivot_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "graphsolve/simd/pack-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {
namespace {

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
unsigned factor(Pack* a, int d_) {
  const int d = D ? D : d_;
  Pack start[D ? D : largest_dimension], growth[D ? D : largest_dimension];
  for (int p = 0; p < d; ++p) {
    start[p] = abs(a[p * d + p]);
    growth[p] = Pack(0.0);
  }
  Mask sound = start[0] >= Pack(0.0);  // false for NaN
  for (int p = 0; p < d; ++p) {
    const Pack pivot = a[p * d + p];
    sound = sound & (abs(pivot) > Pack(least_rest) * start[p]) & (growth[p] <= Pack(most_growth) * start[p]) &
            (start[p] < Pack(1e300));
    const Pack reciprocal = Pack(1.0) / pivot;
    a[p * d + p] = reciprocal;
    for (int i = p + 1; i < d; ++i) a[p * d + i] *= reciprocal;
    for (int j = p + 1; j < d; ++j) {
      const Pack u = a[j * d + p];
      growth[j] += abs(a[p * d + j] * u);
      for (int i = p + 1; i < d; ++i) a[j * d + i] = negative_multiply_add(a[p * d + i], u, a[j * d + i]);
    }
  }
  return ~bits(sound);
}

/// X (d x C) := (LU)^-1 X.
template <int D, int C>
HWY_INLINE void solve_columns(const Pack* a, Pack* x, int d_) {
  const int d = D ? D : d_;
  Pack t[(D ? D : largest_dimension) * C];
  for (int i = 0; i < d * C; ++i) t[i] = x[i];
  for (int p = 0; p < d; ++p)
    for (int i = p + 1; i < d; ++i)
      for (int c = 0; c < C; ++c) t[c * d + i] = negative_multiply_add(a[p * d + i], t[c * d + p], t[c * d + i]);
  for (int p = d - 1; p >= 0; --p) {
    for (int c = 0; c < C; ++c) t[c * d + p] *= a[p * d + p];
    for (int i = 0; i < p; ++i)
      for (int c = 0; c < C; ++c) t[c * d + i] = negative_multiply_add(a[p * d + i], t[c * d + p], t[c * d + i]);
  }
  for (int i = 0; i < d * C; ++i) x[i] = t[i];
}

/// T (rows x C, leading dimension rows) := L (rows x d) W (d x C).
template <int D, int C>
HWY_INLINE void product(const Pack* l, const Pack* w, Pack* t, int rows, int d_) {
  const int d = D ? D : d_;
  Pack column[(D ? D : largest_dimension) * C];
  for (int i = 0; i < d * C; ++i) column[i] = w[i];
  for (int r = 0; r < rows; ++r) {
    Pack sum[C];
    const Pack first = l[r];
    for (int c = 0; c < C; ++c) sum[c] = first * column[c * d];
    for (int p = 1; p < d; ++p) {
      const Pack factor = l[p * rows + r];
      for (int c = 0; c < C; ++c) sum[c] = multiply_add(factor, column[c * d + p], sum[c]);
    }
    for (int c = 0; c < C; ++c) t[c * rows + r] = sum[c];
  }
}

template <int D>
unsigned eliminate_pack(const PackJob& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension, m = shape.couplings(), coupled_rows = shape.coupled_rows;
  Pack* lu = packs(job.factor);
  Pack* lower = lu + d * d;
  Pack* w = lower + d * coupled_rows;
  const Symbolic::Pivot* pivot[lanes];
  const double* place[lanes];
  for (int l = 0; l < lanes; ++l) {
    pivot[l] = &job.symbolic.pivot(job.pack.pivot[l]);
    place[l] = job.values + pivot[l]->diagonal;
  }
  // Diagonal, lower and upper panel of a pivot lie one after the other.
  load_transposed(place, d * (d + 2 * coupled_rows), lu, job.pack.used);
  if (job.pack.saddle)
    for (int i = 0; i < d; ++i) lu[i * (d + 1)] *= Pack(1 + job.saddle_shift);
  const unsigned pivoting = factor<D>(lu, d) & job.active;
  const unsigned active = job.active & ~pivoting;
  int column = 0;
  for (; column + columns_at_once <= coupled_rows; column += columns_at_once)
    solve_columns<D, columns_at_once>(lu, w + column * d, d);
  for (; column < coupled_rows; ++column) solve_columns<D, 1>(lu, w + column * d, d);

  Pack* t = packs(job.scratch);
  double* target[lanes];
  const Pack* l_block = lower;
  for (int i = 0; i < m; ++i) {
    const int rows = shape.coupled[i];
    const Pack* w_block = w;
    for (int j = 0; j < m; ++j) {
      const int columns = shape.coupled[j];
      int c = 0;
      for (; c + columns_at_once <= columns; c += columns_at_once)
        product<D, columns_at_once>(l_block, w_block + c * d, t + c * rows, rows, d);
      for (; c < columns; ++c) product<D, 1>(l_block, w_block + c * d, t + c * rows, rows, d);
      for (int l = 0; l < lanes; ++l) target[l] = job.values + job.symbolic.targets(*pivot[l])[i * pivot[l]->stride + j];
      add_transposed(t, rows * columns, target, active, -1.0);
      w_block += columns * d;
    }
    l_block += rows * d;
  }
  return pivoting;
}

template <int D>
void forward(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  const Pack* lu = packs(job.factor);
  const Pack* l_block = lu + d * d;
  Pack x[D ? D : largest_dimension], t[largest_front];
  double* place[lanes];
  for (int l = 0; l < lanes; ++l) place[l] = job.x + job.rows[l];
  load_transposed(place, d, x, job.pack.used);
  solve_columns<D, 1>(lu, x, d);
  store_transposed(x, d, place, job.active);
  for (int i = 0; i < shape.couplings(); ++i) {
    const int rows = shape.coupled[i];
    product<D, 1>(l_block, x, t, rows, d);
    for (int l = 0; l < lanes; ++l) place[l] = job.x + job.rows[(i + 1) * lanes + l];
    add_transposed(t, rows, place, job.active, -1.0);
    l_block += rows * d;
  }
}

template <int D>
void backward(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  const Pack* w = packs(job.factor) + d * (d + shape.coupled_rows);
  Pack coupled[largest_front];
  double* place[lanes];
  for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++]) {
    for (int l = 0; l < lanes; ++l) place[l] = job.x + job.rows[(i + 1) * lanes + l];
    load_transposed(place, shape.coupled[i], coupled + row, job.pack.used);
  }
  Pack sum[D ? D : largest_dimension];
  for (int p = 0; p < d; ++p) sum[p] = Pack(0.0);
  for (int c = 0; c < shape.coupled_rows; ++c)
    for (int p = 0; p < d; ++p) sum[p] = multiply_add(w[c * d + p], coupled[c], sum[p]);
  for (int l = 0; l < lanes; ++l) place[l] = job.x + job.rows[l];
  add_transposed(sum, d, place, job.active, -1.0);
}

/// The same function with the dimension as a constant, for the usual ones.
#define GRAPHSOLVE_BY_DIMENSION(d, function, job)     \
  switch (d) {                                        \
    case 1: return function<1>(job);                  \
    case 2: return function<2>(job);                  \
    case 3: return function<3>(job);                  \
    case 4: return function<4>(job);                  \
    case 5: return function<5>(job);                  \
    case 6: return function<6>(job);                  \
    default: return function<0>(job);                 \
  }

}  // namespace

unsigned Eliminate(const PackJob& job) { GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, eliminate_pack, job) }
void SolveForward(const PackSolve& job) { GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, forward, job) }
void SolveBackward(const PackSolve& job) { GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, backward, job) }

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace graphsolve::simd {

HWY_EXPORT(Eliminate);
HWY_EXPORT(SolveForward);
HWY_EXPORT(SolveBackward);

unsigned eliminate(const PackJob& job) { return HWY_DYNAMIC_DISPATCH(Eliminate)(job); }
void solve_forward(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveForward)(job); }
void solve_backward(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveBackward)(job); }

}  // namespace graphsolve::simd
#endif
