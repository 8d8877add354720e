#include <algorithm>
#include <cmath>

#include "factorization_active.hpp"

/// What is remembered of a diagonal block while neighbours add to it: amounts that its pivots are compared with.
namespace graphsolve {

/// Is what neighbours add to the diagonal of this block remembered? Only where something is decided by it.
bool Factorization::tracks_reference(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  return p.saddle && kind_ != FactorizationKind::cholesky && (p.may_depend || (saddle_shift_ != 0 && symmetric()));
}

/// Must the reference of this block be noted before the elimination begins? Else it is zero, or what stands on the diagonal
/// when its turn comes, since nobody changes it.
bool Factorization::starts_with_reference(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  return tracks_reference(k) || (symmetric() && !p.leaf && (!p.saddle || kind_ == FactorizationKind::cholesky));
}

void Factorization::start_reference(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  double* reference = reference_.data() + p.row;
  const double* diagonal = values_.data() + p.diagonal;
  const int d = p.dimension, next = p.stride * (d + 1);
  if (tracks_reference(k)) {
    for (int i = 0; i < d; ++i) reference[i] = diagonal[i * next];
    if (p.may_depend) start_panel_reference(k);
  } else if (symmetric() && (!p.saddle || kind_ == FactorizationKind::cholesky))
    for (int i = 0; i < d; ++i) reference[i] = std::abs(diagonal[i * next]);
  else
    std::fill_n(reference, d, 0.0);
}

/// Largest entry of each row right of the diagonal block.
void Factorization::start_panel_reference(int k) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension;
  double* reference = panel_reference_.data() + p.row;
  std::fill_n(reference, d, 0.0);
  if (symmetric()) {  // the blocks right of it need not have been filled
    for (int e = p.begin; e < p.end; ++e) {
      if (s.fill_[e]) continue;  // zero in the matrix
      const double* column = values_.data() + p.lower + s.block_offset_[e] * p.stride;
      for (int i = 0; i < d; ++i)
        for (int q = 0; q < s.dimension(s.coupled_[e]); ++q, column += p.stride)
          reference[i] = std::max(reference[i], std::abs(*column));
    }
    return;
  }
  for (int e = p.begin; e < p.end; ++e) {
    if (s.fill_[e]) continue;
    const double* entry = values_.data() + p.upper + s.block_offset_[e] * p.stride;
    for (int c = 0; c < s.dimension(s.coupled_[e]); ++c)
      for (int i = 0; i < d; ++i, entry += p.stride) reference[i] = std::max(reference[i], std::abs(*entry));
  }
}

void Factorization::prepare() {
  if (keep_matrix_) keep();
  // With a shift all saddle blocks of a symmetric matrix have one.
  if (symmetric() && saddle_shift_ != 0) return each_active_pivot([&](int k) { start_reference(k); });
  for (const int c : active_) {
    const auto begin = std::ranges::lower_bound(referenced_, symbolic_->component_begin(c));
    const int end = symbolic_->component_begin(c + 1);
    for (auto k = begin; k != referenced_.end() && *k < end; ++k) start_reference(*k);
  }
}

void Factorization::shift_pivot(int k, double* diagonal) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  const double* reference = reference_.data() + p.row;
  const bool tracked = tracks_reference(k);
  for (int i = 0; i < p.dimension; ++i) {
    double& entry = diagonal[i * (p.dimension + 1)];
    // Where nothing may depend, all that was added has one sign, and the diagonal is its sum.
    entry += saddle_shift_ * (tracked ? reference[i] : entry);
  }
}

}  // namespace graphsolve
