#include <algorithm>
#include <array>
#include <cmath>

#include "factorization/active.hpp"

/// What is remembered of a diagonal block while neighbours add to it: amounts that its pivots are compared with.
namespace graphsolve {

/// Is what neighbours add to the diagonal of this block remembered? Only where something is decided by it.
bool Factorization::Impl::tracks_reference(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  return p.saddle && kind_ != FactorizationKind::cholesky && (p.may_depend || (saddle_shift_ != 0 && symmetric()));
}

/// Must the reference of this block be noted before the elimination begins? Else it is zero, or what stands on the diagonal
/// when its turn comes, since nobody changes it.
bool Factorization::Impl::starts_with_reference(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  return tracks_reference(k) || (symmetric() && !p.leaf && (!p.saddle || kind_ == FactorizationKind::cholesky));
}

void Factorization::Impl::find_referenced() {
  const auto steps = symbolic_->program().steps();
  const auto starts = [&](const simd::Program::Step& step) {
    return starts_with_reference(step.pack < 0 ? step.pivot : symbolic_->program().pack(step.pack).pivot[0]);
  };
  referenced_.reserve(std::ranges::count_if(steps, starts));
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (starts(steps[i])) referenced_.push_back(static_cast<int>(i));
}

std::size_t Factorization::Impl::reference_place(int k, int row) const {
  const simd::RowPlace at = symbolic_->program().row_place(k);
  return static_cast<std::size_t>(at.first) + static_cast<std::size_t>(row) * at.stride;
}

/// Side by side: in place, or a copy.
const double* Factorization::Impl::references(int k, double* buffer) const {
  const simd::RowPlace at = symbolic_->program().row_place(k);
  if (at.stride == 1) return reference_.data() + at.first;
  for (int i = 0; i < symbolic_->dimension(k); ++i) buffer[i] = reference_[at.first + i * at.stride];
  return buffer;
}

void Factorization::Impl::start_reference(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const bool tracked = tracks_reference(k), compared = symmetric() && (!p.saddle || kind_ == FactorizationKind::cholesky);
  const double* diagonal = values_.data() + p.diagonal;
  for (int i = 0; i < p.dimension; ++i, diagonal += p.stride * (p.dimension + 1))
    reference(k, i) = tracked ? *diagonal : compared ? std::abs(*diagonal) : 0.0;
  if (tracked && p.may_depend) start_panel_reference(k);
}

/// The same of pivots in lanes.
void Factorization::Impl::start_references(const simd::PivotPack& pack, unsigned active) {
  const Symbolic::Pivot& p = symbolic_->pivot(pack.pivot[0]);
  if (active != pack.used) {
    for (int l = 0; l < pack.lanes; ++l)
      if (active >> l & 1u) start_reference(pack.pivot[l]);
    return;
  }
  const bool tracked = tracks_reference(pack.pivot[0]);
  const double* diagonal = values_.data() + pack.place;
  double* reference = reference_.data() + pack.lane_rows;
  for (int i = 0; i < p.dimension; ++i, reference += pack.lanes, diagonal += pack.lanes * (p.dimension + 1))
    for (int l = 0; l < pack.lanes; ++l) reference[l] = tracked ? diagonal[l] : std::abs(diagonal[l]);
  if (tracked && p.may_depend) start_panel_references(pack);
}

/// Largest entry of each row right of the diagonal block.
void Factorization::Impl::start_panel_reference(int k) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension;
  for (int i = 0; i < d; ++i) panel_reference(k, i) = 0;
  const auto take = [&](int i, double entry) {
    double& largest = panel_reference(k, i);
    largest = std::max(largest, std::abs(entry));
  };
  if (symmetric()) {  // the blocks right of it need not have been filled
    for (int e = p.begin; e < p.end; ++e) {
      if (s.fill_[e]) continue;  // zero in the matrix
      const double* column = values_.data() + p.lower + s.block_offset_[e] * p.stride;
      for (int i = 0; i < d; ++i)
        for (int q = 0; q < s.dimension(s.coupled_[e]); ++q, column += p.stride) take(i, *column);
    }
    return;
  }
  for (int e = p.begin; e < p.end; ++e) {
    if (s.fill_[e]) continue;
    const double* entry = values_.data() + p.upper + s.block_offset_[e] * p.stride;
    for (int c = 0; c < s.dimension(s.coupled_[e]); ++c)
      for (int i = 0; i < d; ++i, entry += p.stride) take(i, *entry);
  }
}

/// The same of pivots in lanes. What is fill in some of them is zero there, what is fill in all is left out.
void Factorization::Impl::start_panel_references(const simd::PivotPack& pack) {
  switch (pack.lanes) {
    case 8: return start_panel_references_of<8>(pack);
    case 4: return start_panel_references_of<4>(pack);
    case 2: return start_panel_references_of<2>(pack);
    default: return start_panel_reference(pack.pivot[0]);
  }
}

template <int Lanes>
void Factorization::Impl::start_panel_references_of(const simd::PivotPack& pack) {
  const simd::Shape& shape = symbolic_->program().shape(pack);
  const int d = shape.dimension;
  double* reference = panel_reference_.data() + pack.lane_rows;
  std::fill_n(reference, d * Lanes, 0.0);
  const double* block = values_.data() + (symmetric() ? pack.place + d * d * Lanes : pack.upper);
  for (int c = 0; c < shape.couplings(); block += d * shape.coupled[c++] * Lanes) {
    bool fill = true;
    for (int l = 0; l < Lanes; ++l) fill &= symbolic_->is_fill(pack.pivot[l], c);
    if (fill) continue;
    const int rows = shape.coupled[c];
    for (int i = 0; i < d; ++i) {
      std::array<double, Lanes> largest{};
      for (int q = 0; q < rows; ++q) {
        const double* entry = block + (symmetric() ? i * rows + q : q * d + i) * Lanes;
        for (int l = 0; l < Lanes; ++l) largest[l] = std::max(largest[l], std::abs(entry[l]));
      }
      for (int l = 0; l < Lanes; ++l) reference[i * Lanes + l] = std::max(reference[i * Lanes + l], largest[l]);
    }
  }
}

void Factorization::Impl::prepare() {
  if (keep_matrix_) keep();
  // With a shift all saddle blocks of a symmetric matrix have one.
  if (symmetric() && saddle_shift_ != 0) return each_active_pivot([&](int k) { start_reference(k); });
  const simd::Program& program = symbolic_->program();
  const auto groups = program.groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (lanes_[g] == 0) continue;
    for (auto i = std::ranges::lower_bound(referenced_, groups[g].first_step); i != referenced_.end() && *i < groups[g].end_step; ++i) {
      const auto& step = program.steps()[*i];
      if (step.pack >= 0) {
        const unsigned used = program.pack(step.pack).used;
        start_references(program.pack(step.pack), groups[g].copies > 1 ? used & lanes_[g] : used);
      } else if (takes_part(step.pivot)) {
        start_reference(step.pivot);
      }
    }
  }
}

void Factorization::Impl::shift_pivot(int k, double* diagonal) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const bool tracked = tracks_reference(k);
  for (int i = 0; i < p.dimension; ++i) {
    double& entry = diagonal[i * (p.dimension + 1)];
    // Where nothing may depend, all that was added has one sign, and the diagonal is its sum.
    entry += saddle_shift_ * (tracked ? reference(k, i) : entry);
  }
}

}  // namespace graphsolve
