#include <algorithm>
#include <cmath>

#include "symbolic/equal_couplings.hpp"
#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"

/// What the elimination of one pivot does to the blocks between its couplings: nearly all of the work.
namespace graphsolve {

namespace {

/// Blocks of a row, from some coupling on, of which the first `count` lose their part of L W; in a symmetric matrix
/// the lower triangle of the one that follows too.
struct BlockRow {
  const Symbolic& symbolic;
  const int* coupled;
  const std::int64_t* target;
  int count, rows, inner;
  bool symmetric;
};

/// Scalars that were updated.
inline std::int64_t update_row(const kernels::Table& kernel, double* values, const BlockRow& row, const double* lower,
                               const double* upper) {
  const int di = row.rows, d = row.inner;
  const auto product = kernel.product(di);
  std::int64_t columns = 0;
  for (int j = 0; j < row.count; ++j) {
    const int dj = row.symbolic.pivot(row.coupled[j]).dimension;
    product(values + row.target[j], di, lower, upper, d, di, d, dj);
    upper += d * dj;
    columns += dj;
  }
  if (!row.symmetric) return columns * di;
  kernel.lower_product(di)(values + row.target[row.count], lower, upper, di, d);
  return columns * di + di * (di + 1) / 2;
}

}  // namespace

void Factorization::Impl::remember_diagonal(const double* block, int d, int stride) {
  for (int q = 0; q < d; ++q) work_[q] = block[q * (d + 1) * stride];
}

/// What was added to the diagonal of pivot k since remember_diagonal.
void Factorization::Impl::note_added(int k, const double* block, int d, int stride) {
  for (int q = 0; q < d; ++q) {
    double& largest = references_.own(k, q);
    const double added = block[q * (d + 1) * stride] - work_[q];
    largest = std::abs(added) > std::abs(largest) ? added : largest;  // no branch: unpredictable
  }
}

/// Numbers between so many couplings of one size that an elimination changes.
std::int64_t Factorization::Impl::updated_scalars(std::int64_t couplings, std::int64_t rows) const {
  return symmetric() ? rows * (rows * couplings * (couplings - 1) + couplings * (rows + 1)) / 2
                     : rows * rows * couplings * couplings;
}

/// The blocks between couplings `from`, from + 1, ... of pivot k lose L W; of symmetric ones the lower triangle.
void Factorization::Impl::update(int k, const PivotBlocks& blocks, int from, Outcome& outcome) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension, m = p.end - p.begin;
  const int* coupled = s.coupled(k).data();
  double* v = values_.data();
  const double* lower = blocks.lower + s.block_offsets(p)[from];
  const double* upper = blocks.upper + s.block_offsets(p)[from];
  const int size = !scattered_[k] && in_rows(m - from, equal_[k]) ? equal_[k] : 0;
  if (size > 0 && !is_half_kept(k)) kernels_->spreads[size - 1](upper, spread_.data(), d, m - from, 0, d);
  std::int64_t scalars = size > 0 ? updated_scalars(m - from, size) : 0;
  for (int i = from; i < m; ++i) {
    const std::int64_t* target = s.targets(p) + static_cast<std::int64_t>(i) * p.target_stride + from;
    const int di = s.pivot(coupled[i]).dimension, before = symmetric() ? i - from : m - from;
    const bool watch = references_.track(coupled[i]);
    const int stride = s.pivot(coupled[i]).stride;
    double* own = v + target[i - from];
    if (size > 0) {
      const auto row = kernels_->rows_of_blocks[size - 1];
      const int end = before + (symmetric() ? 1 : 0);
      row(v, target, lower, spread_.data(), d, 0, watch ? i - from : end);
      if (watch) {
        kernels_->watched_blocks[size - 1](own, &references_.own(coupled[i], 0), lower, spread_.data(), d, d, i - from);
        row(v, target, lower, spread_.data(), d, i - from + 1, end);
      }
    } else {
      if (watch) remember_diagonal(own, di, stride);
      if (scattered_[k]) scalars += update_row_scattered(k, i, from, lower, upper);
      else scalars += update_row(*kernels_, v, {s, coupled + from, target, before, di, d, symmetric()}, lower, upper);
      if (watch) note_added(coupled[i], own, di, stride);
    }
    lower += di * d;
  }
  outcome.operations += d * scalars;
}

/// update_row where some blocks lie interleaved with others: products into a block of their own first.
std::int64_t Factorization::Impl::update_row_scattered(int k, int i, int from, const double* lower, const double* upper) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int* coupled = s.coupled(k).data();
  const std::int64_t* target = s.targets(p) + static_cast<std::int64_t>(i) * p.target_stride;
  const int d = p.dimension, di = s.dimension(coupled[i]), end = symmetric() ? i + 1 : p.end - p.begin;
  std::int64_t scalars = 0;
  for (int j = from; j < end; ++j) {
    const int dj = s.dimension(coupled[j]);
    const std::int64_t stride = s.pivot(coupled[std::min(i, j)]).stride;
    const bool triangle = symmetric() && i == j;
    double* to = values_.data() + target[j];
    std::fill_n(target_.data(), di * dj, 0.0);
    kernels_->product(di)(target_.data(), di, lower, upper, d, di, d, dj);
    for (int c = 0; c < dj; ++c)
      for (int r = triangle ? c : 0; r < di; ++r) to[(c * di + r) * stride] += target_[c * di + r];
    scalars += triangle ? di * (di + 1) / 2 : di * dj;
    upper += d * dj;
  }
  return scalars;
}

}  // namespace graphsolve
