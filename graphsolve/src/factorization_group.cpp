#include <algorithm>

#include "equal_couplings.hpp"
#include "graphsolve/factorization.hpp"
#include "kernels.hpp"

/// Several pivots of a dense end eliminated together: what follows them is touched once, not once per pivot. Every number
/// receives what it does one by one, in the same order: the bits are the same. Only in plans without packs.
namespace graphsolve {

/// What the earlier members of the group, from `begin` on, take from the blocks of pivot k. L is the gathered panel of the
/// group, `depth` deep, from the row of k on.
void Factorization::update_member(int begin, int k, const double* l, int depth) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension, known = (k - begin) * d, m = p.end - p.begin;
  double* v = values_.data();
  double w[kernels::at_once * kernels::max_spread];  // column k of the earlier W, one below the other
  for (int r = begin; r < k; ++r)
    for (int c = 0; c < d; ++c)
      std::copy_n(v + s.pivot(r).upper + ((k - r - 1) * d + c) * d, d, w + c * known + (r - begin) * d);
  const auto product = kernels_->product(d);
  const bool watch = tracks_reference(k);
  double* own = v + p.diagonal;
  for (int r = begin; r < k; ++r) {
    if (watch) remember_diagonal(own, d);
    product(own, d, l + (r - begin) * d * d, w + (r - begin) * d, known, d, d, d);
    if (watch) note_added(k, own, d);
  }
  double* lower = v + p.lower;
  for (int i = 1; i <= m; ++i, lower += d * d)
    product(lower, d, l + static_cast<std::ptrdiff_t>(i) * depth * d, w, known, d, known, d);
  if (symmetric()) return;
  for (int r = begin; r < k; ++r)
    product(v + p.upper, d, l + (r - begin) * d * d, v + s.pivot(r).upper + (k - r) * d * d, d, d, d, m * d);
}

/// The blocks between what is coupled to all of the group lose their part of L W.
void Factorization::update_after(int begin, int size, const double* l, const double* spread_w) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& last = s.pivot(begin + size - 1);
  const int d = last.dimension, depth = size * d, m = last.end - last.begin;
  const int* coupled = s.coupled_.data() + last.begin;
  const auto row = kernels_->rows_of_blocks[d - 1];
  double* v = values_.data();
  for (int i = 0; i < m; ++i, l += depth * d) {
    const std::int64_t* target = s.targets(last) + static_cast<std::int64_t>(i) * last.target_stride;
    const int end = symmetric() ? i + 1 : m;
    if (!tracks_reference(coupled[i])) {
      row(v, target, l, spread_w, depth, 0, end);
      continue;
    }
    row(v, target, l, spread_w, depth, 0, i);
    if (i + 1 < end) row(v, target, l, spread_w, depth, i + 1, end);
    kernels_->watched_blocks[d - 1](v + target[i], reference_.data() + s.row(coupled[i]), l, spread_w, depth, d, i);
  }
}

/// Pivots begin, ..., begin + size - 1, a group.
void Factorization::eliminate_group(int begin, int size, Outcome& outcome) {
  const Symbolic& s = *symbolic_;
  const int d = s.dimension(begin), depth = size * d, couplings = static_cast<int>(s.coupled(begin).size());
  double* spread_w = spread_.data();
  double* l = spread_w + kernels::spread_size(depth, couplings, d);  // block row after block row, each depth x d
  for (int r = 0; r < size && outcome.ok(); ++r) {
    const int k = begin + r, m = couplings - r;
    const Symbolic::Pivot& p = s.pivot(k);
    if (r > 0) update_member(begin, k, l + static_cast<std::ptrdiff_t>(r - 1) * depth * d, depth);
    begin_alone(k, outcome);
    if (!factorize_pivot(k, open(k), outcome)) return;
    finish_panel(k, open(k), outcome);
    outcome.operations += d * updated_scalars(m, d);
    const double* lower = values_.data() + p.lower;
    for (int i = r; i < couplings; ++i, lower += d * d)
      std::copy_n(lower, d * d, l + static_cast<std::ptrdiff_t>(i) * depth * d + r * d * d);
    const int inside = size - 1 - r;
    kernels_->spreads[d - 1](values_.data() + p.upper + inside * d * d, spread_w, d, m - inside, r * d, depth);
  }
  if (outcome.ok()) update_after(begin, size, l + static_cast<std::ptrdiff_t>(size - 1) * depth * d, spread_w);
}

}  // namespace graphsolve
