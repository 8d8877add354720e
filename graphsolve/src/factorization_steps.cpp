#include <algorithm>
#include <bit>
#include <utility>

#include "graphsolve/factorization.hpp"
#include "operations.hpp"
#include "simd/packed_factor.hpp"

/// Elimination and solves along the program: eight equal pivots at a time where there are as many.
namespace graphsolve {

void Factorization::factorize(std::span<const int> components, std::span<Outcome> outcomes) {
  const Symbolic& s = *symbolic_;
  set_active(components);
  complete_ = false;
  std::erase_if(dropped_, [&](const DroppedRow& d) { return active_[s.component(d.node)] != 0; });
  for (const int c : components) outcomes[c] = {};
  if (!in_packs()) {
    for (const int c : components) factorize_range(s.component_begin(c), s.component_begin(c + 1), outcomes[c]);
    return;
  }
  double largest = 0;
  for (const int c : components) {
    prepare_range(s.component_begin(c), s.component_begin(c + 1));
    largest_entry_ = largest = std::max(largest, largest_entry_);
  }
  factorize_steps(outcomes, Count::each);
}

/// What refactorize() applies again it reads from the values, where packs leave no factors. The shift of a symmetric
/// matrix is measured at every saddle block while it is updated.
bool Factorization::in_packs() const {
  return packed_ != nullptr && packs_ == Packs::on && share_.empty() && !(symmetric() && saddle_shift_ != 0);
}

void Factorization::set_active(std::span<const int> components) const {
  std::fill(active_.begin(), active_.end(), char{0});
  for (const int c : components) active_[c] = 1;
  all_active_ = components.size() == active_.size();
}

void Factorization::set_all_active() const {
  std::fill(active_.begin(), active_.end(), char{1});
  all_active_ = true;
}

unsigned Factorization::active_lanes(std::span<const int> pivots, unsigned used) const {
  if (all_active_) return used;
  unsigned found = 0;
  for (int l = 0; l < simd::lanes; ++l)
    found |= static_cast<unsigned>(active_[symbolic_->component(symbolic_->node(pivots[l]))]) << l;
  return found & used;
}

void Factorization::alone_if_active(int k, std::span<Outcome> outcomes) {
  const int c = symbolic_->component(symbolic_->node(k));
  if (!active_[c]) return;
  eliminate_alone(k, outcomes[c]);
  if (!outcomes[c].ok()) active_[c] = all_active_ = false;
}

/// Outcomes by component, or what packs do all in the first. A component that has failed takes no further part.
void Factorization::factorize_steps(std::span<Outcome> outcomes, Count count) {
  const Symbolic& s = *symbolic_;
  const simd::Program& program = s.program();
  any_packed_ = true;
  if (keep_matrix_) count = Count::each;
  const simd::PackData data{
      .values = values_.data(),
      .reference = reference_.data(),
      .first_row = first_row_.data(),
      .saddle_shift = saddle_shift_,
      .watch = kind_ == FactorizationKind::cholesky ? simd::Watch::no : simd::Watch::yes};
  for (const auto& step : program.steps()) {
    if (step.pack < 0) {
      alone_if_active(step.pivot, outcomes);
      continue;
    }
    const simd::PivotPack& pack = program.pack(step.pack);
    const unsigned active = active_lanes(pack.pivot, pack.used);
    if (active == 0) continue;
    eliminate_together(step.pack, active, outcomes, count, data);
  }
}

/// The lanes of a pack, or, where some have to go alone, runs of lanes between them: what several add to one block is
/// added in the order of the pivots, in any company.
void Factorization::eliminate_together(int number, unsigned active, std::span<Outcome> outcomes, Count count,
                                       const simd::PackData& data) {
  const Symbolic& s = *symbolic_;
  const simd::PivotPack& pack = s.program().pack(number);
  const simd::Shape& shape = s.program().shape(pack);
  const auto promise = definite(shape.saddle, shape.may_depend);
  const auto together = [&](unsigned lanes) {
    const unsigned before = packed_->present(number);
    const unsigned other = packed_->eliminate(number, data, promise, lanes);
    if (other != 0) return other;
    count_pack(pack, lanes, outcomes, count);
    for (unsigned rest = lanes & ~before, l = 0; rest != 0; rest >>= 1, ++l) {  // usually none: nothing changes its place
      if (!(rest & 1u)) continue;
      const int k = pack.pivot[l];
      rank_[k] = s.dimension(k);
      for (int i = 0; i < s.dimension(k); ++i) row_exchange_[first_row_[k] + i] = i;
    }
    return 0u;
  };
  const unsigned other = packed_->takes(shape) ? together(active) : active;
  if (other == 0) return;
  unsigned run = 0;
  for (int l = 0; l <= simd::lanes; ++l) {
    const bool ends = l == simd::lanes || (other >> l & 1u);
    if (ends && run != 0) together(std::exchange(run, 0));
    if (l == simd::lanes) break;
    if (ends) alone_if_active(pack.pivot[l], outcomes);
    else run |= active & 1u << l;
  }
}

void Factorization::count_pack(const simd::PivotPack& pack, unsigned active, std::span<Outcome> outcomes, Count count) {
  const Symbolic& s = *symbolic_;
  const simd::Shape& shape = s.program().shape(pack);
  const std::int64_t d = shape.dimension, m = shape.coupled_rows;
  const std::int64_t operations = symmetric() ? ldlt_operations(d) + d * m * d + d * m * (m + 1) / 2
                                              : lu_operations(d) + d * m * (d + m);
  const auto add = [&](Outcome& outcome, int pivots) {
    outcome.operations += operations * pivots;
    outcome.pivots += pivots;
    if (!symmetric()) return;
    const bool negative = shape.saddle && kind_ != FactorizationKind::cholesky;
    (negative ? outcome.inertia.negative : outcome.inertia.positive) += shape.dimension * pivots;
  };
  if (count == Count::together) return add(outcomes[0], std::popcount(active));
  for (int l = 0; l < simd::lanes; ++l) {
    if (!(active >> l & 1u)) continue;
    Outcome& outcome = outcomes[s.component(s.node(pack.pivot[l]))];
    add(outcome, 1);
    // The blocks of the pivot are still in the values, as the elimination met them.
    if (keep_matrix_ && largest_entry_ > 0)
      outcome.growth = std::max(outcome.growth, largest_of(pack.pivot[l]) / largest_entry_);
  }
}

void Factorization::solve_steps(double* x) const {
  const Symbolic& s = *symbolic_;
  const auto steps = s.program().steps();
  const auto walk = [&](const simd::Program::Step& step, auto&& together, auto&& alone) {
    if (step.pack < 0) {
      if (active_[s.component(s.node(step.pivot))]) alone(step.pivot);
      return;
    }
    const simd::PivotPack& pack = s.program().pack(step.pack);
    const unsigned active = active_lanes(pack.pivot, pack.used);
    if (active == 0) return;
    const unsigned present = packed_->present(step.pack) & active;
    if (present != 0) together(step.pack, present);
    for (unsigned rest = active & ~present, l = 0; rest != 0; rest >>= 1, ++l)
      if (rest & 1u) alone(pack.pivot[l]);
  };
  for (const auto& step : steps)
    walk(step, [&](int pack, unsigned lanes) { packed_->solve_forward(pack, x, lanes); },
         [&](int k) { solve_forward(k, x, 1); });
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    walk(*step, [&](int pack, unsigned lanes) { packed_->solve_backward(pack, x, lanes); },
         [&](int k) { solve_backward(k, x, 1); });
}

/// Where the factor of a pivot can be read: with the values, or copied from its pack. Its rows were not exchanged then.
Factorization::PivotFactor Factorization::factor_of(int k, double* buffer) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (!packed_ || !packed_->packed(k))
    return {values_.data() + p.diagonal, values_.data() + p.lower, values_.data() + p.upper};
  packed_->copy(k, buffer);
  const int d = p.dimension;
  return {buffer, buffer + d * d, buffer + d * (d + p.coupled_rows)};
}

}  // namespace graphsolve
