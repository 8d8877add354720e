#include "graphsolve/factorization.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "kernels.hpp"
#include "operations.hpp"
#include "rank_revealing.hpp"
#include "simd/packed_factor.hpp"

namespace graphsolve {

namespace {

/// A pivot of an uncertain saddle block below this part of what was added to its diagonal is rounding error: the
/// row depends on others.
constexpr double dependent = 1e-11;

}  // namespace

Factorization::Factorization(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind)
    : symbolic_(std::move(symbolic)), kind_(kind) {
  const Symbolic& s = *symbolic_;
  values_.assign(s.values_size(), 0.0);
  row_exchange_.assign(s.rows(), 0);
  column_exchange_.assign(s.rows(), 0);
  reference_.assign(s.rows(), 0.0);
  panel_reference_.assign(s.rows(), 0.0);
  rank_.assign(s.pivots(), 0);
  first_row_.assign(s.pivots(), 0);
  dropped_.reserve(s.rows());
  int largest = 0;
  for (int k = 0, row = 0; k < s.pivots(); ++k) {
    first_row_[k] = row;
    row += s.dimension(k);
    largest = std::max(largest, s.dimension(k));
  }
  work_.assign(2 * largest * largest + 3 * largest, 0.0);
  outcomes_.resize(s.components());
  active_.assign(s.components(), 0);
  if (!symmetric() && s.program().packs() > 0) packed_ = std::make_unique<simd::PackedFactor>(s);
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
  magnitude_.assign(symbolic_->rows(), 0.0);
  correction_.assign(symbolic_->rows(), 0.0);
}

Factorization::Outcome Factorization::factorize() {
  Outcome outcome;
  dropped_.clear();
  if (!in_packs()) {
    factorize_range(0, symbolic_->pivots(), outcome);
    total_ = outcome;
    complete_ = keep_matrix_ && outcome.ok();
    return outcome;
  }
  complete_ = false;
  prepare_range(0, symbolic_->pivots());
  std::fill(active_.begin(), active_.end(), char{1});
  std::fill(outcomes_.begin(), outcomes_.end(), Outcome{});
  factorize_steps(outcomes_);
  for (const Outcome& part : outcomes_) {
    outcome.dropped_rows += part.dropped_rows;
    outcome.boosts += part.boosts;
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

/// Is what neighbours add to the diagonal of this block remembered? Only where something is decided by it.
bool Factorization::tracks_reference(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  return p.saddle && kind_ != FactorizationKind::cholesky && (p.may_depend || (saddle_shift_ != 0 && symmetric()));
}

void Factorization::start_reference(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  double* reference = reference_.data() + first_row_[k];
  const double* diagonal = values_.data() + p.diagonal;
  const int d = p.dimension;
  if (tracks_reference(k)) {
    for (int i = 0; i < d; ++i) reference[i] = diagonal[i * (d + 1)];
    start_panel_reference(k);
  } else if (symmetric() && (!p.saddle || kind_ == FactorizationKind::cholesky))
    for (int i = 0; i < d; ++i) reference[i] = std::abs(diagonal[i * (d + 1)]);
  else
    std::fill_n(reference, d, 0.0);
}

/// Largest entry of each row right of the diagonal block.
void Factorization::start_panel_reference(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  double* reference = panel_reference_.data() + first_row_[k];
  if (symmetric()) transpose_panel(k, values_.data());  // the upper panel need not have been filled
  const double* column = values_.data() + p.upper;
  std::fill_n(reference, p.dimension, 0.0);
  for (int c = 0; c < p.coupled_rows; ++c, column += p.dimension)
    for (int i = 0; i < p.dimension; ++i) reference[i] = std::max(reference[i], std::abs(column[i]));
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
  for (; begin != end; ++begin) largest = std::max(largest, std::abs(*begin));
  return largest;
}

void Factorization::prepare_range(int begin, int end) {
  if (begin == end) return;
  if (keep_matrix_) keep(begin, end);
  for (int k = begin; k < end; ++k) start_reference(k);
}

void Factorization::factorize_range(int begin, int end, Outcome& outcome) {
  prepare_range(begin, end);
  for (int k = begin; k < end && outcome.ok(); ++k) eliminate_alone(k, outcome);
}

void Factorization::eliminate_alone(int k, Outcome& outcome) {
  if (packed_) packed_->set_alone(k);
  if (keep_matrix_ && largest_entry_ > 0) outcome.growth = std::max(outcome.growth, largest_of(k) / largest_entry_);
  if (factorize_pivot(k, outcome)) eliminate(k, outcome);
}

void Factorization::shift_pivot(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  double* diagonal = values_.data() + p.diagonal;
  const double* reference = reference_.data() + first_row_[k];
  const bool tracked = tracks_reference(k);
  for (int i = 0; i < p.dimension; ++i) {
    double& entry = diagonal[i * (p.dimension + 1)];
    // Where nothing may depend, all that was added has one sign, and the diagonal is its sum.
    entry += saddle_shift_ * (tracked ? reference[i] : entry);
  }
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
  const Outcome before = outcome;
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.saddle && saddle_shift_ != 0 && kind_ != FactorizationKind::cholesky) shift_pivot(k);
  if (tracks_reference(k))
    for (int i = 0; i < p.dimension; ++i) reference_[first_row_[k] + i] = std::abs(reference_[first_row_[k] + i]);
  rank_[k] = p.dimension;
  const bool regular = symmetric() ? factorize_pivot_symmetric(k, outcome) : factorize_pivot_any(k, outcome);
  if (!regular) outcome.first_bad_pivot = k;
  ++outcome.pivots;
  if (!share_.empty())
    share_[k] = {.inertia = {.positive = outcome.inertia.positive - before.inertia.positive,
                             .negative = outcome.inertia.negative - before.inertia.negative,
                             .zero = outcome.inertia.zero - before.inertia.zero},
                 .dropped_rows = outcome.dropped_rows - before.dropped_rows,
                 .boosts = outcome.boosts - before.boosts};
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
  const double smallest = kernels::factor_kernel(d)(diagonal, row_exchange_.data() + row, d);
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
    return kernels::factor_kernel(d)(diagonal, row_exchange_.data() + row, d) > 0;
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

/// The blocks between couplings `from`, from + 1, ... of pivot k lose L W; of symmetric ones the lower triangle.
void Factorization::update(int k, int from, Outcome& outcome) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension, m = p.end - p.begin;
  const int* coupled = s.coupled_.data() + p.begin;
  double* v = values_.data();
  const std::int64_t* target = s.targets(p);
  const double* lower = v + p.lower + s.block_offset_[p.begin + from];
  const double* first_upper = v + p.upper + s.block_offset_[p.begin + from];
  std::int64_t scalars = 0;
  for (int i = from; i < m; ++i) {
    const int di = s.pivot(coupled[i]).dimension;
    const auto product = kernels::product_kernel(di, d);
    const bool watch = tracks_reference(coupled[i]);
    double* own = v + target[i * p.stride + i];
    if (watch)
      for (int q = 0; q < di; ++q) work_[q] = own[q * (di + 1)];
    const double* upper = first_upper;
    for (int j = from, last = symmetric() ? i : m; j < last; ++j) {
      const int dj = s.pivot(coupled[j]).dimension;
      product(v + target[i * p.stride + j], lower, upper, di, d, dj);
      upper += d * dj;
      scalars += static_cast<std::int64_t>(di) * dj;
    }
    if (symmetric()) {
      kernels::lower_kernel(di, d)(own, lower, upper, di, d);
      scalars += static_cast<std::int64_t>(di) * (di + 1) / 2;
    }
    if (watch) {
      double* reference = reference_.data() + first_row_[coupled[i]];
      for (int q = 0; q < di; ++q) {
        const double added = own[q * (di + 1)] - work_[q];
        if (std::abs(added) > std::abs(reference[q])) reference[q] = added;
      }
    }
    lower += di * d;
  }
  outcome.operations += d * scalars;
}

}  // namespace graphsolve
