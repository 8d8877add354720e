#include "simd/pivot_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/solve_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/pack_dense-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {
namespace {

/// Each lane's rows of x: of its pivot (block 0) or of coupling block - 1.
template <int L, class Job, class T>
HWY_INLINE void point_at(const Job& job, T* x, int block, T** place) {
  for (int l = 0; l < L; ++l) place[l] = x + job.rows[block * L + l];
}
template <int L>
HWY_INLINE void point_at(const PackSolve& job, int block, double** place) {
  point_at<L>(job, job.x, block, place);
}

/// The coupled rows of `to` += sign t. If pivots share couplings, lane after lane, as if they went one after the other.
template <int L, class Job>
HWY_INLINE void add_coupled(const Job& job, const PackOf<L>* t, double* to, double sign) {
  const Shape& shape = job.shape;
  double* place[L];
  if (!job.pack.shares || L == 1) {
    for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++]) {
      point_at<L>(job, to, i + 1, place);
      add_transposed(t + row, shape.coupled[i], place, job.active, sign);
    }
    return;
  }
  double lanes[L][largest_front];
  for (int l = 0; l < L; ++l) place[l] = lanes[l];
  store_transposed(t, shape.coupled_rows, place, job.pack.used);
  for (int l = 0; l < L; ++l) {
    if (!(job.active >> l & 1u)) continue;
    for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++]) {
      double* x = to + job.rows[(i + 1) * L + l];
      for (int r = 0; r < shape.coupled[i]; ++r) x[r] += sign * lanes[l][row + r];
    }
  }
}

template <int D, int L>
void forward(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  PackOf<L> lu[D ? D * D : largest_dimension * largest_dimension], x[D ? D : largest_dimension], t[largest_front];
  double* place[L];
  point_at<L>(job, 0, place);
  load_transposed(place, d, x, job.pack.used);
  if (job.form == Form::ldlt) {
    load_lower<D>(job.factor, lu, d);
    solve_lower<D, 1>(lu, x, d);
  } else {
    load_diagonal<D>(job.factor, lu, d);
    solve_columns<D, 1>(lu, x, d);
  }
  store_transposed(x, d, place, job.active);
  const double* lower = job.factor + d * d * L;
  PackOf<L>* sum = t;
  for (int i = 0; i < shape.couplings(); ++i) {
    const int rows = shape.coupled[i];
    for (int r = 0; r < rows; ++r, ++sum) {
      *sum = load<L>(lower + r * L) * x[0];
#pragma GCC unroll 6
      for (int p = 1; p < d; ++p) *sum = multiply_add(load<L>(lower + (p * rows + r) * L), x[p], *sum);
    }
    lower += rows * d * L;
  }
  add_coupled(job, t, job.x, -1.0);
}

template <int D, int L>
void backward(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  const double* w = job.factor + d * (d + shape.coupled_rows) * L;
  PackOf<L> coupled[largest_front], sum[D ? D : largest_dimension];
  double* place[L];
  for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++]) {
    point_at<L>(job, i + 1, place);
    load_transposed(place, shape.coupled[i], coupled + row, job.pack.used);
  }
  for (int p = 0; p < d; ++p) sum[p] = PackOf<L>(0.0);
  for (int c = 0; c < shape.coupled_rows; ++c)
#pragma GCC unroll 6
    for (int p = 0; p < d; ++p) sum[p] = multiply_add(load<L>(w + (c * d + p) * L), coupled[c], sum[p]);
  point_at<L>(job, 0, place);
  add_transposed(sum, d, place, job.active, -1.0);
}

template <int D, int L>
void forward_transposed(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  const double* w = job.factor + d * (d + shape.coupled_rows) * L;
  PackOf<L> x[D ? D : largest_dimension], t[largest_front];
  double* place[L];
  point_at<L>(job, 0, place);
  load_transposed(place, d, x, job.pack.used);
  for (int r = 0; r < shape.coupled_rows; ++r, w += d * L) {
    t[r] = load<L>(w) * x[0];
#pragma GCC unroll 6
    for (int p = 1; p < d; ++p) t[r] = multiply_add(load<L>(w + p * L), x[p], t[r]);
  }
  add_coupled(job, t, job.x, -1.0);
}

template <int D, int L>
void backward_transposed(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  PackOf<L> lu[D ? D * D : largest_dimension * largest_dimension], x[D ? D : largest_dimension], coupled[largest_front];
  double* place[L];
  const bool ldlt = job.form == Form::ldlt;
  point_at<L>(job, 0, place);
  load_transposed(place, d, x, job.pack.used);
  if (ldlt) {
    load_lower<D>(job.factor, lu, d);
    for (int p = 0; p < d; ++p) x[p] *= lu[p * (d + 1)];
  } else {
    load_diagonal<D>(job.factor, lu, d);
  }
  const double* lower = job.factor + d * d * L;
  for (int i = 0; i < shape.couplings(); ++i) {
    const int rows = shape.coupled[i];
    point_at<L>(job, i + 1, place);
    load_transposed(place, rows, coupled, job.pack.used);
    for (int r = 0; r < rows; ++r)
#pragma GCC unroll 6
      for (int p = 0; p < d; ++p) x[p] = negative_multiply_add(load<L>(lower + (p * rows + r) * L), coupled[r], x[p]);
    lower += rows * d * L;
  }
  if (!ldlt) solve_upper_transposed<D>(lu, x, d);
  solve_lower_transposed<D>(lu, x, d);
  point_at<L>(job, 0, place);
  store_transposed(x, d, place, job.active);
}

/// sum and its magnitude += a b, number by number.
template <int L>
HWY_INLINE void take_up(const PackOf<L>& a, const PackOf<L>& b, PackOf<L>& sum, PackOf<L>& magnitude) {
  sum = multiply_add(a, b, sum);
  magnitude = multiply_add(abs(a), abs(b), magnitude);
}

template <int D, int L>
void residual(const PackResidual& job) {
  using P = PackOf<L>;
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  P x[D ? D : largest_dimension], coupled[largest_front], sum[largest_front], magnitude[largest_front];
  const double* from[L];
  double* place[L];
  point_at<L>(job, job.x, 0, from);
  load_transposed(from, d, x, job.pack.used);
  for (int p = 0; p < d; ++p) sum[p] = magnitude[p] = P(0.0);
  const double* a = job.matrix;
  for (int q = 0; q < d; ++q)
    for (int p = 0; p < d; ++p, a += L) take_up(load<L>(a), x[q], sum[p], magnitude[p]);
  const double* lower = a;
  a += d * shape.coupled_rows * L;
  for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++]) {
    point_at<L>(job, job.x, i + 1, from);
    load_transposed(from, shape.coupled[i], coupled + row, job.pack.used);
  }
  for (int c = 0; c < shape.coupled_rows; ++c)
    for (int p = 0; p < d; ++p, a += L) take_up(load<L>(a), coupled[c], sum[p], magnitude[p]);
  point_at<L>(job, job.residual, 0, place);
  add_transposed(sum, d, place, job.active, -1.0);
  point_at<L>(job, job.magnitude, 0, place);
  add_transposed(magnitude, d, place, job.active, 1.0);
  for (int c = 0; c < shape.coupled_rows; ++c) sum[c] = magnitude[c] = P(0.0);
  for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++])
    for (int q = 0; q < d; ++q)
      for (int r = row; r < row + shape.coupled[i]; ++r, lower += L) take_up(load<L>(lower), x[q], sum[r], magnitude[r]);
  add_coupled(job, sum, job.residual, -1.0);
  add_coupled(job, magnitude, job.magnitude, 1.0);
}

}  // namespace

void SolveForward(const PackSolve& job) { GRAPHSOLVE_BY_SHAPE(job.pack.lanes, job.shape.dimension, forward, job) }
void SolveBackward(const PackSolve& job) { GRAPHSOLVE_BY_SHAPE(job.pack.lanes, job.shape.dimension, backward, job) }
void SolveForwardTransposed(const PackSolve& job) {
  GRAPHSOLVE_BY_SHAPE(job.pack.lanes, job.shape.dimension, forward_transposed, job)
}
void SolveBackwardTransposed(const PackSolve& job) {
  GRAPHSOLVE_BY_SHAPE(job.pack.lanes, job.shape.dimension, backward_transposed, job)
}

void SubtractProduct(const PackResidual& job) {
  GRAPHSOLVE_BY_SHAPE(job.pack.lanes, job.shape.dimension, residual, job)
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace graphsolve::simd {

HWY_EXPORT(SolveForward);
HWY_EXPORT(SolveBackward);
HWY_EXPORT(SolveForwardTransposed);
HWY_EXPORT(SolveBackwardTransposed);
HWY_EXPORT(SubtractProduct);

void solve_forward(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveForward)(job); }
void solve_backward(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveBackward)(job); }
void solve_forward_transposed(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveForwardTransposed)(job); }
void solve_backward_transposed(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveBackwardTransposed)(job); }
void subtract_product(const PackResidual& job) { HWY_DYNAMIC_DISPATCH(SubtractProduct)(job); }

}  // namespace graphsolve::simd
#endif
