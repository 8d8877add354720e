#include "simd/pivot_kernels.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/pivot_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/halves-inl.hpp"
#include "simd/pack_dense-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {
namespace {

/// A pack's diagonal block and those below where it may work on them: in place, or, where some of its lanes have to stay as
/// they are, a copy that is written back lane by lane. The same for the blocks to the right.
template <int L>
class Workplace {
 public:
  HWY_INLINE Workplace(const PackJob& job, std::int64_t place, double* copy, int size)
      : own_(job.numbers.values + place), size_(size), active_(job.active),
        whole_(job.active == job.pack.used), work_(whole_ ? own_ : copy) {
    if (!whole_) std::copy_n(own_, size * L, work_);
  }
  HWY_INLINE double* blocks() const { return work_; }
  HWY_INLINE void finish() const {
    if (whole_) return;
    const MaskOf<L> mask = lanes_of<L>(active_);
    for (int i = 0; i < size_; ++i)
      store(select(mask, load<L>(work_ + i * L), load<L>(own_ + i * L)), own_ + i * L);
  }

 private:
  double* own_;
  int size_;
  unsigned active_;
  bool whole_;
  double* work_;
};

/// reference[p]: what row p is compared with, signed.
template <int L>
HWY_INLINE void load_references(const PackJob& job, int d, PackOf<L>* reference) {
  const double* from = job.numbers.reference + job.pack.lane_rows;
  for (int p = 0; p < d; ++p) reference[p] = load<L>(from + p * L);
}

/// The block of coupling i loses this square (columns first): remembers the largest amount per row of its diagonal; where
/// pivots share couplings, lane after lane.
template <int L>
void remember(const PackJob& job, int i, const double* lost, int rows) {
  const Target& target = job.program.row_targets(job.pack)[i];
  const int next = (rows + 1) * L;
  if (target.place >= 0) {
    const MaskOf<L> mask = lanes_of<L>(job.active);
    for (int q = 0; q < rows; ++q, lost += next) {
      double* at = job.numbers.reference + target.place + q * target.stride;
      const PackOf<L> before = load<L>(at), added = -load<L>(lost);
      store(select(mask, select(abs(added) > abs(before), added, before), before), at);
    }
    return;
  }
  for (int l = 0; l < L; ++l) {
    if (!(job.active >> l & 1u)) continue;
    const Target& lane = job.program.scattered()[~target.place + l];
    double* at = job.numbers.reference + lane.place;
    for (int q = 0; q < rows; ++q, at += lane.stride) {
      const double added = -lost[q * next + l];
      *at = std::abs(added) > std::abs(*at) ? added : *at;  // no branch: unpredictable
    }
  }
}

/// A lane's block loses its part of T (rows x columns, or its lower triangle), which lies interleaved.
template <int L>
HWY_INLINE void subtract_lane(const PackJob& job, int l, const Target& target, const double* t, int rows, int columns,
                              bool lower) {
  double* to = job.numbers.values + target.place;
  const std::ptrdiff_t stride = target.stride;
  t += l;
  if (!lower) {
    const double* end = t + rows * columns * L;
#pragma GCC unroll 4
    for (; t != end; t += L, to += stride) *to -= *t;
    return;
  }
  for (int c = 0; c < columns; ++c)
    for (int r = c; r < rows; ++r) to[(c * rows + r) * stride] -= t[(c * rows + r) * L];
}

/// In a pack whose pivots share couplings all T are kept until they are complete: a block that several lanes change loses
/// the first lane's part first, as if pivots went one after the other. T of couplings i, j begins at
/// (row of i) * coupled_rows + (row of j) * (rows of i).
template <int L>
void subtract_all(const PackJob& job, bool symmetric) {
  const Shape& shape = job.program.shape(job.pack);
  const int m = shape.couplings();
  const Target* target = job.program.targets(job.pack);
  for (int l = 0; l < L; ++l) {
    if (!(job.active >> l & 1u)) continue;
    const double* t = job.numbers.scratch + shape.size() * L;
    for (int i = 0, row = 0; i < m; row += shape.coupled[i++]) {
      const int rows = shape.coupled[i];
      for (int j = 0, column = 0; j < (symmetric ? i + 1 : m); column += shape.coupled[j++])
        subtract_lane<L>(job, l, job.program.scattered()[~target[i * m + j].place + l],
                         t + (row * shape.coupled_rows + column * rows) * L, rows, shape.coupled[j], symmetric && i == j);
    }
  }
}

/// One block between couplings: i is `row` rows down, j `column`.
struct Between {
  int i, j, row, column;
  bool lower;  ///< on the diagonal of a symmetric matrix: the lower triangle only
  bool watch;  ///< what its diagonal loses is remembered
};

/// A block loses T, which lies interleaved, in the lanes that are active.
template <int L>
void subtract_lanes(const PackJob& job, const Between& at, const Target& target, const double* t) {
  const Shape& shape = job.program.shape(job.pack);
  const int rows = shape.coupled[at.i], columns = shape.coupled[at.j];
  if (target.place < 0) {
    for (int l = 0; l < L; ++l)
      if (job.active >> l & 1u)
        subtract_lane<L>(job, l, job.program.scattered()[~target.place + l], t, rows, columns, at.lower);
    return;
  }
  const MaskOf<L> mask = lanes_of<L>(job.active);
  for (int c = 0; c < columns; ++c)
    for (int i = c * rows + (at.lower ? c : 0); i < (c + 1) * rows; ++i) {
      double* to = job.numbers.values + target.place + static_cast<std::ptrdiff_t>(i) * target.stride;
      const PackOf<L> before = load<L>(to);
      store(select(mask, before - load<L>(t + i * L), before), to);
    }
}

template <int D, int L, bool Lower, class F>
HWY_INLINE void each_product(const double* l, const double* w, int rows, int columns, int d, F&& f) {
  if constexpr (Lower) product_lower<D, L>(l, w, rows, d, f);
  else product_block<D, L>(l, w, rows, columns, d, f);
}

/// The block between two couplings loses L W. Usually at once; elsewhere the product is kept first.
template <int D, int L, bool Lower>
HWY_INLINE void update_block(const PackJob& job, const Between& at, const double* l, const double* w, int d) {
  const Shape& shape = job.program.shape(job.pack);
  const int rows = shape.coupled[at.i], columns = shape.coupled[at.j];
  const Target& target = job.program.targets(job.pack)[at.i * shape.couplings() + at.j];
  if (target.place >= 0 && job.active == all_lanes<L> && !at.watch) {
    double* to = job.numbers.values + target.place;
    // A copy: stores of vectors may be anything's for the compiler, which would load it again after each.
    const std::ptrdiff_t stride = target.stride;
    return each_product<D, L, Lower>(l, w, rows, columns, d, [=](int i, const PackOf<L>& lost) HWY_ATTR {
      store(load<L>(to + i * stride) - lost, to + i * stride);
    });
  }
  const bool later = job.pack.shares && target.place < 0;
  HWY_ALIGN double here[L * largest_dimension * largest_dimension];
  double* t = later ? job.numbers.scratch + (shape.size() + at.row * shape.coupled_rows + at.column * rows) * L : here;
  each_product<D, L, Lower>(l, w, rows, columns, d, [=](int i, const PackOf<L>& lost) HWY_ATTR { store(lost, t + i * L); });
  if (at.watch) remember<L>(job, at.i, t, rows);
  if (!later) subtract_lanes<L>(job, at, target, t);
}

template <int D, int L>
HWY_INLINE void store_diagonal(const PackOf<L>* from, double* to, int d_) {
  const int d = D ? D : d_;
#pragma GCC unroll 36
  for (int i = 0; i < d * d; ++i) store(from[i], to + i * L);
}

/// The block of a saddle node: gets its shift, and is looked at for rows that depend. Returns lanes that have some.
template <int D, int L>
HWY_INLINE unsigned factor_saddle(const PackJob& job, PackOf<L>* lu, int d) {
  using P = PackOf<L>;
  const bool may_depend = job.program.shape(job.pack).may_depend;
  const double shift = job.numbers.saddle_shift;
  if (!may_depend) {
    for (int i = 0; i < d; ++i) lu[i * (d + 1)] *= P(1 + shift);
    return factor<D>(lu, d);
  }
  P reference[D ? D : largest_dimension], largest(0.0);
  load_references(job, d, reference);
  for (int i = 0; i < d; ++i) {
    if (job.numbers.suspicious == 0) lu[i * (d + 1)] = multiply_add(P(shift), reference[i], lu[i * (d + 1)]);
    largest = max(largest, abs(reference[i]));
  }
  unsigned other = factor<D>(lu, d);
  if (job.numbers.suspicious == 0) return other;  // a shifted block is regular
  const P smallest = P(job.numbers.suspicious) * largest;
  for (int i = 0; i < d; ++i) other |= ~bits(P(1.0) > smallest * abs(lu[i * (d + 1)]));  // reciprocals
  return other;
}

/// D = L U in place and W = D^-1 U. Returns the lanes that have to be factored otherwise; if there are any, nothing was
/// written.
template <int D, int L>
HWY_INLINE unsigned factor_and_solve(const PackJob& job, double* diagonal, double* upper, int d) {
  const Shape& shape = job.program.shape(job.pack);
  if constexpr (D == 6) {
    // Two variables in one node that nothing couples yet: a good third of the work less, with the same bits.
    if (!shape.saddle && halves_apart<D, L>(diagonal)) {
      Halves<D, L> halves;
      load_halves(diagonal, halves);
      const unsigned other = (factor<D / 2>(halves.first, d / 2) | factor<D / 2>(halves.second, d / 2)) & job.active;
      if (other != 0) return other;
      store_halves(halves, diagonal);
      solve_all_halves(halves, upper, shape.coupled_rows);
      return 0;
    }
  }
  PackOf<L> lu[D ? D * D : largest_dimension * largest_dimension];
  load_diagonal<D>(diagonal, lu, d);
  const unsigned other = (shape.saddle ? factor_saddle<D>(job, lu, d) : factor<D>(lu, d)) & job.active;
  if (other != 0) return other;
  store_diagonal<D>(lu, diagonal, d);
  solve_all<D>(lu, upper, d, shape.coupled_rows);
  return 0;
}

template <int D, int L>
unsigned eliminate_pack(const PackJob& job) {
  const Shape& shape = job.program.shape(job.pack);
  const int d = D ? D : shape.dimension, m = shape.couplings();
  const Workplace<L> place(job, job.pack.place, job.numbers.scratch, shape.lower_size());
  const Workplace<L> right(job, job.pack.upper, job.numbers.scratch + shape.lower_size() * L, shape.upper_size());
  double* upper = right.blocks();
  if (const unsigned other = factor_and_solve<D, L>(job, place.blocks(), upper, d); other != 0) return other;
  const double* lower = place.blocks() + d * d * L;
  for (int i = 0, row = 0; i < m; row += shape.coupled[i++]) {
    const double* w = upper;
    for (int j = 0, column = 0; j < m; column += shape.coupled[j++]) {
      update_block<D, L, false>(job, {i, j, row, column, false, i == j && shape.coupled_may[i]}, lower, w, d);
      w += shape.coupled[j] * d * L;
    }
    lower += shape.coupled[i] * d * L;
  }
  if (job.pack.shares) subtract_all<L>(job, false);
  place.finish();
  right.finish();
  return 0;
}

/// What the pivots of a symmetric block are compared with. own: lower triangle of the block.
template <int D, int L>
HWY_INLINE void compared_with(const PackJob& job, Compared compared, const PackOf<L>* own, PackOf<L>* reference, int d_) {
  const int d = D ? D : d_;
  if (compared == Compared::with_own) {
    for (int i = 0; i < d; ++i) reference[i] = abs(own[i * (d + 1)]);
    return;
  }
  if (compared == Compared::with_nothing) {
    for (int i = 0; i < d; ++i) reference[i] = PackOf<L>(0.0);
    return;
  }
  load_references(job, d, reference);
  for (int i = 0; i < d; ++i) reference[i] = abs(reference[i]);
}

template <int D, int L>
unsigned eliminate_pack_symmetric(const PackJob& job, const Definite& definite, Watch watch) {
  const Shape& shape = job.program.shape(job.pack);
  const int d = D ? D : shape.dimension, m = shape.couplings();
  const Workplace<L> place(job, job.pack.place, job.numbers.scratch, shape.lower_size());
  PackOf<L> ldl[D ? D * D : largest_dimension * largest_dimension], reference[D ? D : largest_dimension];
  load_lower<D>(place.blocks(), ldl, d);
  compared_with<D>(job, definite.compared, ldl, reference, d);
  const unsigned other = factor_definite<D>(ldl, reference, definite, d) & job.active;
  if (other != 0) return other;
  store_lower<D>(ldl, place.blocks(), d);
  double* lower = place.blocks() + d * d * L;
  double* all_w = job.numbers.scratch + shape.lower_size() * L;  // beyond a copy of the blocks
  for (int i = 0, row = 0; i < m; row += shape.coupled[i++]) {
    const double* w = all_w;
    halve_panel<D>(ldl, lower, all_w + row * d * L, shape.coupled[i], d);
    for (int j = 0, column = 0; j < i; column += shape.coupled[j++]) {
      update_block<D, L, false>(job, {i, j, row, column, false, false}, lower, w, d);
      w += shape.coupled[j] * d * L;
    }
    update_block<D, L, true>(job, {i, i, row, row, true, watch == Watch::yes && shape.coupled_may[i]}, lower, w, d);
    lower += shape.coupled[i] * d * L;
  }
  if (job.pack.shares) subtract_all<L>(job, true);
  place.finish();
  return 0;
}

constexpr Eliminations here{.any = by_kind([]<int D, int L>() -> simd::Eliminate { return &eliminate_pack<D, L>; }),
                            .symmetric = by_kind([]<int D, int L>() -> simd::EliminateSymmetric {
                              return &eliminate_pack_symmetric<D, L>;
                            })};

}  // namespace

const Eliminations* EliminationsOfTarget() { return &here; }

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace graphsolve::simd {

HWY_EXPORT(EliminationsOfTarget);

const Eliminations& eliminations() {
  (void)instruction_set();  // chosen before the first kernel runs
  return *HWY_DYNAMIC_DISPATCH(EliminationsOfTarget)();
}

}  // namespace graphsolve::simd
#endif
