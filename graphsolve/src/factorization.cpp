#include "graphsolve/factorization.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <ranges>

#include "equal_couplings.hpp"
#include "kernels.hpp"
#include "operations.hpp"
#include "rank_revealing.hpp"
#include "simd/packed_factor.hpp"

namespace graphsolve {

using simd::dependent;

Factorization::Factorization(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind)
    : symbolic_(std::move(symbolic)), kind_(kind), kernels_(&kernels::table()) {
  const Symbolic& s = *symbolic_;
  values_.assign(s.values_size(), 0.0);
  row_exchange_.assign(s.rows(), 0);
  column_exchange_.assign(s.rows(), 0);
  reference_.assign(s.rows(), 0.0);
  panel_reference_.assign(s.rows(), 0.0);
  rank_.assign(s.pivots(), 0);
  uncertain_.reserve(std::ranges::count_if(std::views::iota(0, s.pivots()), [&](int k) { return s.may_depend(k); }));
  first_row_.assign(s.pivots(), 0);
  dropped_.reserve(s.rows());
  equal_.assign(s.pivots(), 0);
  group_.assign(s.pivots(), 1);
  int largest = 0, spread = 0, next_group = 0;
  for (int k = 0, row = 0; k < s.pivots(); ++k) {
    first_row_[k] = row;
    if (s.may_depend(k)) uncertain_.push_back(k);
    equal_[k] = static_cast<char>(equal_couplings(s, k));
    spread = std::max(spread, spread_size(s, k));
    if (k == next_group) {
      if (equal_[k] > 0) group_[k] = static_cast<char>(group_size(s, k, equal_[k]));
      next_group = k + group_[k];
    }
    row += s.dimension(k);
    largest = std::max(largest, s.dimension(k));
  }
  work_.assign(2 * largest * largest + 3 * largest, 0.0);
  spread_.assign(spread, 0.0);
  outcomes_.resize(s.components());
  active_.assign(s.components(), 0);
  using Form = simd::PackedFactor::Form;
  if (s.program().packs() > 0)
    packed_ = std::make_unique<simd::PackedFactor>(s, symmetric() ? Form::symmetric : Form::general);
}

Factorization::~Factorization() = default;
Factorization::Factorization(Factorization&&) noexcept = default;
Factorization& Factorization::operator=(Factorization&&) noexcept = default;

Factorization Factorization::twin() const {
  Factorization other(symbolic_, kind_);
  other.saddle_shift_ = saddle_shift_;
  other.packs_ = packs_;
  return other;
}

void Factorization::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

void Factorization::set_zero(int component) {
  const Symbolic& s = *symbolic_;
  const int begin = s.component_begin(component), end = s.component_begin(component + 1);
  const auto first = s.pivot(begin).diagonal;
  const auto last = end < s.pivots() ? s.pivot(end).diagonal : s.values_size();
  std::fill(values_.begin() + first, values_.begin() + last, 0.0);
}

void Factorization::allow_refinement() {
  matrix_.assign(values_.size(), 0.0);
  residual_.assign(symbolic_->rows(), 0.0);
  residual_low_.assign(symbolic_->rows(), 0.0);
  magnitude_.assign(symbolic_->rows(), 0.0);
  correction_.assign(symbolic_->rows(), 0.0);
  best_.assign(symbolic_->rows(), 0.0);
}

Factorization::Outcome Factorization::factorize() {
  Outcome outcome;
  dropped_.clear();
  if (!in_packs()) {
    factorize_range(0, symbolic_->pivots(), outcome);
    any_packed_ &= !outcome.ok();  // after a failure some pivots are as they were
    total_ = outcome;
    complete_ = keep_matrix_ && outcome.ok();
    return outcome;
  }
  complete_ = false;
  prepare_range(0, symbolic_->pivots());
  set_all_active();
  std::fill(outcomes_.begin(), outcomes_.end(), Outcome{});
  factorize_steps(outcomes_, Count::together);
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
  return outcome;
}

Factorization::Outcome Factorization::factorize(int component) {
  Outcome outcome;
  complete_ = false;
  std::erase_if(dropped_, [&](const DroppedRow& d) { return symbolic_->component(d.node) == component; });
  factorize_range(symbolic_->component_begin(component), symbolic_->component_begin(component + 1), outcome);
  return outcome;
}

/// Copies the matrix before it is overwritten.
void Factorization::keep(int begin, int end) {
  assert(!matrix_.empty());
  const Symbolic& s = *symbolic_;
  const auto first = s.pivot(begin).diagonal;
  const auto last = end < s.pivots() ? s.pivot(end).diagonal : s.values_size();
  largest_entry_ = 0;
  for (auto i = first; i < last; ++i) {
    matrix_[i] = values_[i];
    largest_entry_ = std::max(largest_entry_, std::abs(values_[i]));
  }
  if (symmetric())
    for (int k = begin; k < end; ++k) mirror_matrix(k);
}

/// Largest entry of the blocks of a pivot, which no other pivot changes any more.
double Factorization::largest_of(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const double* begin = values_.data() + p.diagonal;
  const double* end = values_.data() + p.upper + static_cast<std::int64_t>(p.dimension) * p.coupled_rows;
  double largest = 0;
  if (symmetric()) {  // the other triangle is not kept up
    end = values_.data() + p.upper;
    for (int j = 0; j < p.dimension; ++j, begin += p.dimension)
      for (int i = j; i < p.dimension; ++i) largest = std::max(largest, std::abs(begin[i]));
  }
  for (; begin != end; ++begin) largest = std::max(largest, std::abs(*begin));
  return largest;
}

void Factorization::factorize_range(int begin, int end, Outcome& outcome) {
  prepare_range(begin, end);
  for (int k = begin; k < end && outcome.ok(); k += group_[k])
    group_[k] > 1 ? eliminate_group(k, group_[k], outcome) : eliminate_alone(k, outcome);
}

void Factorization::eliminate_alone(int k, Outcome& outcome) {
  begin_alone(k, outcome);
  if (factorize_pivot(k, outcome)) eliminate(k, outcome);
}

void Factorization::begin_alone(int k, Outcome& outcome) {
  if (any_packed_) packed_->set_alone(k);
  if (keep_matrix_ && largest_entry_ > 0) outcome.growth = std::max(outcome.growth, largest_of(k) / largest_entry_);
}

/// Which row of the block ended at a place beyond its rank.
int Factorization::original_row(int k, int place) const {
  const int* exchange = row_exchange_.data() + first_row_[k];
  for (int q = rank_[k] - 1; q >= 0; --q) {
    if (place == exchange[q]) place = q;
    else if (place == q) place = exchange[q];
  }
  return place;
}

void Factorization::drop_rows(int k, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  outcome.dropped_rows += p.dimension - rank_[k];
  for (int m = rank_[k]; m < p.dimension; ++m) dropped_.push_back({p.node, original_row(k, m)});
}

bool Factorization::factorize_pivot(int k, Outcome& outcome) {
  if (share_.empty()) return factorize_one(k, outcome);
  const Outcome before = outcome;
  const bool regular = factorize_one(k, outcome);
  share_[k] = {.inertia = {.positive = outcome.inertia.positive - before.inertia.positive,
                           .negative = outcome.inertia.negative - before.inertia.negative,
                           .zero = outcome.inertia.zero - before.inertia.zero},
               .dropped_rows = outcome.dropped_rows - before.dropped_rows,
               .boosts = outcome.boosts - before.boosts};
  return regular;
}

bool Factorization::factorize_one(int k, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.saddle && saddle_shift_ != 0 && kind_ != FactorizationKind::cholesky) shift_pivot(k);
  if (tracks_reference(k))
    for (int i = 0; i < p.dimension; ++i) reference_[first_row_[k] + i] = std::abs(reference_[first_row_[k] + i]);
  rank_[k] = p.dimension;
  const bool regular = symmetric() ? factorize_pivot_symmetric(k, outcome) : factorize_pivot_any(k, outcome);
  if (!regular) outcome.first_bad_pivot = k;
  ++outcome.pivots;
  return regular;
}

/// LU of the diagonal block. Row exchanges suffice unless rows of a saddle block depend on earlier ones.
bool Factorization::factorize_pivot_any(int k, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension, row = first_row_[k];
  double* diagonal = values_.data() + p.diagonal;
  const double* reference = reference_.data() + row;
  const bool look_for_dependence = p.may_depend && saddle_shift_ == 0;  // a shifted block is regular
  if (look_for_dependence) std::copy_n(diagonal, d * d, work_.data());
  const double smallest = kernels_->factor(d)(diagonal, row_exchange_.data() + row, d);
  outcome.operations += lu_operations(d);
  if (look_for_dependence && !std::isnan(smallest) && !(smallest > dependent * *std::max_element(reference, reference + d))) {
    std::copy_n(work_.data(), d * d, diagonal);
    rank_[k] = factor_rank_revealing(diagonal, d, reference, dependent, row_exchange_.data() + row,
                                     column_exchange_.data() + row, work_.data() + d * d);
    outcome.operations += lu_operations(d);
    if (!couples_later(k)) {
      drop_rows(k, outcome);
      return true;
    }
    if (!keep_matrix_) return false;  // boosting calls for refinement
    outcome.boosts += d - rank_[k];
    if (!boost(k, work_.data())) return false;
    rank_[k] = d;
    std::copy_n(work_.data(), d * d, diagonal);
    return kernels_->factor(d)(diagonal, row_exchange_.data() + row, d) > 0;
  }
  return smallest > 0;
}

/// W = D^-1 U, then the blocks between the couplings lose L W.
void Factorization::eliminate(int k, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.coupled_rows == 0) return;
  const std::int64_t d = p.dimension;
  solve_diagonal(k, values_.data() + p.upper, p.coupled_rows, p.dimension);
  outcome.operations += d * d * p.coupled_rows;
  update(k, 0, outcome);
}

}  // namespace graphsolve
