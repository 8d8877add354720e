#include <algorithm>
#include <cassert>
#include <stdexcept>
#include <string>
#include <utility>

#include "factorization_active.hpp"
#include "kernels.hpp"
#include "rank_revealing.hpp"
#include "simd/pivot_kernels.hpp"

/// Solving with the factors. Of single pivots they have the same form for all kinds, of packs simd::Form.
namespace graphsolve {

namespace {

constexpr int columns_at_once = 8;  ///< more would push the blocks out of the cache between their uses

}  // namespace

void Factorization::check_size(std::span<const double> x, int columns) const {
  if (columns >= 0 && x.size() == static_cast<std::size_t>(symbolic_->rows()) * static_cast<std::size_t>(columns)) return;
  throw std::invalid_argument("right-hand side has " + std::to_string(x.size()) + " numbers, expected " +
                              std::to_string(symbolic_->rows()) + " rows x " + std::to_string(columns) + " columns");
}

void Factorization::solve_diagonal(int k, const double* diagonal, double* x, int columns, std::ptrdiff_t stride) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const int row = first_row_[k];
  if (rank_[k] == p.dimension) {
    kernels_->solve(p.dimension)(diagonal, row_exchange_.data() + row, x, p.dimension, columns, stride);
    return;
  }
  for (int c = 0; c < columns; ++c, x += stride)
    solve_rank_deficient(diagonal, p.dimension, rank_[k], row_exchange_.data() + row, column_exchange_.data() + row, x, 1);
}

void Factorization::solve(std::span<double> x, int columns) const {
  check_size(x, columns);
  set_all_active();
  const int rows = symbolic_->rows();
  for (int c = 0; c < columns; c += columns_at_once)
    solve_active(x.data() + static_cast<std::ptrdiff_t>(c) * rows, std::min(columns_at_once, columns - c));
}

void Factorization::solve_component(std::span<double> x, int component) const { solve_components(x, {&component, 1}); }

void Factorization::solve_components(std::span<double> x, std::span<const int> components) const {
  check_size(x, 1);
  set_active(components);
  solve_active(x.data(), 1);
}

/// f(job) for runs of lanes of a pack that were made together, column by column, alone(pivot) for those between them.
template <class F, class Alone>
void Factorization::solve_pack(int number, unsigned active, double* x, int columns, F&& f, Alone&& alone) const {
  const simd::Program& program = symbolic_->program();
  const simd::PivotPack& pack = program.pack(number);
  const auto together = [&](unsigned lanes) {
    for (int c = 0; c < columns; ++c)
      f(simd::PackSolve{.shape = program.shape(pack), .pack = pack, .rows = program.rows(pack),
                        .factor = values_.data() + pack.place, .x = x + static_cast<std::ptrdiff_t>(c) * symbolic_->rows(),
                        .active = lanes, .form = symmetric() ? simd::Form::ldlt : simd::Form::ldu});
  };
  if ((packed_[number] & active) == active) return together(active);
  unsigned run = 0;
  for (int l = 0; l <= pack.lanes; ++l) {
    const bool ends = l == pack.lanes || (active & ~packed_[number]) >> l & 1u;
    if (ends && run != 0) together(std::exchange(run, 0));
    if (l == pack.lanes) break;
    if (ends) alone(pack.pivot[l]);
    else run |= active & 1u << l;
  }
}

void Factorization::solve_active(double* x, int columns) const {
  const auto forward = [&](int k) { solve_forward(k, x, columns); };
  const auto backward = [&](int k) { solve_backward(k, x, columns); };
  walk(false, [&](int pack, unsigned lanes) { solve_pack(pack, lanes, x, columns, simd::solve_forward, forward); }, forward);
  const auto backward_pack = symmetric() ? simd::solve_backward_transposed : simd::solve_backward;
  walk(true, [&](int pack, unsigned lanes) { solve_pack(pack, lanes, x, columns, backward_pack, backward); }, backward);
}

/// x_k := D^-1 x_k, then the coupled rows lose L x_k.
void Factorization::solve_forward(int k, double* x, int columns) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const std::ptrdiff_t stride = s.rows();
  double buffer[simd::largest_factor];
  const PivotFactor factor = factor_of(k, buffer);
  double* xk = x + p.row;
  solve_diagonal(k, factor.diagonal, xk, columns, stride);
  const double* lower = factor.lower;
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
  double buffer[simd::largest_factor];
  const double* upper = factor_of(k, buffer).upper;
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

/// The symmetric kinds solve with A itself.
void Factorization::solve_transposed(std::span<double> x, int columns) const {
  if (symmetric()) return solve(x, columns);
  check_size(x, columns);
  set_all_active();
  const auto solve_column = [&](double* column) {
    const auto forward = [&](int k) { solve_forward_transposed(k, column); };
    const auto backward = [&](int k) { solve_backward_transposed(k, column); };
    walk(false, [&](int pack, unsigned lanes) { solve_pack(pack, lanes, column, 1, simd::solve_forward_transposed, forward); },
         forward);
    walk(true, [&](int pack, unsigned lanes) { solve_pack(pack, lanes, column, 1, simd::solve_backward_transposed, backward); },
         backward);
  };
  for (int c = 0; c < columns; ++c) solve_column(x.data() + static_cast<std::ptrdiff_t>(c) * symbolic_->rows());
}

/// The coupled rows lose W^T x_k.
void Factorization::solve_forward_transposed(int k, double* x) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  double buffer[simd::largest_factor];
  const double* upper = factor_of(k, buffer).upper;
  for (int e = p.begin; e < p.end; ++e) {
    const Symbolic::Pivot& pj = s.pivot(s.coupled_[e]);
    kernels::subtract_transposed_times_vector(x + pj.row, upper, x + p.row, p.dimension, pj.dimension);
    upper += p.dimension * pj.dimension;
  }
}

/// x_k := D^-T (x_k - L^T times the coupled rows).
void Factorization::solve_backward_transposed(int k, double* x) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  double buffer[simd::largest_factor];
  const PivotFactor factor = factor_of(k, buffer);
  double* xk = x + p.row;
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

}  // namespace graphsolve
