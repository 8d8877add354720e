#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "factorization/impl.hpp"
#include "factorization/thresholds.hpp"
#include "simd/pivot_kernels.hpp"

/// Elimination along the program: up to eight equal pivots at a time.
namespace graphsolve {

/// What refactorize() applies again it applies pivot by pivot. The shift of a symmetric matrix is measured at every
/// saddle block while it is updated.
bool Factorization::Impl::in_packs() const {
  return symbolic_->packs() == Packs::on && share_.empty() && !(symmetric() && saddle_shift_ != 0);
}

void Factorization::Impl::alone_if_active(int k) {
  if (!taking_part_.include(k)) return;
  const int c = symbolic_->component(symbolic_->node(k));
  eliminate_from(k, outcomes_[c]);
  if (!outcomes_[c].ok()) taking_part_.leave_out(c);
}

/// Outcomes by component, or what packs do all in the first. A component that has failed takes no further part. right: where
/// given, goes through the forward half of its solve on the way.
void Factorization::Impl::factorize_active(Count count, const Vectors* right) {
  const Symbolic& s = *symbolic_;
  if (keep_matrix_) keep();
  references_.start(taking_part_, values_.data());
  // A component by itself owns every lane: finding it by pivot, node and group was most of the time of counting.
  Outcome* const all = count == Count::together && !keep_matrix_ ? outcomes_.data()
                       : taking_part_.components().size() == 1   ? &outcomes_[taking_part_.components().front()]
                                                                 : nullptr;
  const simd::PackNumbers numbers{.values = values_.data(),
                                  .scratch = scratch_.data(),
                                  .reference = references_.in_lanes(),
                                  .saddle_shift = kind_ == FactorizationKind::cholesky ? 0.0 : saddle_shift_,
                                  .suspicious = suspicious_pivot()};
  const auto forward = [&](int k) { solve_forward(k, right->x, 1); };
  if (!in_packs()) {  // in the order of the pivots, as refactorize() goes
    for (const int c : taking_part_.components()) {
      for (int k = s.component_begin(c); k < s.component_begin(c + 1) && outcomes_[c].ok(); ++k) {
        eliminate_from(k, outcomes_[c]);
        if (right != nullptr && outcomes_[c].ok()) forward(k);
      }
      if (!outcomes_[c].ok()) taking_part_.leave_out(c);
    }
    return;
  }
  taking_part_.walk(
      false,
      [&](int pack, unsigned lanes) {
        eliminate_together(pack, lanes, all, numbers);
        if (right != nullptr) forward_pack(pack, lanes, *right);
      },
      [&](int k) {
        alone_if_active(k);
        if (right != nullptr && taking_part_.include(k)) forward(k);
      });
}

/// The lanes of a pack. Returns those that have to go alone; if there are any, nothing was done.
unsigned Factorization::Impl::eliminate_pack(int number, const simd::PackJob& job) const {
  if (!symmetric()) return eliminations_->any[job.pack.kind](job);
  const auto watch = kind_ == FactorizationKind::cholesky ? simd::Watch::no : simd::Watch::yes;
  return eliminations_->symmetric[job.pack.kind](job, definite_[number], watch);
}

/// These lanes were done together. Usually they were the last time: nothing changes its place.
void Factorization::Impl::note_packed(int number, unsigned lanes) {
  const unsigned before = packed_[number];
  if ((before & lanes) == lanes) return;
  const simd::PivotPack& pack = symbolic_->program().pack(number);
  packed_[number] = static_cast<std::uint8_t>(before | lanes);
  for (unsigned rest = lanes & ~before, l = 0; rest != 0; rest >>= 1, ++l) {
    if (!(rest & 1u)) continue;
    const int k = pack.pivot[l];
    rank_[k] = symbolic_->dimension(k);
    for (int i = 0; i < symbolic_->dimension(k); ++i) row_exchange_[first_row_[k] + i] = i;
  }
}

void Factorization::Impl::eliminate_together(int number, unsigned active, Outcome* all, const simd::PackNumbers& numbers) {
  const simd::Program& program = symbolic_->program();
  const simd::PivotPack& pack = program.pack(number);
  if (keep_matrix_ && largest_entry_ > 0) measure_growth(pack, active);
  const unsigned other = eliminate_pack(number, {program, pack, numbers, active});
  if (other != 0) return eliminate_lanes(number, active, other, all, numbers);
  note_packed(number, active);
  count_pack(pack, active, all);
}

/// Where some lanes have to go alone: runs of lanes between them. What several add to one block is added in the order of
/// the pivots, in any company.
void Factorization::Impl::eliminate_lanes(int number, unsigned active, unsigned other, Outcome* all, const simd::PackNumbers& numbers) {
  const simd::Program& program = symbolic_->program();
  const simd::PivotPack& pack = program.pack(number);
  unsigned run = 0;
  for (int l = 0; l <= pack.lanes; ++l) {
    const bool ends = l == pack.lanes || (other >> l & 1u);
    if (ends && run != 0) {
      (void)eliminate_pack(number, {program, pack, numbers, run});  // none of them has to go alone
      note_packed(number, run);
      count_pack(pack, run, all);
      run = 0;
    }
    if (l == pack.lanes) break;
    if (ends) alone_if_active(pack.pivot[l]);
    else run |= active & 1u << l;
  }
}

/// Of the blocks of a pack before they are eliminated.
void Factorization::Impl::measure_growth(const simd::PivotPack& pack, unsigned active) {
  const simd::Shape& shape = symbolic_->program().shape(pack);
  const int d = shape.dimension, lanes = pack.lanes;
  const double* v = values_.data() + pack.place;
  double largest[simd::lanes] = {};
  const auto take = [&](const double* block, int begin, int end) {
    for (int i = begin; i < end; ++i)
      for (int l = 0; l < lanes; ++l) largest[l] = std::max(largest[l], std::abs(block[i * lanes + l]));
  };
  if (symmetric()) {  // the other triangle is not kept up
    for (int j = 0; j < d; ++j) take(v, j * (d + 1), (j + 1) * d);
    take(v, d * d, shape.lower_size());
  } else {
    take(v, 0, shape.lower_size());
    take(values_.data() + pack.upper, 0, shape.upper_size());
  }
  for (int l = 0; l < lanes; ++l) {
    if (!(active >> l & 1u)) continue;
    Outcome& outcome = outcomes_[symbolic_->component(symbolic_->node(pack.pivot[l]))];
    outcome.growth = std::max(outcome.growth, largest[l] / largest_entry_);
  }
}

void Factorization::Impl::count_pack(const simd::PivotPack& pack, unsigned active, Outcome* all) {
  const Symbolic& s = *symbolic_;
  const simd::Shape& shape = s.program().shape(pack);
  const std::int64_t operations = symmetric() ? shape.symmetric_operations : shape.operations;
  const bool negative = shape.saddle && kind_ != FactorizationKind::cholesky;
  const int rows = symmetric() ? shape.dimension : 0;
  const auto add = [&](Outcome& outcome, int pivots) {
    outcome.operations += operations * pivots;
    outcome.pivots += pivots;
    (negative ? outcome.inertia.negative : outcome.inertia.positive) += rows * pivots;
  };
  const int lanes = active == pack.used ? pack.pivots : std::popcount(active);
  if (all != nullptr) return add(*all, lanes);
  const int first = s.component(s.node(pack.pivot[0]));
  const auto& group = s.program().groups()[s.program().group_of(first)];
  if (group.copies == 1) return add(outcomes_[first], lanes);
  for (int l = 0; l < pack.lanes; ++l)
    if (active >> l & 1u) add(outcomes_[group.component[l]], 1);
}

/// Where the factor of a pivot can be read, one scalar after the other: with the values, or a copy.
auto Factorization::Impl::factor_of(int k, double* buffer) const -> PivotFactor {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  if (p.stride == 1) return {values_.data() + p.diagonal, values_.data() + p.lower, values_.data() + p.upper};
  gather(k, buffer);
  return {buffer, buffer + p.dimension * p.dimension, buffer + p.lower_scalars()};
}

}  // namespace graphsolve
