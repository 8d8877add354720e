#include <cmath>
#include <limits>
#include <stdexcept>

#include "graphsolve/factorization.hpp"
#include "twice_precision.hpp"

/// Iterative refinement against the kept matrix.
namespace graphsolve {

namespace {

constexpr double goal = 4 * std::numeric_limits<double>::epsilon();
constexpr int patience = 3;  ///< sweeps in a row that may bring nothing: the worst row is not always the same

}  // namespace

template <class F>
void Factorization::each_row(int begin, int end, F&& f) const {
  for (int k = begin; k < end; ++k) {
    const Symbolic::Pivot& p = symbolic_->pivot(k);
    for (int i = p.row; i < p.row + p.dimension; ++i) f(i);
  }
}

/// residual_ = b - A x; returns the componentwise backward error of x.
double Factorization::residual(std::span<const double> b, std::span<const double> x, int begin, int end, Precision precision) {
  const Symbolic& s = *symbolic_;
  each_row(begin, end, [&](int i) {
    residual_[i] = b[i];
    residual_low_[i] = 0;
    magnitude_[i] = std::abs(b[i]);
  });
  const auto subtract = [&](const double* block, int row, int rows, int column, int columns) {
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) {
        const double product = block[j * rows + i] * x[column + j];
        residual_[row + i] -= product;
        magnitude_[row + i] += std::abs(product);
      }
  };
  const auto subtract_twice = [&](const double* block, int row, int rows, int column, int columns) {
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) {
        subtract_product(residual_[row + i], residual_low_[row + i], block[j * rows + i], x[column + j]);
        magnitude_[row + i] += std::abs(block[j * rows + i] * x[column + j]);
      }
  };
  const auto each_block = [&](auto&& take) {
    for (int k = begin; k < end; ++k) {
      const Symbolic::Pivot& p = s.pivot(k);
      take(matrix_.data() + p.diagonal, p.row, p.dimension, p.row, p.dimension);
      for (int e = p.begin; e < p.end; ++e) {
        if (s.fill_[e]) continue;  // zero in the matrix
        const Symbolic::Pivot& q = s.pivot(s.coupled_[e]);
        take(matrix_.data() + p.lower + s.block_offset_[e], q.row, q.dimension, p.row, p.dimension);
        take(matrix_.data() + p.upper + s.block_offset_[e], p.row, p.dimension, q.row, q.dimension);
      }
    }
  };
  if (precision == Precision::plain) each_block(subtract);
  else each_block(subtract_twice);
  double error = 0;
  each_row(begin, end, [&](int i) {
    residual_[i] += residual_low_[i];
    if (magnitude_[i] == 0) return;
    const double e = std::abs(residual_[i]) / magnitude_[i];
    if (e > error || std::isnan(e)) error = e;  // a NaN stays: nothing is larger
  });
  return error;
}

Factorization::Refinement Factorization::refine(std::span<const double> b, std::span<double> x, int max_sweeps) {
  return refine_range(b, x, 0, symbolic_->pivots(), max_sweeps);
}

Factorization::Refinement Factorization::refine(std::span<const double> b, std::span<double> x, int component,
                                                int max_sweeps) {
  return refine_range(b, x, symbolic_->component_begin(component), symbolic_->component_begin(component + 1), max_sweeps);
}

Factorization::Refinement Factorization::refine_range(std::span<const double> b, std::span<double> x, int begin, int end,
                                                      int max_sweeps) {
  if (matrix_.empty()) throw std::logic_error("refine: allow_refinement() and keep_matrix(true) come before factorize()");
  Precision precision = Precision::plain;
  Refinement result{.sweeps = 0, .backward_error = residual(b, x, begin, end, precision)};
  const auto keep_x = [&] { each_row(begin, end, [&](int i) { best_[i] = x[i]; }); };
  keep_x();
  for (int sweep = 0, in_vain = 0; sweep < max_sweeps && result.backward_error > goal; ++sweep) {
    each_row(begin, end, [&](int i) { correction_[i] = residual_[i]; });
    solve_pivots(correction_.data(), 1, begin, end);
    each_row(begin, end, [&](int i) { x[i] += correction_[i]; });
    const double error = residual(b, x, begin, end, precision);
    const bool slow = !(error <= 0.9 * result.backward_error);
    if (error < result.backward_error) {
      result = {.sweeps = sweep + 1, .backward_error = error};
      keep_x();
    }
    in_vain = slow ? in_vain + 1 : 0;
    if (in_vain == patience) break;
    // Rows may stand still because others, whose error is small, are wrong by what rounding takes.
    if (slow && precision == Precision::plain) {
      precision = Precision::twice;
      (void)residual(b, x, begin, end, precision);
    }
  }
  each_row(begin, end, [&](int i) { x[i] = best_[i]; });
  return result;
}

}  // namespace graphsolve
