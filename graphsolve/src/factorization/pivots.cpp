#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "symbolic/equal_couplings.hpp"
#include "factorization/given.hpp"
#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"
#include "symbolic/operations.hpp"
#include "factorization/rank_revealing.hpp"
#include "factorization/thresholds.hpp"

namespace graphsolve {

using thresholds::dependent;

Factorization::Outcome Factorization::Impl::factorize() {
  start_all();
  factorize_active(Count::together);
  return finish_all();
}

void Factorization::Impl::start_all() {
  check_room();
  dropped_.clear();
  taking_part_.set(taking_part_.everybody());
  for (const int c : taking_part_.everybody()) standing_.begin(c, keep_matrix_);
  std::fill(outcomes_.begin(), outcomes_.end(), Outcome{});
}

Factorization::Outcome Factorization::Impl::finish_all() {
  finish(taking_part_.everybody());
  Outcome outcome;
  for (const Outcome& part : outcomes_) {
    outcome.dropped_rows += part.dropped_rows;
    outcome.boosts += part.boosts;
    outcome.inertia.positive += part.inertia.positive;
    outcome.inertia.negative += part.inertia.negative;
    outcome.inertia.zero += part.inertia.zero;
    outcome.operations += part.operations;
    outcome.pivots += part.pivots;
    outcome.growth = std::max(outcome.growth, part.growth);
    if (outcome.ok()) outcome.first_bad_pivot = part.first_bad_pivot;
  }
  total_ = outcome;
  complete_ = keep_matrix_ && outcome.ok();
  return outcome;
}

std::span<const Factorization::Outcome> Factorization::Impl::factorize(std::span<const int> components) {
  start(components);
  factorize_active(Count::each);
  finish(components);
  return outcomes_;
}

void Factorization::Impl::finish(std::span<const int> components) {
  for (const int c : components) standing_.end(c, outcomes_[c].ok());
}

void Factorization::Impl::start(std::span<const int> components) {
  check_room();
  taking_part_.check(components);
  const Symbolic& s = *symbolic_;
  taking_part_.set(components);
  if (!dropped_.empty())
    std::erase_if(dropped_, [&](const DroppedRow& d) { return std::ranges::find(components, s.component(d.node)) != components.end(); });
  for (const int c : components) {
    outcomes_[c] = {};
    standing_.begin(c, keep_matrix_);
  }
  complete_ = false;
}

void Factorization::Impl::check_room() const {
  if (keep_matrix_ && matrix_.capacity() < values_.size())
    throw std::logic_error("factorize: keep_matrix(true) needs the room of allow_refinement() or allow_refactorization()");
}

/// Copies the matrix before it is overwritten.
void Factorization::Impl::keep() {
  matrix_.resize(values_.size());
  double largest = 0;
  const auto copy = [&](std::int64_t at) {
    matrix_[at] = values_[at];
    largest = std::max(largest, std::abs(values_[at]));
  };
  taking_part_.each_extent(
      symmetric(),
      [&](std::size_t, std::int64_t begin, std::int64_t end) {
        for (auto i = begin; i < end; ++i) copy(i);
      },
      [&](int k) { each_given(symbolic_->pivot(k), symmetric(), copy); });
  largest_entry_ = largest;
  if (symmetric()) taking_part_.each_pivot([&](int k) { mirror_matrix(k); });
}

/// Largest entry of the blocks of a pivot, which no other pivot changes any more.
double Factorization::Impl::largest_of(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension;
  double largest = 0;
  const auto take = [&](const double* block, std::int64_t begin, std::int64_t end) {
    for (auto i = begin; i < end; ++i) largest = std::max(largest, std::abs(block[i * p.stride]));
  };
  // The upper triangle of a symmetric matrix is not kept up.
  for (int j = 0; j < d; ++j) take(values_.data() + p.diagonal, j * d + (symmetric() ? j : 0), (j + 1) * d);
  take(values_.data() + p.lower, 0, p.upper_scalars());
  if (!symmetric()) take(values_.data() + p.upper, 0, p.upper_scalars());
  return largest;
}

/// The blocks of a pivot, one scalar after the other: in place, or a copy.
auto Factorization::Impl::open(int k) -> PivotBlocks {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.stride == 1) return {values_.data() + p.diagonal, values_.data() + p.lower, values_.data() + p.upper};
  double* to = opened_.data();
  gather(k, to);
  return {to, to + p.dimension * p.dimension, to + p.lower_scalars()};
}

/// Diagonal block, blocks below, blocks to the right.
void Factorization::Impl::gather(int k, double* to) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const double *lower = values_.data() + p.diagonal, *upper = values_.data() + p.upper;
  for (std::int64_t i = 0; i < p.lower_scalars(); ++i) *to++ = lower[i * p.stride];
  for (std::int64_t i = 0; i < p.upper_scalars(); ++i) *to++ = upper[i * p.stride];
}

void Factorization::Impl::close(int k, const PivotBlocks& blocks) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.stride == 1) return;
  double *lower = values_.data() + p.diagonal, *upper = values_.data() + p.upper;
  for (std::int64_t i = 0; i < p.lower_scalars(); ++i) lower[i * p.stride] = blocks.diagonal[i];
  for (std::int64_t i = 0; i < p.upper_scalars(); ++i) upper[i * p.stride] = blocks.upper[i];
}

/// Pivot k, or the group that it begins; nothing inside one.
void Factorization::Impl::eliminate_from(int k, Outcome& outcome) {
  if (group_[k] > 1) eliminate_group(k, group_[k], outcome);
  else if (group_[k] == 1) eliminate_alone(k, outcome);
}

void Factorization::Impl::eliminate_alone(int k, Outcome& outcome) {
  begin_alone(k, outcome);
  const PivotBlocks blocks = open(k);
  if (factorize_pivot(k, blocks, outcome)) eliminate(k, blocks, outcome);
  close(k, blocks);
}

void Factorization::Impl::begin_alone(int k, Outcome& outcome) {
  if (const int place = symbolic_->program().place(k); place >= 0)
    packed_[place / simd::lanes] &= static_cast<std::uint8_t>(~(1u << place % simd::lanes));
  if (keep_matrix_ && largest_entry_ > 0) outcome.growth = std::max(outcome.growth, largest_of(k) / largest_entry_);
}

/// Which row of the block ended at a place beyond its rank.
int Factorization::Impl::original_row(int k, int place) const {
  const int* exchange = row_exchange_.data() + first_row_[k];
  for (int q = rank_[k] - 1; q >= 0; --q) {
    if (place == exchange[q]) place = q;
    else if (place == q) place = exchange[q];
  }
  return place;
}

void Factorization::Impl::drop_rows(int k, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  outcome.dropped_rows += p.dimension - rank_[k];
  for (int m = rank_[k]; m < p.dimension; ++m) dropped_.push_back({p.node, original_row(k, m)});
}

double Factorization::Impl::suspicious_pivot() const {
  return saddle_shift_ == 0 ? dependent : symmetric() ? 0.0 : std::sqrt(leave_out_);
}

void Factorization::Impl::shift_pivot(int k, double* diagonal) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const bool tracked = references_.track(k);
  for (int i = 0; i < p.dimension; ++i) {
    double& entry = diagonal[i * (p.dimension + 1)];
    // Where nothing may depend, all that was added has one sign, and the diagonal is its sum.
    entry += saddle_shift_ * (tracked ? references_.own(k, i) : entry);
  }
}

bool Factorization::Impl::factorize_pivot(int k, const PivotBlocks& blocks, Outcome& outcome) {
  if (share_.empty()) return factorize_one(k, blocks, outcome);
  const Outcome before = outcome;
  const bool regular = factorize_one(k, blocks, outcome);
  share_[k] = {.inertia = {.positive = outcome.inertia.positive - before.inertia.positive,
                           .negative = outcome.inertia.negative - before.inertia.negative,
                           .zero = outcome.inertia.zero - before.inertia.zero},
               .dropped_rows = outcome.dropped_rows - before.dropped_rows,
               .boosts = outcome.boosts - before.boosts};
  return regular;
}

bool Factorization::Impl::factorize_one(int k, const PivotBlocks& blocks, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.saddle && saddle_shift_ != 0 && kind_ != FactorizationKind::cholesky && !leaves_out(k)) shift_pivot(k, blocks.diagonal);
  if (symmetric() && !references_.start_with(k)) references_.start(k, values_.data());
  if (references_.track(k)) {
    double sum = 0;
    for (int i = 0; i < p.dimension; ++i) {
      sum += references_.own(k, i);
      references_.own(k, i) = std::abs(references_.own(k, i));
    }
    sign_ = sum < 0 ? -1 : 1;
  }
  rank_[k] = p.dimension;
  const bool regular = symmetric() ? factorize_pivot_symmetric(k, blocks, outcome) : factorize_pivot_any(k, blocks, outcome);
  if (!regular) outcome.first_bad_pivot = k;
  ++outcome.pivots;
  return regular;
}

namespace {

bool all_finite(const double* values, int count) {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

}  // namespace

/// LU of the diagonal block. Row exchanges suffice unless rows of a saddle block depend on earlier ones.
bool Factorization::Impl::factorize_pivot_any(int k, const PivotBlocks& blocks, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension;
  double* diagonal = blocks.diagonal;
  const bool looks = p.may_depend && (saddle_shift_ == 0 || leaves_out(k));  // a shifted block is regular
  if (looks) std::copy_n(diagonal, d * d, work_.data());
  const double smallest = kernels_->factor(d)(diagonal, row_exchange_.data() + first_row_[k], d);
  outcome.operations += lu_operations(d);
  if (looks && !std::isnan(smallest)) {
    double buffer[simd::largest_dimension];
    const double* reference = references_.side_by_side(k, buffer);
    if (!(smallest > suspicious_pivot() * *std::max_element(reference, reference + d)))
      return factorize_suspicious(k, blocks, reference, outcome);
  }
  return smallest >= thresholds::least_pivot;
}

/// The block stands in work_. Rows that depend are left out; where they only seem to, the block is boosted or shifted.
bool Factorization::Impl::factorize_suspicious(int k, const PivotBlocks& blocks, const double* reference, Outcome& outcome) {
  const int d = symbolic_->dimension(k), row = first_row_[k];
  double* diagonal = blocks.diagonal;
  const auto factor_again = [&] { return kernels_->factor(d)(diagonal, row_exchange_.data() + row, d) >= thresholds::least_pivot; };
  std::copy_n(work_.data(), d * d, diagonal);
  if (!all_finite(diagonal, d * d)) return false;  // a column of zeros ends the search before it meets them
  rank_[k] = factor_rank_revealing(diagonal, d, reference, leaves_out(k) ? leave_out_ : dependent, row_exchange_.data() + row,
                                   column_exchange_.data() + row, work_.data() + d * d);
  outcome.operations += lu_operations(d);
  if (leaves_out(k) ? rank_[k] < d && !couples_later(k, blocks) : !couples_later(k, blocks)) {
    drop_rows(k, outcome);
    return true;
  }
  const bool regular = rank_[k] == d;
  if (leaves_out(k)) {
    std::copy_n(work_.data(), d * d, diagonal);
    for (int i = 0; i < d && !regular; ++i) diagonal[i * (d + 1)] += sign_ * saddle_shift_ * reference[i];
  } else {
    if (!keep_matrix_) return false;  // boosting calls for refinement
    outcome.boosts += d - rank_[k];
    if (!boost(k, blocks, work_.data())) return false;
    std::copy_n(work_.data(), d * d, diagonal);
  }
  rank_[k] = d;
  return factor_again();
}

/// The blocks between the couplings lose L D^-1 U.
void Factorization::Impl::eliminate(int k, const PivotBlocks& blocks, Outcome& outcome) {
  const int couplings = static_cast<int>(symbolic_->coupled(k).size()), d = symbolic_->dimension(k);
  if (couplings == 0) return;
  if (may_be_spread(k) && in_rows(couplings, d)) spread_panel(k, blocks, 0, blocks.lower, d * d, 0, d);
  else finish_panel(k, blocks);
  outcome.operations += panel_operations(k);
  update(k, blocks, 0, outcome);
}

/// What is above and below a factored block becomes what updates the blocks that follow by its product.
void Factorization::Impl::finish_panel(int k, const PivotBlocks& blocks) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (is_halved(k)) halve_panel(k, blocks);
  else solve_diagonal(k, blocks.diagonal, blocks.upper, p.coupled_rows, p.dimension);
}

std::int64_t Factorization::Impl::panel_operations(int k) const {
  const std::int64_t d = symbolic_->dimension(k);
  return (is_halved(k) ? d * (d + 1) / 2 : d * d) * symbolic_->pivot(k).coupled_rows;
}

}  // namespace graphsolve
