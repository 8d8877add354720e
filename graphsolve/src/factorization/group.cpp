#include <algorithm>

#include "symbolic/equal_couplings.hpp"
#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"

/// Several pivots of a dense end eliminated together: what follows them is touched once, not once per pivot. Every number
/// receives what it does one by one, in the same order: the bits are the same. Only in plans without packs.
namespace graphsolve {

/// What the earlier members of the group, from `begin` on, take from the blocks of pivot k. L is the gathered panel of the
/// group, `depth` deep, from the row of k on.
void Factorization::Impl::update_member(int begin, int k, const double* l, int depth) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension, known = (k - begin) * d, m = p.end - p.begin;
  double* v = values_.data();
  double w[kernels::at_once * kernels::max_spread];  // column k of the earlier W, one below the other
  for (int r = begin; r < k; ++r)
    for (int c = 0; c < d; ++c)
      std::copy_n(v + s.pivot(r).upper + ((k - r - 1) * d + c) * d, d, w + c * known + (r - begin) * d);
  const auto product = kernels_->product(d);
  const bool watch = references_.track(k);
  double* own = v + p.diagonal;
  for (int r = begin; r < k; ++r) {
    if (watch) remember_diagonal(own, d);
    product(own, d, l + (r - begin) * d * d, w + (r - begin) * d, known, d, d, d);
    if (watch) note_added(k, own, d);
  }
  const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(depth) * d;
  kernels_->columns_of_blocks[d - 1](v + p.lower, l + next, next, w, known, m);
  if (symmetric()) return;
  for (int r = begin; r < k; ++r)
    product(v + p.upper, d, l + (r - begin) * d * d, v + s.pivot(r).upper + (k - r) * d * d, d, d, d, m * d);
}

/// The blocks between what is coupled to all of the group lose their part of L W.
void Factorization::Impl::update_after(int begin, int size, const double* l, const double* spread_w) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& last = s.pivot(begin + size - 1);
  const int d = last.dimension, depth = size * d, m = last.end - last.begin;
  const std::span<const int> coupled = s.coupled(begin + size - 1);
  const auto row = kernels_->rows_of_blocks[d - 1];
  double* v = values_.data();
  for (int i = 0; i < m; ++i, l += depth * d) {
    const std::int64_t* target = s.targets(last) + static_cast<std::int64_t>(i) * last.target_stride;
    const int end = symmetric() ? i + 1 : m;
    if (!references_.track(coupled[i])) {
      row(v, target, l, spread_w, depth, 0, end);
      continue;
    }
    row(v, target, l, spread_w, depth, 0, i);
    if (i + 1 < end) row(v, target, l, spread_w, depth, i + 1, end);
    kernels_->watched_blocks[d - 1](v + target[i], &references_.own(coupled[i], 0), l, spread_w, depth, d, i);
  }
}

/// The panel of member r becomes part of the gathered L, block row after block row, each depth x d, and of the spread W. What the
/// members behind it take from it stays where it is.
void Factorization::Impl::gather_member(int begin, int r, int size, double* l) {
  const Symbolic& s = *symbolic_;
  const int k = begin + r, d = s.dimension(k), depth = size * d, inside = size - 1 - r;
  const int couplings = static_cast<int>(s.coupled(k).size());
  const PivotBlocks blocks = open(k);
  const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(depth) * d;
  const bool at_once = may_be_spread(k);
  l += r * next + r * d * d;
  if (at_once) {
    kernels_->halve(d)(blocks.diagonal, blocks.lower, blocks.upper, d, d, inside);
    spread_panel(k, blocks, inside, l + inside * next, next, r * d, depth);
  } else {
    finish_panel(k, blocks);
    kernels_->spreads[d - 1](blocks.upper + inside * d * d, spread_.data(), d, couplings - inside, r * d, depth);
  }
  for (int i = 0; i < (at_once ? inside : couplings); ++i) std::copy_n(blocks.lower + i * d * d, d * d, l + i * next);
}

/// Pivots begin, ..., begin + size - 1, a group.
void Factorization::Impl::eliminate_group(int begin, int size, Outcome& outcome) {
  const Symbolic& s = *symbolic_;
  const int d = s.dimension(begin), depth = size * d, couplings = static_cast<int>(s.coupled(begin).size());
  double* l = spread_.data() + kernels::spread_size(depth, couplings, d);
  for (int r = 0; r < size && outcome.ok(); ++r) {
    const int k = begin + r;
    if (r > 0) update_member(begin, k, l + static_cast<std::ptrdiff_t>(r - 1) * depth * d, depth);
    begin_alone(k, outcome);
    if (!factorize_pivot(k, open(k), outcome)) return;
    gather_member(begin, r, size, l);
    outcome.operations += panel_operations(k) + d * updated_scalars(couplings - r, d);
  }
  if (outcome.ok()) update_after(begin, size, l + static_cast<std::ptrdiff_t>(size - 1) * depth * d, spread_.data());
}

}  // namespace graphsolve
