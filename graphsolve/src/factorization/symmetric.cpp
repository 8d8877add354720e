#include <algorithm>
#include <cmath>
#include <limits>

#include "factorization/block_inertia.hpp"
#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"
#include "symbolic/operations.hpp"
#include "factorization/rank_revealing.hpp"
#include "factorization/thresholds.hpp"

/// Pivots of the symmetric kinds. A definite block of the sign its node promises is factored without exchanges, and the panel
/// below it goes through half a solve (halved_). Any other block gets an LU with exchanges, as stable as Bunch-Kaufman, and its
/// signs from a congruence of its own (block_inertia.hpp); its panel is that of an LDU.
namespace graphsolve {

using namespace thresholds;

namespace {

/// Of R x C, without loops.
template <int R, int C>
void transpose(const double* from, double* to) {
#pragma GCC unroll 6
  for (int i = 0; i < R; ++i)
#pragma GCC unroll 6
    for (int q = 0; q < C; ++q) to[i * C + q] = from[q * R + i];
}

}  // namespace

/// The panel below a definite block: P L^-T D^-1, and L^-1 P^T beside it, whose product updates what follows.
void Factorization::Impl::halve_panel(int k, const PivotBlocks& blocks) const {
  const Symbolic& s = *symbolic_;
  const int d = s.dimension(k);
  const auto halve = kernels_->halve(d);
  if (equal_[k] > 0) return halve(blocks.diagonal, blocks.lower, blocks.upper, equal_[k], d, static_cast<int>(s.coupled(k).size()));
  double *lower = blocks.lower, *upper = blocks.upper;
  for (const int later : s.coupled(k)) {
    halve(blocks.diagonal, lower, upper, s.dimension(later), d, 1);
    lower += s.dimension(later) * d;
    upper += s.dimension(later) * d;
  }
}

/// Is the panel below this block of the kind that goes spread at once? What refactorize() applies again it needs whole.
bool Factorization::Impl::may_be_spread(int k) const {
  const int d = symbolic_->dimension(k);
  return is_halved(k) && share_.empty() && among_single_[k] && equal_[k] == d && d <= kernels::max_spread;
}

/// halve_panel from coupling `from` on. L^-1 P^T is not kept, but goes to rows [begin, begin + d) of the spread W; P L^-T D^-1 also
/// to l, from block to block `next` apart.
void Factorization::Impl::spread_panel(int k, const PivotBlocks& blocks, int from, double* l, std::ptrdiff_t next, int begin, int depth) {
  const int d = symbolic_->dimension(k), couplings = static_cast<int>(symbolic_->coupled(k).size());
  kernels_->halve_and_spreads[d - 1](blocks.diagonal, blocks.lower + from * d * d, l, next, spread_.data(), couplings - from, begin, depth);
  halved_[k] = Halved::and_spread;
}

/// U := P^T; the solve turns it into W.
void Factorization::Impl::transpose_panel(int k, const PivotBlocks& blocks) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension;
  const double* lower = blocks.lower;
  double* upper = blocks.upper;
  if (equal_[k] == d && d <= kernels::max_spread) return kernels_->transposes[d - 1](lower, upper, p.end - p.begin);
  for (const int coupled : s.coupled(k)) {
    const int di = s.pivot(coupled).dimension;
    if (d == 3 && di == 3) transpose<3, 3>(lower, upper);
    else if (d == 6 && di == 3) transpose<3, 6>(lower, upper);
    else if (d == 3 && di == 6) transpose<6, 3>(lower, upper);
    else if (d == 6 && di == 6) transpose<6, 6>(lower, upper);
    else
      for (int i = 0; i < di; ++i)
        for (int q = 0; q < d; ++q) upper[i * d + q] = lower[q * di + i];
    lower += d * di;
    upper += d * di;
  }
}

/// The kept matrix is whole, whatever the caller filled.
void Factorization::Impl::mirror_matrix(int k) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension;
  const std::int64_t stride = p.stride;
  double* diagonal = matrix_.data() + p.diagonal;
  for (int j = 0; j < d; ++j)
    for (int i = j + 1; i < d; ++i) diagonal[(i * d + j) * stride] = diagonal[(j * d + i) * stride];
  const double* lower = matrix_.data() + p.lower;
  double* upper = matrix_.data() + p.upper;
  for (const int later : s.coupled(k)) {
    const int rows = s.dimension(later);
    for (int i = 0; i < rows; ++i)
      for (int q = 0; q < d; ++q) upper[(i * d + q) * stride] = lower[(q * rows + i) * stride];
    lower += d * rows * stride;
    upper += d * rows * stride;
  }
}

/// What the pivots of a block must be to do without exchanges.
simd::Definite Factorization::Impl::definite(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const bool cholesky = kind_ == FactorizationKind::cholesky;
  const auto compared = references_.start_with(k)   ? simd::Compared::with_reference
                        : p.saddle && !cholesky    ? simd::Compared::with_nothing
                                                   : simd::Compared::with_own;
  if (cholesky) return {.sign = 1, .smallest = not_positive, .compared = compared};
  return {.sign = p.saddle ? -1.0 : 1.0,
          .smallest = p.may_depend && saddle_shift_ == 0 ? dependent : tiny,
          .compared = compared};
}

bool Factorization::Impl::factorize_pivot_symmetric(int k, const PivotBlocks& blocks, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension;
  double* diagonal = blocks.diagonal;
  const bool cholesky = kind_ == FactorizationKind::cholesky;
  const auto [sign, smallest, compared] = definite(k);
  const bool may_be_spoilt = kernels::Table::kind(d) == 0;
  if (may_be_spoilt) std::copy_n(diagonal, d * d, work_.data());
  outcome.operations += ldlt_operations(d);
  double buffer[simd::largest_dimension];
  const bool halved = kernels_->factor_definite(d)(diagonal, references_.side_by_side(k, buffer), sign, smallest, d);
  halved_[k] = halved ? Halved::yes : Halved::no;
  if (halved) {
    (sign < 0 ? outcome.inertia.negative : outcome.inertia.positive) += d;
    return true;
  }
  transpose_panel(k, blocks);
  if (may_be_spoilt) std::copy_n(work_.data(), d * d, diagonal);
  return !cholesky && factorize_pivot_indefinite(k, blocks, outcome);
}

bool Factorization::Impl::factorize_pivot_indefinite(int k, const PivotBlocks& blocks, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension, row = first_row_[k];
  double* diagonal = blocks.diagonal;
  double *block = work_.data(), *scratch = block + d * d, *size = block + 2 * d * d + 2 * d;
  for (int j = 0; j < d; ++j)
    for (int i = j + 1; i < d; ++i) diagonal[i * d + j] = diagonal[j * d + i];
  for (int i = 0; i < d; ++i) {
    size[i] = references_.own(k, i);
    for (int j = 0; j < d; ++j) {
      if (!std::isfinite(diagonal[j * d + i])) return false;
      size[i] = std::max(size[i], std::abs(diagonal[j * d + i]));
    }
    if (!(size[i] > 0)) size[i] = 1;  // nothing to compare with: nothing but zeros
  }
  std::copy_n(diagonal, d * d, block);
  const bool may_drop = p.may_depend && saddle_shift_ == 0;
  rank_[k] = factor_rank_revealing(diagonal, d, size, may_drop ? dependent : tiny, row_exchange_.data() + row,
                                   column_exchange_.data() + row, scratch);
  std::copy_n(block, d * d, scratch);
  const Inertia inertia = block_inertia(scratch, d, size, rank_[k]);
  outcome.inertia.positive += inertia.positive;
  outcome.inertia.negative += inertia.negative;
  outcome.inertia.zero += inertia.zero;
  outcome.operations += 3 * lu_operations(d);
  if (rank_[k] < d) {
    if (may_drop && !couples_later(k, blocks)) {
      drop_rows(k, outcome);
      return true;
    }
    outcome.boosts += d - rank_[k];
    if (!boost(k, blocks, block)) return false;
  }
  rank_[k] = d;
  std::copy_n(block, d * d, diagonal);
  return kernels_->factor(d)(diagonal, row_exchange_.data() + row, d) >= least_pivot;
}

/// Adds to the diagonal entries of `block`, the pivot as it was, that rank-revealing pivoting left over. A row without entries of its own takes the
/// size of its couplings; one without any couplings cannot be boosted.
bool Factorization::Impl::boost(int k, const PivotBlocks& blocks, double* block) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension;
  const double* upper = blocks.upper;
  for (int m = rank_[k]; m < d; ++m) {
    const int i = original_row(k, m);
    double own = references_.own(k, i);
    for (int j = 0; j < d; ++j) own = std::max(own, std::abs(block[j * d + i]));
    if (!(own > 0))
      for (int c = 0; c < p.coupled_rows; ++c) own = std::max(own, std::abs(upper[c * d + i]));
    if (!(own > 0)) return false;
    block[i * (d + 1)] += (p.saddle && symmetric() ? -boosted : boosted) * own;
  }
  return true;
}

}  // namespace graphsolve
