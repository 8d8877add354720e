#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "factorization_active.hpp"
#include "graphsolve/largest.hpp"
#include "twice_precision.hpp"

/// Iterative refinement against the kept matrix.
namespace graphsolve {

namespace {

constexpr double goal = 4 * std::numeric_limits<double>::epsilon();
constexpr int patience = 3;  ///< sweeps in a row that may bring nothing: the worst row is not always the same

}  // namespace

/// residual_ = b - A x and error_, the componentwise backward error of x, of one component.
void Factorization::residual(std::span<const double> b, std::span<const double> x, int component, Precision precision) {
  const Symbolic& s = *symbolic_;
  each_row(component, [&](int i) {
    residual_[i] = b[i];
    residual_low_[i] = 0;
    magnitude_[i] = std::abs(b[i]);
  });
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = 0; j < columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride) {
        const double product = *block * x[column + j];
        residual_[i] -= product;
        magnitude_[i] += std::abs(product);
      }
  };
  const auto subtract_twice = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = 0; j < columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride) {
        subtract_product(residual_[i], residual_low_[i], *block, x[column + j]);
        magnitude_[i] += std::abs(*block * x[column + j]);
      }
  };
  const auto each_block = [&](auto&& take) {
    for (int k = s.component_begin(component); k < s.component_begin(component + 1); ++k) {
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
  };
  if (precision == Precision::plain) each_block(subtract);
  else each_block(subtract_twice);
  error_[component] = 0;
  each_row(component, [&](int i) {
    residual_[i] += residual_low_[i];
    if (magnitude_[i] != 0) keep_largest(error_[component], std::abs(residual_[i]) / magnitude_[i]);
  });
}

Factorization::Refinement Factorization::refine(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return refine(b, x, everything_, max_sweeps);
}

Factorization::Refinement Factorization::refine(std::span<const double> b, std::span<double> x,
                                                std::span<const int> components, int max_sweeps) {
  if (matrix_.empty()) throw std::logic_error("refine: allow_refinement() and keep_matrix(true) come before factorize()");
  refined_.assign(components.begin(), components.end());
  const auto keep_x = [&](int c) { each_row(c, [&](int i) { best_[i] = x[i]; }); };
  for (const int c : components) {
    residual(b, x, c, Precision::plain);
    precision_[c] = Precision::plain;
    in_vain_[c] = 0;
    least_error_[c] = error_[c];
    keep_x(c);
  }
  Refinement result;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    std::erase_if(refined_, [&](int c) { return in_vain_[c] == patience || !(least_error_[c] > goal); });
    if (refined_.empty()) break;
    for (const int c : refined_) each_row(c, [&](int i) { correction_[i] = residual_[i]; });
    set_active(refined_);
    solve_active(correction_.data(), 1);
    for (const int c : refined_) {
      each_row(c, [&](int i) { x[i] += correction_[i]; });
      residual(b, x, c, precision_[c]);
      const bool slow = !(error_[c] <= 0.9 * least_error_[c]);
      in_vain_[c] = slow ? in_vain_[c] + 1 : 0;
      if (error_[c] < least_error_[c]) {
        least_error_[c] = error_[c];
        result.sweeps = sweep + 1;
        keep_x(c);
      }
      // Rows may stand still because others, whose error is small, are wrong by what rounding takes.
      if (slow && std::exchange(precision_[c], Precision::twice) == Precision::plain) residual(b, x, c, Precision::twice);
    }
  }
  for (const int c : components) {
    each_row(c, [&](int i) { x[i] = best_[i]; });
    keep_largest(result.backward_error, least_error_[c]);
  }
  return result;
}

}  // namespace graphsolve
