#include <algorithm>
#include <cmath>

#include "graphsolve/factorization.hpp"

/// What is remembered of a diagonal block while neighbours add to it: amounts that its pivots are compared with.
namespace graphsolve {

/// Is what neighbours add to the diagonal of this block remembered? Only where something is decided by it.
bool Factorization::tracks_reference(int k) const {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  return p.saddle && kind_ != FactorizationKind::cholesky && (p.may_depend || (saddle_shift_ != 0 && symmetric()));
}

void Factorization::start_reference(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  double* reference = reference_.data() + first_row_[k];
  const double* diagonal = values_.data() + p.diagonal;
  const int d = p.dimension;
  if (tracks_reference(k)) {
    for (int i = 0; i < d; ++i) reference[i] = diagonal[i * (d + 1)];
    start_panel_reference(k);
  } else if (symmetric() && (!p.saddle || kind_ == FactorizationKind::cholesky))
    for (int i = 0; i < d; ++i) reference[i] = std::abs(diagonal[i * (d + 1)]);
  else
    std::fill_n(reference, d, 0.0);
}

/// Largest entry of each row right of the diagonal block.
void Factorization::start_panel_reference(int k) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension;
  double* reference = panel_reference_.data() + first_row_[k];
  std::fill_n(reference, d, 0.0);
  if (symmetric()) {  // the blocks right of it need not have been filled
    for (int e = p.begin; e < p.end; ++e) {
      if (s.fill_[e]) continue;  // zero in the matrix
      const double* column = values_.data() + p.lower + s.block_offset_[e];
      for (int i = 0; i < d; ++i)
        for (int q = 0; q < s.dimension(s.coupled_[e]); ++q) reference[i] = std::max(reference[i], std::abs(*column++));
    }
    return;
  }
  for (int e = p.begin; e < p.end; ++e) {
    if (s.fill_[e]) continue;
    const double* column = values_.data() + p.upper + s.block_offset_[e];
    for (int c = 0; c < s.dimension(s.coupled_[e]); ++c, column += d)
      for (int i = 0; i < d; ++i) reference[i] = std::max(reference[i], std::abs(column[i]));
  }
}

void Factorization::prepare_range(int begin, int end) {
  if (begin == end) return;
  if (keep_matrix_) keep(begin, end);
  if (symmetric()) {
    for (int k = begin; k < end; ++k) start_reference(k);
  } else {  // of the others nobody asks
    for (auto k = std::lower_bound(uncertain_.begin(), uncertain_.end(), begin); k != uncertain_.end() && *k < end; ++k)
      start_reference(*k);
  }
}

void Factorization::shift_pivot(int k) {
  const Symbolic::Pivot& p = symbolic_->pivot(k);
  double* diagonal = values_.data() + p.diagonal;
  const double* reference = reference_.data() + first_row_[k];
  const bool tracked = tracks_reference(k);
  for (int i = 0; i < p.dimension; ++i) {
    double& entry = diagonal[i * (p.dimension + 1)];
    // Where nothing may depend, all that was added has one sign, and the diagonal is its sum.
    entry += saddle_shift_ * (tracked ? reference[i] : entry);
  }
}

}  // namespace graphsolve
