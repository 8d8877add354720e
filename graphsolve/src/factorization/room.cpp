#include <algorithm>
#include <stdexcept>
#include <string>

#include "symbolic/equal_couplings.hpp"
#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"
#include "simd/pivot_kernels.hpp"

/// What a factorization sets aside before the first number comes.
namespace graphsolve {

namespace {

std::shared_ptr<const Symbolic> checked(std::shared_ptr<const Symbolic> symbolic) {
  if (!symbolic) throw std::invalid_argument("a factorization needs a symbolic one, not a null pointer");
  return symbolic;
}

}  // namespace

Factorization::Impl::Impl(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind)
    : symbolic_(checked(std::move(symbolic))), kind_(kind), kernels_(&kernels::table()),
      eliminations_(&simd::eliminations()), solves_(&simd::solves()), taking_part_(*symbolic_), references_(*symbolic_, kind),
      refiner_(*symbolic_, *solves_), standing_(symbolic_->components()) {
  const Symbolic& s = *symbolic_;
  values_.assign(s.values_size(), 0.0);
  row_exchange_.assign(s.rows(), 0);
  rank_.resize(s.pivots());
  if (symmetric()) halved_.assign(s.pivots(), Halved::no);
  first_row_.assign(s.pivots(), 0);
  equal_.assign(s.pivots(), 0);
  group_.assign(s.pivots(), 1);
  among_single_.assign(s.pivots(), 0);
  scattered_.assign(s.pivots(), 0);
  int largest = 0, spread = 0, next_group = 0, uncertain_rows = 0;
  for (int k = 0, row = 0; k < s.pivots(); ++k) {
    first_row_[k] = row;
    rank_[k] = s.dimension(k);
    if (s.may_depend(k)) uncertain_rows += s.dimension(k);
    equal_[k] = static_cast<char>(equal_couplings(s, k));
    among_single_[k] = s.program().place(k) < 0 &&
                       std::ranges::all_of(s.coupled(k), [&](int later) { return s.program().place(later) < 0; });
    // Pivots of packs always, so that sums are the same in bits however many copies lie side by side.
    scattered_[k] = s.program().place(k) >= 0 ||
                    std::ranges::any_of(s.coupled(k), [&](int later) { return s.pivot(later).stride != 1; });
    spread = std::max(spread, spread_size(s, k));
    if (k == next_group) {
      const int size = equal_[k] > 0 && among_single_[k] ? group_size(s, k, equal_[k]) : 1;
      group_[k] = static_cast<char>(size);
      next_group = k + size;
    } else {
      group_[k] = 0;
    }
    row += s.dimension(k);
    largest = std::max(largest, s.dimension(k));
  }
  dropped_.reserve(uncertain_rows);
  if (uncertain_rows > 0 || symmetric()) column_exchange_.assign(s.rows(), 0);
  work_.assign(2 * largest * largest + 3 * largest, 0.0);
  spread_.assign(spread, 0.0);
  outcomes_.resize(s.components());
  make_room_for_packs();
}

void Factorization::Impl::make_room_for_packs() {
  const Symbolic& s = *symbolic_;
  const simd::Program& program = s.program();
  packed_.assign(program.packs(), 0);
  if (s.packs() == Packs::on) lane_rows_.assign(program.lane_rows(), 0.0);
  if (program.packs() == 0) return;
  scratch_.assign(program.scratch_size(), 0.0);
  if (symmetric()) {
    definite_.reserve(program.packs());
    for (int i = 0; i < program.packs(); ++i) definite_.push_back(definite(program.pack(i).pivot[0]));
  }
  std::int64_t largest = 0;
  int block = 0;
  for (int k = 0; k < s.pivots(); ++k) {
    if (s.pivot(k).stride != 1) largest = std::max(largest, s.pivot(k).scalars());
    if (scattered_[k])
      for (const int later : s.coupled(k)) block = std::max(block, s.dimension(later));
  }
  opened_.assign(largest, 0.0);
  target_.assign(static_cast<std::size_t>(block) * block, 0.0);
}

/// What is as large as the matrix is only set aside: pages that nobody touches cost no memory, and most solves are never
/// refined.
void Factorization::Impl::allow_refinement() {
  matrix_.reserve(values_.size());
  refiner_.reserve();
}

}  // namespace graphsolve
