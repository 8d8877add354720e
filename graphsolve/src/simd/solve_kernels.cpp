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

/// The rows of a pivot's coupling in a vector in lanes. Values, not references, as in update_block (pivot_kernels.cpp).
template <int L>
class Coupled {
 public:
  HWY_INLINE Coupled(const PackSolve& job, int coupling)
      : Coupled(job, job.program.row_targets(job.pack)[coupling]) {}

  HWY_INLINE void load(int rows, PackOf<L>* to) const {
    if (place_ >= 0) {
      const double* at = x_ + place_;
      for (int r = 0; r < rows; ++r, at += stride_) to[r] = simd::HWY_NAMESPACE::load<L>(at);
      return;
    }
    for (int r = 0; r < rows; ++r)
      to[r] = each_lane<L>([&](int l) HWY_ATTR { return x_[lane_[l].place + r * lane_[l].stride]; });
  }
  /// The lanes do not share rows.
  HWY_INLINE void subtract(const PackOf<L>* t, int rows) const {
    if (place_ < 0) return subtract_by_lane(t, rows);
    const bool whole = active_ == all_lanes<L>;
    const MaskOf<L> mask = lanes_of<L>(active_);
    double* at = x_ + place_;
    for (int r = 0; r < rows; ++r, at += stride_) {
      const PackOf<L> before = simd::HWY_NAMESPACE::load<L>(at), after = before - t[r];
      store(whole ? after : select(mask, after, before), at);
    }
  }
  HWY_INLINE void subtract_lane(int l, const PackOf<L>* t, int rows) const {
    double* at = x_ + lane_[l].place;
    const std::ptrdiff_t stride = lane_[l].stride;
    const double* lost = reinterpret_cast<const double*>(t) + l;
    for (int r = 0; r < rows; ++r, at += stride, lost += L) *at -= *lost;
  }

 private:
  HWY_INLINE Coupled(const PackSolve& job, const Target& target)
      : place_(target.place), stride_(target.stride), lane_(job.program.scattered() + ~target.place), x_(job.x),
        active_(job.active) {}
  HWY_INLINE void subtract_by_lane(const PackOf<L>* t, int rows) const {
    for (int l = 0; l < L; ++l)
      if (active_ >> l & 1u) subtract_lane(l, t, rows);
  }

  std::int64_t place_;
  std::ptrdiff_t stride_;
  const Target* lane_;  ///< where they do not lie side by side
  double* x_;
  unsigned active_;
};

/// The coupled rows lose t. If pivots share couplings, lane after lane, as if they went one after the other.
template <int L>
HWY_INLINE void subtract_coupled(const PackSolve& job, const Shape& shape, const PackOf<L>* t) {
  if (!job.pack.shares) {
    for (int i = 0; i < shape.couplings(); t += shape.coupled[i++]) Coupled<L>(job, i).subtract(t, shape.coupled[i]);
    return;
  }
  for (int l = 0; l < L; ++l) {
    if (!(job.active >> l & 1u)) continue;
    const PackOf<L>* lost = t;
    for (int i = 0; i < shape.couplings(); lost += shape.coupled[i++]) Coupled<L>(job, i).subtract_lane(l, lost, shape.coupled[i]);
  }
}

template <int L>
HWY_INLINE void load_own(const PackSolve& job, int d, PackOf<L>* x) {
  const double* from = job.x + job.pack.lane_rows;
  for (int p = 0; p < d; ++p) x[p] = load<L>(from + p * L);
}
template <int L>
HWY_INLINE void store_own(const PackSolve& job, int d, const PackOf<L>* x) {
  double* at = job.x + job.pack.lane_rows;
  if (job.active == all_lanes<L>) {
    for (int p = 0; p < d; ++p) store(x[p], at + p * L);
    return;
  }
  const MaskOf<L> mask = lanes_of<L>(job.active);
  for (int p = 0; p < d; ++p) store(select(mask, x[p], load<L>(at + p * L)), at + p * L);
}

/// Each lane's rows of a vector of the user's: of its pivot (block 0) or of coupling block - 1.
template <int L, class T>
HWY_INLINE void point_at(const Program& program, const PivotPack& pack, T* x, int block, T** place) {
  for (int l = 0; l < L; ++l) place[l] = x + program.rows(pack)[block * L + l];
}

/// Where the rows of the pivots are final.
template <int L>
HWY_INLINE void finish_own(const PackSolve& job, int d, const PackOf<L>* x) {
  store_own<L>(job, d, x);
  double* place[L];
  point_at<L>(job.program, job.pack, job.result, 0, place);
  store_transposed(x, d, place, job.active);
}

template <int D, int L>
void forward(const PackSolve& job) {
  const Shape& shape = job.program.shape(job.pack);
  const int d = D ? D : shape.dimension;
  const double* diagonal = job.factor + job.pack.place;
  const Stored<L> lu{diagonal};
  PackOf<L> x[D ? D : largest_dimension], t[largest_front];
  load_own<L>(job, d, x);
  if (job.form == Form::ldlt) {
    solve_lower<D, 1>(lu, x, d);
    PackOf<L> scaled[D ? D : largest_dimension];
    for (int p = 0; p < d; ++p) scaled[p] = x[p] * lu[p * (d + 1)];
    store_own<L>(job, d, scaled);
  } else {
    solve_columns<D, 1>(lu, x, d);
    store_own<L>(job, d, x);
  }
  const double* lower = diagonal + d * d * L;
  PackOf<L>* sum = t;
  for (int i = 0; i < shape.couplings(); ++i) {
    const std::ptrdiff_t rows = shape.coupled[i], next = rows * L;
    const double* row = lower;
    for (int r = 0; r < rows; ++r, ++sum, row += L) {
      *sum = load<L>(row) * x[0];
#pragma GCC unroll 6
      for (int p = 1; p < d; ++p) *sum = multiply_add(load<L>(row + p * next), x[p], *sum);
    }
    lower += next * d;
  }
  subtract_coupled<L>(job, shape, t);
}

template <int D, int L>
void backward(const PackSolve& job) {
  const Shape& shape = job.program.shape(job.pack);
  const int d = D ? D : shape.dimension;
  const double* w = job.factor + job.pack.upper;
  PackOf<L> coupled[largest_dimension], sum[D ? D : largest_dimension], x[D ? D : largest_dimension];
  for (int p = 0; p < d; ++p) sum[p] = PackOf<L>(0.0);
  for (int i = 0; i < shape.couplings(); ++i) {
    Coupled<L>(job, i).load(shape.coupled[i], coupled);
    for (int c = 0; c < shape.coupled[i]; ++c, w += d * L)
#pragma GCC unroll 6
      for (int p = 0; p < d; ++p) sum[p] = multiply_add(load<L>(w + p * L), coupled[c], sum[p]);
  }
  load_own<L>(job, d, x);
  for (int p = 0; p < d; ++p) x[p] = x[p] - sum[p];
  finish_own<L>(job, d, x);
}

template <int L>
void forward_transposed(const PackSolve& job) {
  const Shape& shape = job.program.shape(job.pack);
  const int d = shape.dimension;
  const double* w = job.factor + job.pack.upper;
  PackOf<L> x[largest_dimension], t[largest_front];
  load_own<L>(job, d, x);
  for (int r = 0; r < shape.coupled_rows; ++r, w += d * L) {
    t[r] = load<L>(w) * x[0];
    for (int p = 1; p < d; ++p) t[r] = multiply_add(load<L>(w + p * L), x[p], t[r]);
  }
  subtract_coupled<L>(job, shape, t);
}

template <int D, int L>
void backward_transposed(const PackSolve& job) {
  const Shape& shape = job.program.shape(job.pack);
  const int d = D ? D : shape.dimension;
  const double* diagonal = job.factor + job.pack.place;
  const Stored<L> lu{diagonal};
  PackOf<L> x[D ? D : largest_dimension], coupled[largest_dimension];
  load_own<L>(job, d, x);
  const double* lower = diagonal + d * d * L;
  for (int i = 0; i < shape.couplings(); ++i) {
    const int rows = shape.coupled[i];
    const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(rows) * L;
    Coupled<L>(job, i).load(rows, coupled);
    const double* row = lower;
    for (int r = 0; r < rows; ++r, row += L)
#pragma GCC unroll 6
      for (int p = 0; p < d; ++p) x[p] = negative_multiply_add(load<L>(row + p * next), coupled[r], x[p]);
    lower += next * d;
  }
  if (job.form == Form::ldu) solve_upper_transposed<D>(lu, x, d);
  solve_lower_transposed<D>(lu, x, d);
  finish_own<L>(job, d, x);
}

template <int D, int L>
void enter(const Program& program, const PivotPack& pack, const double* user, double* to) {
  const int d = D ? D : program.shape(pack).dimension;
  PackOf<L> x[D ? D : largest_dimension];
  const double* place[L];
  point_at<L>(program, pack, user, 0, place);
  load_transposed(place, d, x, pack.used);
  for (int p = 0; p < d; ++p) store(x[p], to + pack.lane_rows + p * L);
}

/// The coupled rows of `to`, a vector of the user's, += sign t. If pivots share couplings, lane after lane.
template <int L>
HWY_INLINE void add_coupled(const PackResidual& job, const Shape& shape, const PackOf<L>* t, double* to, double sign) {
  double* place[L];
  if (!job.pack.shares || L == 1) {
    for (int i = 0; i < shape.couplings(); t += shape.coupled[i++]) {
      point_at<L>(job.program, job.pack, to, i + 1, place);
      add_transposed(t, shape.coupled[i], place, job.active, sign);
    }
    return;
  }
  for (int l = 0; l < L; ++l) {
    if (!(job.active >> l & 1u)) continue;
    const double* lane = reinterpret_cast<const double*>(t) + l;
    for (int i = 0; i < shape.couplings(); lane += L * shape.coupled[i++]) {
      point_at<L>(job.program, job.pack, to, i + 1, place);
      for (int r = 0; r < shape.coupled[i]; ++r) place[l][r] += sign * lane[r * L];
    }
  }
}

/// sum and its magnitude += a b, number by number.
template <int L>
HWY_INLINE void take_up(const PackOf<L>& a, const PackOf<L>& b, PackOf<L>& sum, PackOf<L>& magnitude) {
  sum = multiply_add(a, b, sum);
  magnitude = multiply_add(abs(a), abs(b), magnitude);
}

template <int L>
void residual(const PackResidual& job) {
  using P = PackOf<L>;
  const Shape& shape = job.program.shape(job.pack);
  const int d = shape.dimension;
  P x[largest_dimension], coupled[largest_front], sum[largest_front], magnitude[largest_front];
  const double* from[L];
  double* place[L];
  point_at<L>(job.program, job.pack, job.x, 0, from);
  load_transposed(from, d, x, job.pack.used);
  for (int p = 0; p < d; ++p) sum[p] = magnitude[p] = P(0.0);
  const double* a = job.matrix + job.pack.place;
  for (int q = 0; q < d; ++q)
    for (int p = 0; p < d; ++p, a += L) take_up(load<L>(a), x[q], sum[p], magnitude[p]);
  const double* lower = a;
  a = job.matrix + job.pack.upper;
  for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++]) {
    point_at<L>(job.program, job.pack, job.x, i + 1, from);
    load_transposed(from, shape.coupled[i], coupled + row, job.pack.used);
  }
  for (int c = 0; c < shape.coupled_rows; ++c)
    for (int p = 0; p < d; ++p, a += L) take_up(load<L>(a), coupled[c], sum[p], magnitude[p]);
  point_at<L>(job.program, job.pack, job.residual, 0, place);
  add_transposed(sum, d, place, job.active, -1.0);
  point_at<L>(job.program, job.pack, job.magnitude, 0, place);
  add_transposed(magnitude, d, place, job.active, 1.0);
  for (int c = 0; c < shape.coupled_rows; ++c) sum[c] = magnitude[c] = P(0.0);
  for (int i = 0, row = 0; i < shape.couplings(); row += shape.coupled[i++])
    for (int q = 0; q < d; ++q)
      for (int r = row; r < row + shape.coupled[i]; ++r, lower += L) take_up(load<L>(lower), x[q], sum[r], magnitude[r]);
  add_coupled<L>(job, shape, sum, job.residual, -1.0);
  add_coupled<L>(job, shape, magnitude, job.magnitude, 1.0);
}

// Those that are needed rarely take dimensions at run time: half the time to compile this file.
constexpr Solves here{
    .forward = by_kind([]<int D, int L>() -> simd::Solve { return &forward<D, L>; }),
    .backward = by_kind([]<int D, int L>() -> simd::Solve { return &backward<D, L>; }),
    .forward_transposed = by_kind([]<int, int L>() -> simd::Solve { return &forward_transposed<L>; }),
    .backward_transposed = by_kind([]<int D, int L>() -> simd::Solve { return &backward_transposed<D, L>; }),
    .residual = by_kind([]<int, int L>() -> simd::Residual { return &residual<L>; })};

using Enter = void (*)(const Program&, const PivotPack&, const double*, double*);
constexpr ByKind<Enter> enters = by_kind([]<int D, int L>() -> Enter { return &enter<D, L>; });

}  // namespace

const Solves* SolvesOfTarget() { return &here; }

void ToLanes(const Program& program, std::span<const Program::Step> steps, const double* x, double* to) {
  for (const Program::Step& step : steps) {
    if (step.pack < 0) continue;
    const PivotPack& pack = program.pack(step.pack);
    enters[pack.kind](program, pack, x, to);
  }
}

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace graphsolve::simd {

HWY_EXPORT(SolvesOfTarget);
HWY_EXPORT(ToLanes);

const Solves& solves() {
  (void)instruction_set();  // chosen before the first kernel runs
  return *HWY_DYNAMIC_DISPATCH(SolvesOfTarget)();
}
void to_lanes(const Program& program, std::span<const Program::Step> steps, const double* x, double* to) {
  HWY_DYNAMIC_DISPATCH(ToLanes)(program, steps, x, to);
}

}  // namespace graphsolve::simd
#endif
