#include "graphsolve/factorization.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "kernels.hpp"
#include "rank_revealing.hpp"

namespace graphsolve {

namespace {

/// A pivot of an uncertain saddle block below this part of what was added to its diagonal is rounding error: the
/// row depends on others.
constexpr double dependent = 1e-11;

}  // namespace

Factorization::Factorization(std::shared_ptr<const Symbolic> symbolic) : symbolic_(std::move(symbolic)) {
  const Symbolic& s = *symbolic_;
  values_.assign(s.values_size(), 0.0);
  row_exchange_.assign(s.rows(), 0);
  column_exchange_.assign(s.rows(), 0);
  reference_.assign(s.rows(), 0.0);
  rank_.assign(s.pivots(), 0);
  first_row_.assign(s.pivots(), 0);
  dropped_.reserve(s.rows());
  int largest = 0;
  for (int k = 0, row = 0; k < s.pivots(); ++k) {
    first_row_[k] = row;
    row += s.dimension(k);
    largest = std::max(largest, s.dimension(k));
  }
  work_.assign(largest * largest + 2 * largest, 0.0);
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
  factorize_range(0, symbolic_->pivots(), outcome);
  return outcome;
}

Factorization::Outcome Factorization::factorize(int component) {
  Outcome outcome;
  std::erase_if(dropped_, [&](const DroppedRow& d) { return symbolic_->component(d.node) == component; });
  factorize_range(symbolic_->component_begin(component), symbolic_->component_begin(component + 1), outcome);
  return outcome;
}

void Factorization::factorize_range(int begin, int end, Outcome& outcome) {
  const Symbolic& s = *symbolic_;
  if (begin == end) return;
  if (keep_matrix_) {
    assert(!matrix_.empty());
    const auto first = s.pivot(begin).diagonal;
    const auto last = end < s.pivots() ? s.pivot(end).diagonal : s.values_size();
    std::copy(values_.begin() + first, values_.begin() + last, matrix_.begin() + first);
  }
  for (int k = begin; k < end; ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    if (!p.saddle) continue;
    for (int i = 0; i < p.dimension; ++i) reference_[first_row_[k] + i] = values_[p.diagonal + i * (p.dimension + 1)];
  }
  for (int k = begin; k < end; ++k) {
    if (!factorize_pivot(k, outcome)) return;
    eliminate(k);
  }
}

/// LU of the diagonal block. Row exchanges suffice unless rows of a saddle block depend on earlier ones.
bool Factorization::factorize_pivot(int k, Outcome& outcome) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int d = p.dimension, row = first_row_[k];
  double* diagonal = values_.data() + p.diagonal;
  double* reference = reference_.data() + row;
  rank_[k] = d;
  if (p.saddle)
    for (int i = 0; i < d; ++i) {
      diagonal[i * (d + 1)] += saddle_shift_ * reference[i];
      reference[i] = std::abs(reference[i]);
    }
  const bool look_for_dependence = p.may_depend && saddle_shift_ == 0;  // a shifted block is regular
  if (look_for_dependence) std::copy_n(diagonal, d * d, work_.data());
  const double smallest = kernels::factor_kernel(d)(diagonal, row_exchange_.data() + row, d);
  if (look_for_dependence && !std::isnan(smallest) && !(smallest > dependent * *std::max_element(reference, reference + d))) {
    std::copy_n(work_.data(), d * d, diagonal);
    rank_[k] = factor_rank_revealing(diagonal, d, reference, dependent, row_exchange_.data() + row,
                                     column_exchange_.data() + row, work_.data() + d * d);
    outcome.dropped_rows += d - rank_[k];
    for (int m = rank_[k]; m < d; ++m) {  // which original row ended at place m
      int original = m;
      for (int q = rank_[k] - 1; q >= 0; --q) {
        if (original == row_exchange_[row + q]) original = q;
        else if (original == q) original = row_exchange_[row + q];
      }
      dropped_.push_back({p.node, original});
    }
    if (!couples_later(k)) return true;
    outcome.first_bad_pivot = k;
    return false;
  }
  if (smallest > 0) return true;
  outcome.first_bad_pivot = k;
  return false;
}

/// W = D^-1 U, then the blocks between the couplings lose L W.
void Factorization::eliminate(int k) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  if (p.coupled_rows == 0) return;
  const int d = p.dimension, m = p.end - p.begin;
  double* v = values_.data();
  solve_diagonal(k, v + p.upper, p.coupled_rows);
  const std::int64_t* target = s.targets(p);
  const double* lower = v + p.lower;
  for (int i = 0; i < m; ++i) {
    const int ki = s.coupled_[p.begin + i];
    const Symbolic::Pivot& pi = s.pivot(ki);
    const int di = pi.dimension;
    const auto product = kernels::product_kernel(di, d);
    double before[kernels::max_fixed];
    const bool watch = pi.saddle && di <= kernels::max_fixed;
    if (watch)
      for (int q = 0; q < di; ++q) before[q] = v[pi.diagonal + q * (di + 1)];
    const double* upper = v + p.upper;
    for (int j = 0; j < m; ++j) {
      const int dj = s.pivot(s.coupled_[p.begin + j]).dimension;
      product(v + target[i * m + j], lower, upper, di, d, dj);
      upper += d * dj;
    }
    if (pi.saddle) {
      double* reference = reference_.data() + first_row_[ki];
      for (int q = 0; q < di; ++q) {
        const double now = v[pi.diagonal + q * (di + 1)];
        const double added = watch ? now - before[q] : now;
        if (std::abs(added) > std::abs(reference[q])) reference[q] = added;
      }
    }
    lower += di * d;
  }
}

void Factorization::solve_diagonal(int k, double* x, int columns) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int row = first_row_[k];
  if (rank_[k] == p.dimension && p.dimension <= kernels::max_fixed)
    kernels::solve_kernel(p.dimension)(values_.data() + p.diagonal, row_exchange_.data() + row, x, p.dimension, columns);
  else if (rank_[k] == p.dimension)
    kernels::solve_block<0>(values_.data() + p.diagonal, row_exchange_.data() + row, x, p.dimension, columns);
  else
    solve_rank_deficient(values_.data() + p.diagonal, p.dimension, rank_[k], row_exchange_.data() + row,
                         column_exchange_.data() + row, x, columns);
}

void Factorization::solve(std::span<double> x) const { solve_range(x, 0, symbolic_->pivots()); }

void Factorization::solve(std::span<double> x, int component) const {
  solve_range(x, symbolic_->component_begin(component), symbolic_->component_begin(component + 1));
}

void Factorization::solve_range(std::span<double> x, int begin, int end) const {
  assert(static_cast<int>(x.size()) == symbolic_->rows());
  const Symbolic& s = *symbolic_;
  const double* v = values_.data();
  for (int k = begin; k < end; ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    double* xk = x.data() + p.row;
    solve_diagonal(k, xk, 1);
    const double* lower = v + p.lower;
    for (int e = p.begin; e < p.end; ++e) {
      const Symbolic::Pivot& pi = s.pivot(s.coupled_[e]);
      kernels::product_kernel(pi.dimension, p.dimension)(x.data() + pi.row, lower, xk, pi.dimension, p.dimension, 1);
      lower += pi.dimension * p.dimension;
    }
  }
  for (int k = end - 1; k >= begin; --k) {
    const Symbolic::Pivot& p = s.pivot(k);
    const double* upper = v + p.upper;
    for (int e = p.begin; e < p.end; ++e) {
      const Symbolic::Pivot& pj = s.pivot(s.coupled_[e]);
      kernels::product_kernel(p.dimension, pj.dimension)(x.data() + p.row, upper, x.data() + pj.row, p.dimension,
                                                         pj.dimension, 1);
      upper += p.dimension * pj.dimension;
    }
  }
}

void Factorization::solve_transposed(std::span<double> x) const {
  const Symbolic& s = *symbolic_;
  const double* v = values_.data();
  for (int k = 0; k < s.pivots(); ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    const double* upper = v + p.upper;
    for (int e = p.begin; e < p.end; ++e) {
      const Symbolic::Pivot& pj = s.pivot(s.coupled_[e]);
      kernels::subtract_transposed_times_vector(x.data() + pj.row, upper, x.data() + p.row, p.dimension, pj.dimension);
      upper += p.dimension * pj.dimension;
    }
  }
  for (int k = s.pivots() - 1; k >= 0; --k) {
    const Symbolic::Pivot& p = s.pivot(k);
    double* xk = x.data() + p.row;
    const double* lower = v + p.lower;
    for (int e = p.begin; e < p.end; ++e) {
      const Symbolic::Pivot& pi = s.pivot(s.coupled_[e]);
      kernels::subtract_transposed_times_vector(xk, lower, x.data() + pi.row, pi.dimension, p.dimension);
      lower += pi.dimension * p.dimension;
    }
    const int row = first_row_[k];
    if (rank_[k] == p.dimension)
      kernels::solve_block_transposed(v + p.diagonal, row_exchange_.data() + row, xk, p.dimension);
    else
      solve_rank_deficient_transposed(v + p.diagonal, p.dimension, rank_[k], row_exchange_.data() + row,
                                      column_exchange_.data() + row, xk);
  }
}

}  // namespace graphsolve
