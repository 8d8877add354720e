#include <cmath>
#include <limits>
#include <stdexcept>

#include "graphsolve/factorization.hpp"

/// Iterative refinement against the kept matrix.
namespace graphsolve {

template <class F>
void Factorization::each_row(int begin, int end, F&& f) const {
  for (int k = begin; k < end; ++k) {
    const Symbolic::Pivot& p = symbolic_->pivot(k);
    for (int i = p.row; i < p.row + p.dimension; ++i) f(i);
  }
}

/// residual_ = b - A x; returns the componentwise backward error of x.
double Factorization::residual(std::span<const double> b, std::span<const double> x, int begin, int end) {
  const Symbolic& s = *symbolic_;
  each_row(begin, end, [&](int i) {
    residual_[i] = b[i];
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
  for (int k = begin; k < end; ++k) {
    const Symbolic::Pivot& p = s.pivot(k);
    subtract(matrix_.data() + p.diagonal, p.row, p.dimension, p.row, p.dimension);
    for (int e = p.begin; e < p.end; ++e) {
      if (s.fill_[e]) continue;  // zero in the matrix
      const Symbolic::Pivot& q = s.pivot(s.coupled_[e]);
      subtract(matrix_.data() + p.lower + s.block_offset_[e], q.row, q.dimension, p.row, p.dimension);
      subtract(matrix_.data() + p.upper + s.block_offset_[e], p.row, p.dimension, q.row, q.dimension);
    }
  }
  double error = 0;
  each_row(begin, end, [&](int i) {
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
  const double goal = 4 * std::numeric_limits<double>::epsilon();
  Refinement result{.sweeps = 0, .backward_error = residual(b, x, begin, end)};
  while (result.sweeps < max_sweeps && result.backward_error > goal) {
    each_row(begin, end, [&](int i) { correction_[i] = residual_[i]; });
    solve_pivots(correction_.data(), 1, begin, end);
    each_row(begin, end, [&](int i) { x[i] += correction_[i]; });
    const double error = residual(b, x, begin, end);
    if (!(error < result.backward_error)) {
      each_row(begin, end, [&](int i) { x[i] -= correction_[i]; });
      break;
    }
    ++result.sweeps;
    const bool slow = error > 0.9 * result.backward_error;
    result.backward_error = error;
    if (slow) break;
  }
  return result;
}

}  // namespace graphsolve
