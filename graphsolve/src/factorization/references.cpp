#include "factorization/references.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "simd/program.hpp"

namespace graphsolve {

References::References(const Symbolic& symbolic, FactorizationKind kind)
    : symbolic_(symbolic), kind_(kind), symmetric_(kind != FactorizationKind::ldu) {
  find_started();
  bool uncertain = false;
  for (int k = 0; k < symbolic.pivots(); ++k) uncertain = uncertain || symbolic.may_depend(k);
  const int rows = symbolic.packs() == Packs::on ? symbolic.program().lane_rows() : symbolic.rows();
  if (uncertain || symmetric_) own_.assign(rows, 0.0);
  if (uncertain) panel_.assign(rows, 0.0);
}

bool References::track(int k) const {
  const Symbolic::Pivot& p = symbolic_.pivot(k);
  return p.saddle && kind_ != FactorizationKind::cholesky && (p.may_depend || (shifted_ && symmetric_));
}

/// With what stands on its own diagonal.
bool References::is_compared(int k) const {
  return symmetric_ && (!symbolic_.pivot(k).saddle || kind_ == FactorizationKind::cholesky);
}

bool References::start_with(int k) const { return track(k) || (is_compared(k) && !symbolic_.pivot(k).leaf); }

void References::find_started() {
  const auto steps = symbolic_.program().steps();
  const auto starts = [&](const simd::Program::Step& step) {
    return start_with(step.pack < 0 ? step.pivot : symbolic_.program().pack(step.pack).pivot[0]);
  };
  started_.reserve(std::ranges::count_if(steps, starts));
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (starts(steps[i])) started_.push_back(static_cast<int>(i));
}

std::size_t References::place(int k, int row) const {
  const simd::RowPlace at = symbolic_.program().row_place(k);
  return static_cast<std::size_t>(at.first) + static_cast<std::size_t>(row) * at.stride;
}

/// Side by side: in place, or a copy.
const double* References::side_by_side(int k, double* buffer) const {
  const simd::RowPlace at = symbolic_.program().row_place(k);
  if (at.stride == 1) return own_.data() + at.first;
  for (int i = 0; i < symbolic_.dimension(k); ++i) buffer[i] = own_[at.first + i * at.stride];
  return buffer;
}

void References::start(int k, const double* values) {
  const Symbolic::Pivot& p = symbolic_.pivot(k);
  const bool tracked = track(k), compared = is_compared(k);
  const double* diagonal = values + p.diagonal;
  for (int i = 0; i < p.dimension; ++i, diagonal += p.stride * (p.dimension + 1))
    own(k, i) = tracked ? *diagonal : compared ? std::abs(*diagonal) : 0.0;
  if (tracked && p.may_depend) start_panel(k, values);
}

/// The same of pivots in lanes.
void References::start(const simd::PivotPack& pack, unsigned active, const double* values) {
  const Symbolic::Pivot& p = symbolic_.pivot(pack.pivot[0]);
  if (active != pack.used) {
    for (int l = 0; l < pack.lanes; ++l)
      if (active >> l & 1u) start(pack.pivot[l], values);
    return;
  }
  const bool tracked = track(pack.pivot[0]);
  const double* diagonal = values + pack.place;
  double* reference = own_.data() + pack.lane_rows;
  for (int i = 0; i < p.dimension; ++i, reference += pack.lanes, diagonal += pack.lanes * (p.dimension + 1))
    for (int l = 0; l < pack.lanes; ++l) reference[l] = tracked ? diagonal[l] : std::abs(diagonal[l]);
  if (tracked && p.may_depend) start_panels(pack, values);
}

/// Largest entry of each row right of the diagonal block.
void References::start_panel(int k, const double* values) {
  const Symbolic& s = symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const std::span<const int> coupled = s.coupled(k);
  const int d = p.dimension;
  for (int i = 0; i < d; ++i) panel(k, i) = 0;
  const auto take = [&](int i, double entry) {
    double& largest = panel(k, i);
    largest = std::max(largest, std::abs(entry));
  };
  if (symmetric_) {  // the blocks right of it need not have been filled
    for (std::size_t e = 0; e < coupled.size(); ++e) {
      if (s.is_fill(k, static_cast<int>(e))) continue;  // zero in the matrix
      const double* column = values + p.lower + s.block_offsets(p)[e] * p.stride;
      for (int i = 0; i < d; ++i)
        for (int q = 0; q < s.dimension(coupled[e]); ++q, column += p.stride) take(i, *column);
    }
    return;
  }
  for (std::size_t e = 0; e < coupled.size(); ++e) {
    if (s.is_fill(k, static_cast<int>(e))) continue;
    const double* entry = values + p.upper + s.block_offsets(p)[e] * p.stride;
    for (int c = 0; c < s.dimension(coupled[e]); ++c)
      for (int i = 0; i < d; ++i, entry += p.stride) take(i, *entry);
  }
}

/// The same of pivots in lanes. What is fill in some of them is zero there, what is fill in all is left out.
void References::start_panels(const simd::PivotPack& pack, const double* values) {
  switch (pack.lanes) {
    case 8: return start_panels_of<8>(pack, values);
    case 4: return start_panels_of<4>(pack, values);
    case 2: return start_panels_of<2>(pack, values);
    default: return start_panel(pack.pivot[0], values);
  }
}

template <int Lanes>
void References::start_panels_of(const simd::PivotPack& pack, const double* values) {
  const simd::Shape& shape = symbolic_.program().shape(pack);
  const int d = shape.dimension;
  double* reference = panel_.data() + pack.lane_rows;
  std::fill_n(reference, d * Lanes, 0.0);
  const double* block = values + (symmetric_ ? pack.place + d * d * Lanes : pack.upper);
  for (int c = 0; c < shape.couplings(); block += d * shape.coupled[c++] * Lanes) {
    bool fill = true;
    for (int l = 0; l < Lanes; ++l) fill &= symbolic_.is_fill(pack.pivot[l], c);
    if (fill) continue;
    const int rows = shape.coupled[c];
    for (int i = 0; i < d; ++i) {
      std::array<double, Lanes> largest{};
      for (int q = 0; q < rows; ++q) {
        const double* entry = block + (symmetric_ ? i * rows + q : q * d + i) * Lanes;
        for (int l = 0; l < Lanes; ++l) largest[l] = std::max(largest[l], std::abs(entry[l]));
      }
      for (int l = 0; l < Lanes; ++l) reference[i * Lanes + l] = std::max(reference[i * Lanes + l], largest[l]);
    }
  }
}

void References::start(const Participants& participants, const double* values) {
  if (symmetric_ && shifted_) return participants.each_pivot([&](int k) { start(k, values); });
  const simd::Program& program = symbolic_.program();
  const auto groups = program.groups();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const unsigned lanes = participants.lanes(g);
    if (lanes == 0) continue;
    for (auto i = std::ranges::lower_bound(started_, groups[g].first_step); i != started_.end() && *i < groups[g].end_step; ++i) {
      const auto& step = program.steps()[*i];
      if (step.pack >= 0) {
        const unsigned used = program.pack(step.pack).used;
        start(program.pack(step.pack), groups[g].copies > 1 ? used & lanes : used, values);
      } else if (participants.include(step.pivot)) {
        start(step.pivot, values);
      }
    }
  }
}

}  // namespace graphsolve
