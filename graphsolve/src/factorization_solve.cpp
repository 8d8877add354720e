#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <string>

#include "graphsolve/factorization.hpp"
#include "kernels.hpp"
#include "rank_revealing.hpp"
#include "simd/packed_factor.hpp"

/// Solving with the factors, which have the same form for all kinds.
namespace graphsolve {

namespace {

constexpr int columns_at_once = 8;  ///< more would push the blocks out of the cache between their uses

}  // namespace

void Factorization::check_size(std::span<const double> x, int columns) const {
  if (columns >= 0 && x.size() == static_cast<std::size_t>(symbolic_->rows()) * static_cast<std::size_t>(columns)) return;
  throw std::invalid_argument("right-hand side has " + std::to_string(x.size()) + " numbers, expected " +
                              std::to_string(symbolic_->rows()) + " rows x " + std::to_string(columns) + " columns");
}

void Factorization::solve_diagonal(int k, double* x, int columns, std::ptrdiff_t stride) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int row = first_row_[k];
  const double* diagonal = values_.data() + p.diagonal;
  if (rank_[k] == p.dimension) {
    kernels_->solve(p.dimension)(diagonal, row_exchange_.data() + row, x, p.dimension, columns, stride);
    return;
  }
  for (int c = 0; c < columns; ++c, x += stride)
    solve_rank_deficient(diagonal, p.dimension, rank_[k], row_exchange_.data() + row, column_exchange_.data() + row, x, 1);
}

void Factorization::solve(std::span<double> x, int columns) const {
  check_size(x, columns);
  const int rows = symbolic_->rows();
  for (int c = 0; c < columns; c += columns_at_once)
    solve_pivots(x.data() + static_cast<std::ptrdiff_t>(c) * rows, std::min(columns_at_once, columns - c), 0,
                 symbolic_->pivots());
}

void Factorization::solve_component(std::span<double> x, int component) const {
  check_size(x, 1);
  solve_pivots(x.data(), 1, symbolic_->component_begin(component), symbolic_->component_begin(component + 1));
}

void Factorization::solve_components(std::span<double> x, std::span<const int> components) const {
  check_size(x, 1);
  if (any_packed_) {
    set_active(components);
    solve_steps(x.data());
  } else {
    for (const int c : components)
      solve_range(x.data(), 1, symbolic_->component_begin(c), symbolic_->component_begin(c + 1));
  }
}

/// All pivots, or those of one component.
void Factorization::solve_pivots(double* x, int columns, int begin, int end) const {
  if (!any_packed_ || begin == end) return solve_range(x, columns, begin, end);
  if (end - begin == symbolic_->pivots()) {
    set_all_active();
  } else {
    const int component = symbolic_->component(symbolic_->node(begin));
    set_active({&component, 1});
  }
  for (int c = 0; c < columns; ++c) solve_steps(x + static_cast<std::ptrdiff_t>(c) * symbolic_->rows());
}

void Factorization::solve_range(double* x, int columns, int begin, int end) const {
  for (int k = begin; k < end; ++k) solve_forward(k, x, columns);
  for (int k = end - 1; k >= begin; --k) solve_backward(k, x, columns);
}

/// x_k := D^-1 x_k, then the coupled rows lose L x_k.
void Factorization::solve_forward(int k, double* x, int columns) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const std::ptrdiff_t stride = s.rows();
  double* xk = x + p.row;
  solve_diagonal(k, xk, columns, stride);
  const double* lower = values_.data() + p.lower;
  if (columns == 1 && equal_[k] > 0) {
    kernels_->forwards[equal_[k] - 1](x, &s.pivot(0), s.coupled(k), lower, xk, p.dimension);
    return;
  }
  for (int e = p.begin; e < p.end; ++e) {
    const Symbolic::Pivot& pi = s.pivot(s.coupled_[e]);
    kernels_->product(pi.dimension)(x + pi.row, stride, lower, xk, stride, pi.dimension, p.dimension, columns);
    lower += pi.dimension * p.dimension;
  }
}

/// x_k loses D^-1 U times the coupled rows.
void Factorization::solve_backward(int k, double* x, int columns) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const std::ptrdiff_t stride = s.rows();
  const double* upper = values_.data() + p.upper;
  if (columns == 1 && equal_[k] > 0) {
    kernels_->backwards[equal_[k] - 1](x + p.row, &s.pivot(0), s.coupled(k), upper, x, p.dimension);
    return;
  }
  for (int e = p.begin; e < p.end; ++e) {
    const Symbolic::Pivot& pj = s.pivot(s.coupled_[e]);
    kernels_->product(p.dimension)(x + p.row, stride, upper, x + pj.row, stride, p.dimension, pj.dimension,
                                    columns);
    upper += p.dimension * pj.dimension;
  }
}

/// The symmetric kinds solve with A itself: W^T in place of L would serve too, at more rounding.
void Factorization::solve_transposed(std::span<double> x, int columns) const {
  if (symmetric()) {
    solve(x, columns);
    return;
  }
  check_size(x, columns);
  for (int c = 0; c < columns; ++c) solve_column_transposed(x.data() + static_cast<std::ptrdiff_t>(c) * symbolic_->rows());
}

void Factorization::solve_column_transposed(double* x) const {
  const Symbolic& s = *symbolic_;
  double buffer[simd::largest_factor];
  for (int k = 0; k < s.pivots(); ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    const double* upper = factor_of(k, buffer).upper;
    for (int e = p.begin; e < p.end; ++e) {
      const Symbolic::Pivot& pj = s.pivot(s.coupled_[e]);
      kernels::subtract_transposed_times_vector(x + pj.row, upper, x + p.row, p.dimension, pj.dimension);
      upper += p.dimension * pj.dimension;
    }
  }
  for (int k = s.pivots() - 1; k >= 0; --k) {
    const Symbolic::Pivot& p = s.pivot(k);
    double* xk = x + p.row;
    const PivotFactor factor = factor_of(k, buffer);
    const double* lower = factor.lower;
    for (int e = p.begin; e < p.end; ++e) {
      const Symbolic::Pivot& pi = s.pivot(s.coupled_[e]);
      kernels::subtract_transposed_times_vector(xk, lower, x + pi.row, pi.dimension, p.dimension);
      lower += pi.dimension * p.dimension;
    }
    const int row = first_row_[k];
    if (rank_[k] == p.dimension)
      kernels::solve_block_transposed(factor.diagonal, row_exchange_.data() + row, xk, p.dimension);
    else
      solve_rank_deficient_transposed(factor.diagonal, p.dimension, rank_[k], row_exchange_.data() + row,
                                      column_exchange_.data() + row, xk);
  }
}

}  // namespace graphsolve
