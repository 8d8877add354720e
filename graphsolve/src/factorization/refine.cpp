#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "factorization/active.hpp"
#include "graphsolve/largest.hpp"
#include "simd/pivot_kernels.hpp"
#include "factorization/twice_precision.hpp"

/// Iterative refinement against the kept matrix.
namespace graphsolve {

namespace {

constexpr double goal = 4 * std::numeric_limits<double>::epsilon();
constexpr int patience = 3;  ///< sweeps in a row that may bring nothing: the worst row is not always the same

}  // namespace

void Factorization::Impl::start_residual(std::span<const double> b, int component) {
  each_row(component, [&](int i) {
    residual_[i] = b[i];
    residual_low_[i] = 0;
    magnitude_[i] = std::abs(b[i]);
  });
}

/// take(block, its first row, rows, first column, columns) for the blocks of the kept matrix that belong to pivot k.
template <class F>
void Factorization::Impl::each_kept_block(int k, F&& take) const {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  take(matrix_.data() + p.diagonal, p.stride, p.row, p.dimension, p.row, p.dimension);
  for (int e = p.begin; e < p.end; ++e) {
    if (s.fill_[e]) continue;  // zero in the matrix
    const Symbolic::Pivot& q = s.pivot(s.coupled_[e]);
    const std::int64_t offset = s.block_offset_[e] * p.stride;
    take(matrix_.data() + p.lower + offset, p.stride, q.row, q.dimension, p.row, p.dimension);
    take(matrix_.data() + p.upper + offset, p.stride, p.row, p.dimension, q.row, q.dimension);
  }
}

/// error_: the componentwise backward error.
void Factorization::Impl::finish_residual(int component) {
  error_[component] = 0;
  each_row(component, [&](int i) {
    residual_[i] += residual_low_[i];
    if (magnitude_[i] != 0) keep_largest(error_[component], std::abs(residual_[i]) / magnitude_[i]);
  });
}

/// residual_ = b - A x of the active components.
void Factorization::Impl::residual(std::span<const double> b, std::span<const double> x) {
  const simd::Program& program = symbolic_->program();
  for (const int c : active_) start_residual(b, c);
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = 0; j < columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride) {
        const double product = *block * x[column + j];
        residual_[i] -= product;
        magnitude_[i] += std::abs(product);
      }
  };
  walk(
      false,
      [&](int number, unsigned lanes) {
        const simd::PivotPack& pack = program.pack(number);
        solves_->residual[pack.kind]({.program = program, .pack = pack,
                                .matrix = matrix_.data(), .x = x.data(), .residual = residual_.data(),
                                .magnitude = magnitude_.data(), .active = lanes});
      },
      [&](int k) { each_kept_block(k, subtract); });
  for (const int c : active_) finish_residual(c);
}

/// residual_ = b - A^T x of the active components: packs have no kernel for it.
void Factorization::Impl::residual_transposed(std::span<const double> b, std::span<const double> x) {
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = column; j < column + columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride) {
        const double product = *block * x[i];
        residual_[j] -= product;
        magnitude_[j] += std::abs(product);
      }
  };
  for (const int c : active_) {
    start_residual(b, c);
    for (int k = symbolic_->component_begin(c); k < symbolic_->component_begin(c + 1); ++k) each_kept_block(k, subtract);
    finish_residual(c);
  }
}

/// The same of one component, in twice the precision.
void Factorization::Impl::residual_twice(std::span<const double> b, std::span<const double> x, int component, Side side) {
  start_residual(b, component);
  const auto take = [&](int i, double entry, int j) {
    subtract_product(residual_[i], residual_low_[i], entry, x[j]);
    magnitude_[i] += std::abs(entry * x[j]);
  };
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = column; j < column + columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride)
        side == Side::plain ? take(i, *block, j) : take(j, *block, i);
  };
  for (int k = symbolic_->component_begin(component); k < symbolic_->component_begin(component + 1); ++k)
    each_kept_block(k, subtract);
  finish_residual(component);
}

Factorization::Refinement Factorization::Impl::refine(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return refine(b, x, everything_, max_sweeps, Side::plain);
}

Factorization::Refinement Factorization::Impl::refine(std::span<const double> b, std::span<double> x,
                                                std::span<const int> components, int max_sweeps) {
  return refine(b, x, components, max_sweeps, Side::plain);
}

/// The symmetric kinds keep both triangles, which are equal.
Factorization::Refinement Factorization::Impl::refine_transposed(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return refine(b, x, everything_, max_sweeps, symmetric() ? Side::plain : Side::transposed);
}

Factorization::Refinement Factorization::Impl::refine(std::span<const double> b, std::span<double> x,
                                                std::span<const int> components, int max_sweeps, Side side) {
  if (!copied_) throw std::logic_error("refine: allow_refinement() and keep_matrix(true) come before factorize()");
  check_size(b, 1);
  check_size(x, 1);
  check_components(components);
  check_factored(components);
  for (auto* v : {&residual_, &residual_low_, &magnitude_, &best_}) v->resize(symbolic_->rows());
  refined_.assign(components.begin(), components.end());
  const auto keep_x = [&](int c) { each_row(c, [&](int i) { best_[i] = x[i]; }); };
  const auto measure = [&] { side == Side::plain ? residual(b, x) : residual_transposed(b, x); };
  set_active(components);
  measure();
  for (const int c : components) {
    precision_[c] = Precision::plain;
    in_vain_[c] = 0;
    least_error_[c] = error_[c];
    keep_x(c);
  }
  Refinement result;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    std::erase_if(refined_, [&](int c) { return in_vain_[c] == patience || !(least_error_[c] > goal); });
    if (refined_.empty()) break;
    set_active(refined_);
    side == Side::plain ? solve_active(residual_.data(), 1) : solve_transposed_active(residual_.data());
    for (const int c : refined_) each_row(c, [&](int i) { x[i] += residual_[i]; });
    measure();
    for (const int c : refined_) {
      if (precision_[c] == Precision::twice) residual_twice(b, x, c, side);
      const bool slow = !(error_[c] <= 0.9 * least_error_[c]);
      in_vain_[c] = slow ? in_vain_[c] + 1 : 0;
      if (error_[c] < least_error_[c]) {
        least_error_[c] = error_[c];
        result.sweeps = sweep + 1;
        keep_x(c);
      }
      // Rows may stand still because others, whose error is small, are wrong by what rounding takes.
      if (slow && std::exchange(precision_[c], Precision::twice) == Precision::plain) residual_twice(b, x, c, side);
    }
  }
  for (const int c : components) {
    each_row(c, [&](int i) { x[i] = best_[i]; });
    keep_largest(result.backward_error, least_error_[c]);
  }
  return result;
}

}  // namespace graphsolve
