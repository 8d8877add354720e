#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

#include "factorization/given.hpp"
#include "factorization/impl.hpp"

/// Factoring again where only some nodes changed.
namespace graphsolve {

void Factorization::Impl::allow_refactorization() {
  const Symbolic& s = *symbolic_;
  allow_refinement();
  const int n = s.pivots();
  earlier_begin_.assign(n + 1, 0);
  for (int k = 0; k < n; ++k)
    for (const int later : s.coupled(k)) ++earlier_begin_[later + 1];
  for (int k = 0; k < n; ++k) earlier_begin_[k + 1] += earlier_begin_[k];
  earlier_.assign(earlier_begin_[n], 0);
  std::vector<int> next(earlier_begin_.begin(), earlier_begin_.end() - 1);
  for (int k = 0; k < n; ++k)
    for (const int later : s.coupled(k)) earlier_[next[later]++] = k;
  share_.assign(n, {});
  mark_.assign(n, Mark::none);
  queue_.clear();
  queue_.reserve(n);
  complete_ = false;
}

/// The changed nodes with their ancestors (Mark::redo), and the pivots outside that update them (Mark::apply), in the
/// order of elimination: then every block receives its updates in the order of a whole factorization.
void Factorization::Impl::collect_redone(std::span<const NodeId> changed) {
  const Symbolic& s = *symbolic_;
  queue_.clear();
  for (const NodeId node : changed)
    for (int k = s.position(node); k >= 0 && mark_[k] == Mark::none; k = s.parent(k)) {
      mark_[k] = Mark::redo;
      queue_.push_back(k);
    }
  const std::size_t redone = queue_.size();
  for (std::size_t q = 0; q < redone; ++q)
    for (int e = earlier_begin_[queue_[q]]; e < earlier_begin_[queue_[q] + 1]; ++e)
      if (mark_[earlier_[e]] == Mark::none) {
        mark_[earlier_[e]] = Mark::apply;
        queue_.push_back(earlier_[e]);
      }
  std::sort(queue_.begin(), queue_.end());
}

void Factorization::Impl::restore(int k) {
  if (symmetric()) mirror_matrix(k);
  each_given(symbolic_->pivot(k), symmetric(), [&](std::int64_t at) {
    values_[at] = matrix_[at];
    largest_entry_ = std::max(largest_entry_, std::abs(matrix_[at]));
  });
  if (symmetric() || references_.track(k)) references_.start(k, values_.data());
}

/// What the redone pivots had added to the outcome is taken out of it.
void Factorization::Impl::forget_redone(Outcome& outcome) {
  for (const int k : queue_) {
    if (mark_[k] != Mark::redo) continue;
    outcome.inertia.positive -= share_[k].inertia.positive;
    outcome.inertia.negative -= share_[k].inertia.negative;
    outcome.inertia.zero -= share_[k].inertia.zero;
    outcome.dropped_rows -= share_[k].dropped_rows;
    outcome.boosts -= share_[k].boosts;
  }
  std::erase_if(dropped_, [&](const DroppedRow& d) { return mark_[symbolic_->position(d.node)] == Mark::redo; });
}

Factorization::Outcome Factorization::Impl::refactorize(std::span<const NodeId> changed) {
  if (share_.empty() || !keep_matrix_)
    throw std::logic_error("refactorize: allow_refactorization() and keep_matrix(true) come before factorize()");
  if (!standing_.all_kept()) throw std::logic_error("refactorize: factorize() of all components with the matrix kept comes first");
  for (const NodeId node : changed)
    if (node.index < 0 || node.index >= symbolic_->pivots())
      throw std::invalid_argument("refactorize: there is no node " + std::to_string(node.index));
  if (!complete_) {
    std::copy(matrix_.begin(), matrix_.end(), values_.begin());
    return factorize();
  }
  const Symbolic& s = *symbolic_;
  collect_redone(changed);
  Outcome outcome = total_;
  outcome.operations = outcome.pivots = 0;
  forget_redone(outcome);
  for (const int k : queue_)
    if (mark_[k] == Mark::redo) restore(k);
  double largest = 0;
  int first_bad = -1;
  for (const int k : queue_) {
    const int component = s.component(s.node(k));
    if (!outcomes_[component].ok()) continue;
    if (mark_[k] == Mark::apply) {
      const auto later = s.coupled(k);  // those redone are the last ones: each is an ancestor of the one before
      int from = 0;
      while (mark_[later[from]] != Mark::redo) ++from;
      update(k, open(k), from, outcome);
    } else {
      largest = std::max(largest, largest_of(k));
      const PivotBlocks blocks = open(k);
      if (factorize_pivot(k, blocks, outcome)) {
        eliminate(k, blocks, outcome);
      } else {
        outcomes_[component].first_bad_pivot = k;
        if (first_bad < 0) first_bad = k;
      }
      close(k, blocks);
    }
  }
  outcome.first_bad_pivot = first_bad;
  if (largest_entry_ > 0) outcome.growth = largest / largest_entry_;
  for (const int k : queue_) mark_[k] = Mark::none;
  finish(taking_part_.everybody());
  total_ = outcome;
  complete_ = outcome.ok();
  return outcome;
}

}  // namespace graphsolve
