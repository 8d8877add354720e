#include "simd/pivot_kernels.hpp"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/pivot_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/pack_dense-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {
namespace {

/// The diagonal block of each lane's pivot.
HWY_INLINE void own_places(const PackJob& job, double** place) {
  for (int l = 0; l < lanes; ++l) place[l] = job.values + job.symbolic.pivot(job.pack.pivot[l]).diagonal;
}

/// Each lane's block between couplings i and j.
HWY_INLINE void target_places(const PackJob& job, int i, int j, double** place) {
  for (int l = 0; l < lanes; ++l) {
    const Symbolic::Pivot& p = job.symbolic.pivot(job.pack.pivot[l]);
    place[l] = job.values + job.symbolic.targets(p)[i * p.stride + j];
  }
}

/// reference[p]: what row p is compared with, signed.
HWY_INLINE void load_references(const PackJob& job, int d, Pack* reference) {
  const double* from[lanes];
  for (int l = 0; l < lanes; ++l) from[l] = job.reference + job.first_row[job.pack.pivot[l]];
  load_transposed(from, d, reference, job.pack.used);
}

/// Coupling i loses T on its diagonal: remembers the largest amount per row, lane after lane.
inline void remember(const PackJob& job, int i, const Pack* t, int rows, unsigned active) {
  HWY_ALIGN double lost[lanes];
  for (int q = 0; q < rows; ++q) {
    store(t[q * (rows + 1)], lost);
    for (int l = 0; l < lanes; ++l) {
      if (!(active >> l & 1u)) continue;
      double& reference = job.reference[job.first_row[job.symbolic.coupled(job.pack.pivot[l])[i]] + q];
      if (std::abs(lost[l]) > std::abs(reference)) reference = -lost[l];
    }
  }
}

template <int D>
unsigned eliminate_pack(const PackJob& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension, m = shape.couplings(), coupled_rows = shape.coupled_rows;
  Pack* lu = packs(job.factor);
  Pack* lower = lu + d * d;
  Pack* w = lower + d * coupled_rows;
  double* place[lanes];
  own_places(job, place);
  // Diagonal, lower and upper panel of a pivot lie one after the other.
  load_transposed(place, d * (d + 2 * coupled_rows), lu, job.pack.used);
  if (shape.saddle) {
    for (int i = 0; i < d; ++i) lu[i * (d + 1)] *= Pack(1 + job.saddle_shift);
  }
  const unsigned active = job.active, pivoting = factor<D>(lu, d) & active;
  if (pivoting != 0) return pivoting;
  solve_all<D>(lu, w, d, coupled_rows);

  Pack* t = packs(job.scratch);
  const Pack* l_block = lower;
  for (int i = 0; i < m; ++i) {
    const int rows = shape.coupled[i];
    const Pack* w_block = w;
    for (int j = 0; j < m; ++j) {
      const int columns = shape.coupled[j];
      product_block<D>(l_block, w_block, t, rows, columns, d);
      target_places(job, i, j, place);
      add_transposed(t, rows * columns, place, active, -1.0);
      w_block += columns * d;
    }
    l_block += rows * d;
  }
  return 0;
}

template <int D>
unsigned eliminate_pack_symmetric(const PackJob& job, const Definite& definite, Watch watch) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension, m = shape.couplings(), coupled_rows = shape.coupled_rows;
  Pack* lu = packs(job.factor);
  Pack* lower = lu + d * d;
  double* place[lanes];
  own_places(job, place);
  load_transposed(place, d * (d + coupled_rows), lu, job.pack.used);
  Pack reference[D ? D : largest_dimension];
  load_references(job, d, reference);
  for (int i = 0; i < d; ++i) reference[i] = abs(reference[i]);
  const unsigned active = job.active, other = factor_definite<D>(lu, reference, definite, d) & active;
  if (other != 0) return other;

  Pack* w = packs(job.scratch);
  Pack* t = w + d * coupled_rows;
  const Pack* l_block = lower;
  Pack* w_block = w;
  for (int i = 0; i < m; ++i) {
    const int rows = shape.coupled[i];
    for (int r = 0; r < rows; ++r)
#pragma GCC unroll 6
      for (int q = 0; q < d; ++q) w_block[r * d + q] = l_block[q * rows + r];
    l_block += rows * d;
    w_block += rows * d;
  }
  solve_all<D>(lu, w, d, coupled_rows);
  l_block = lower;
  for (int i = 0; i < m; ++i) {
    const int rows = shape.coupled[i];
    w_block = w;
    for (int j = 0; j < i; ++j) {
      const int columns = shape.coupled[j];
      product_block<D>(l_block, w_block, t, rows, columns, d);
      target_places(job, i, j, place);
      add_transposed(t, rows * columns, place, active, -1.0);
      w_block += columns * d;
    }
    product_lower<D>(l_block, w_block, t, rows, d);
    if (watch == Watch::yes && shape.coupled_may[i]) remember(job, i, t, rows, active);
    target_places(job, i, i, place);
    add_transposed(t, rows * rows, place, active, -1.0);
    l_block += rows * d;
  }
  return 0;
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

template <int D>
void backward_symmetric(const PackSolve& job) {
  const Shape& shape = job.shape;
  const int d = D ? D : shape.dimension;
  const Pack* lu = packs(job.factor);
  const Pack* l_block = lu + d * d;
  Pack coupled[largest_front], sum[D ? D : largest_dimension];
  double* place[lanes];
  for (int p = 0; p < d; ++p) sum[p] = Pack(0.0);
  for (int i = 0; i < shape.couplings(); ++i) {
    const int rows = shape.coupled[i];
    for (int l = 0; l < lanes; ++l) place[l] = job.x + job.rows[(i + 1) * lanes + l];
    load_transposed(place, rows, coupled, job.pack.used);
    for (int r = 0; r < rows; ++r)
#pragma GCC unroll 6
      for (int p = 0; p < d; ++p) sum[p] = multiply_add(l_block[p * rows + r], coupled[r], sum[p]);
    l_block += rows * d;
  }
  solve_columns<D, 1>(lu, sum, d);
  for (int l = 0; l < lanes; ++l) place[l] = job.x + job.rows[l];
  add_transposed(sum, d, place, job.active, -1.0);
}

/// The same function with the dimension as a constant, for the usual ones.
#define GRAPHSOLVE_BY_DIMENSION(d, function, ...)     \
  switch (d) {                                        \
    case 1: return function<1>(__VA_ARGS__);          \
    case 2: return function<2>(__VA_ARGS__);          \
    case 3: return function<3>(__VA_ARGS__);          \
    case 4: return function<4>(__VA_ARGS__);          \
    case 5: return function<5>(__VA_ARGS__);          \
    case 6: return function<6>(__VA_ARGS__);          \
    default: return function<0>(__VA_ARGS__);         \
  }

}  // namespace

unsigned Eliminate(const PackJob& job) { GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, eliminate_pack, job) }
unsigned EliminateSymmetric(const PackJob& job, const Definite& definite, Watch watch) {
  GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, eliminate_pack_symmetric, job, definite, watch)
}
void SolveForward(const PackSolve& job) { GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, forward, job) }
void SolveBackward(const PackSolve& job) { GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, backward, job) }
void SolveBackwardSymmetric(const PackSolve& job) {
  GRAPHSOLVE_BY_DIMENSION(job.shape.dimension, backward_symmetric, job)
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace graphsolve::simd {

HWY_EXPORT(Eliminate);
HWY_EXPORT(EliminateSymmetric);
HWY_EXPORT(SolveForward);
HWY_EXPORT(SolveBackward);
HWY_EXPORT(SolveBackwardSymmetric);

unsigned eliminate(const PackJob& job) { return HWY_DYNAMIC_DISPATCH(Eliminate)(job); }
unsigned eliminate_symmetric(const PackJob& job, const Definite& definite, Watch watch) {
  return HWY_DYNAMIC_DISPATCH(EliminateSymmetric)(job, definite, watch);
}
void solve_forward(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveForward)(job); }
void solve_backward(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveBackward)(job); }
void solve_backward_symmetric(const PackSolve& job) { HWY_DYNAMIC_DISPATCH(SolveBackwardSymmetric)(job); }

}  // namespace graphsolve::simd
#endif
