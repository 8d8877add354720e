#include "factorization/residual.hpp"

#include <cmath>

#include "factorization/twice_precision.hpp"
#include "graphsolve/largest.hpp"

namespace graphsolve {

/// What is as large as the rows is only set aside: pages that nobody touches cost no memory, and most solves are never
/// refined.
void Residual::reserve() {
  for (auto* v : {&residual_, &low_, &magnitude_}) v->reserve(symbolic_.rows());
  error_.assign(symbolic_.components(), 0.0);
}

void Residual::start(std::span<const double> b, int component) {
  each_row(symbolic_, component, [&](int i) {
    residual_[i] = b[i];
    low_[i] = 0;
    magnitude_[i] = std::abs(b[i]);
  });
}

void Residual::finish(int component) {
  error_[component] = 0;
  each_row(symbolic_, component, [&](int i) {
    residual_[i] += low_[i];
    if (magnitude_[i] != 0) keep_largest(error_[component], std::abs(residual_[i]) / magnitude_[i]);
  });
}

/// take(block, its stride, its first row, rows, first column, columns) for the blocks of the matrix that belong to pivot k.
template <class F>
void Residual::each_block(const double* matrix, int k, F&& take) const {
  const Symbolic& s = symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  take(matrix + p.diagonal, p.stride, p.row, p.dimension, p.row, p.dimension);
  const std::span<const int> coupled = s.coupled(k);
  for (std::size_t e = 0; e < coupled.size(); ++e) {
    if (s.is_fill(k, static_cast<int>(e))) continue;  // zero in the matrix
    const Symbolic::Pivot& q = s.pivot(coupled[e]);
    const std::int64_t offset = s.block_offsets(p)[e] * p.stride;
    take(matrix + p.lower + offset, p.stride, q.row, q.dimension, p.row, p.dimension);
    take(matrix + p.upper + offset, p.stride, p.row, p.dimension, q.row, q.dimension);
  }
}

void Residual::measure(const System& system, const Participants& participants) {
  for (auto* v : {&residual_, &low_, &magnitude_}) v->resize(symbolic_.rows());
  system.side == Side::plain ? measure_plain(system, participants) : measure_transposed(system, participants);
}

void Residual::measure_plain(const System& system, const Participants& participants) {
  const simd::Program& program = symbolic_.program();
  for (const int c : participants.components()) start(system.b, c);
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = 0; j < columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride) {
        const double product = *block * system.x[column + j];
        residual_[i] -= product;
        magnitude_[i] += std::abs(product);
      }
  };
  participants.walk(
      false,
      [&](int number, unsigned lanes) {
        const simd::PivotPack& pack = program.pack(number);
        kernels_.residual[pack.kind]({.program = program, .pack = pack,
                                .matrix = system.matrix, .x = system.x.data(), .residual = residual_.data(),
                                .magnitude = magnitude_.data(), .active = lanes});
      },
      [&](int k) { each_block(system.matrix, k, subtract); });
  for (const int c : participants.components()) finish(c);
}

/// Packs have no kernel for it.
void Residual::measure_transposed(const System& system, const Participants& participants) {
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = column; j < column + columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride) {
        const double product = *block * system.x[i];
        residual_[j] -= product;
        magnitude_[j] += std::abs(product);
      }
  };
  for (const int c : participants.components()) {
    start(system.b, c);
    for (int k = symbolic_.component_begin(c); k < symbolic_.component_begin(c + 1); ++k) each_block(system.matrix, k, subtract);
    finish(c);
  }
}

void Residual::measure_twice(const System& system, int component) {
  start(system.b, component);
  const auto take = [&](int i, double entry, int j) {
    subtract_product(residual_[i], low_[i], entry, system.x[j]);
    magnitude_[i] += std::abs(entry * system.x[j]);
  };
  const auto subtract = [&](const double* block, int stride, int row, int rows, int column, int columns) {
    for (int j = column; j < column + columns; ++j)
      for (int i = row; i < row + rows; ++i, block += stride)
        system.side == Side::plain ? take(i, *block, j) : take(j, *block, i);
  };
  for (int k = symbolic_.component_begin(component); k < symbolic_.component_begin(component + 1); ++k)
    each_block(system.matrix, k, subtract);
  finish(component);
}

}  // namespace graphsolve
