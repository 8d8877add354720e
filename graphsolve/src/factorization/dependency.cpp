#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "factorization/impl.hpp"
#include "factorization/kernels.hpp"
#include "factorization/rank_revealing.hpp"
#include "factorization/thresholds.hpp"
#include "simd/program.hpp"

/// Rows of saddle blocks that depend on earlier ones: are they really dependent, and on which?
namespace graphsolve {

/// Do the rows left out of block k still couple to later pivots? Then they are not dependent, only early. What remains
/// of a coupling is measured against the column it stands in, and against what it was made of: the row in the matrix,
/// and between saddle blocks what was added to both diagonals. Of a block of rank 0 nothing but rounding remains.
bool Factorization::Impl::couples_later(int k, const PivotBlocks& blocks) {
  const Symbolic& s = *symbolic_;
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension, row = first_row_[k];
  const double* a = blocks.diagonal;
  const double* column = blocks.upper;
  double* x = work_.data() + 2 * d * d;
  const double couples = leaves_out(k) ? thresholds::couples_on_the_way : thresholds::couples;
  const double couples_of_made = leaves_out(k) ? thresholds::couples_on_the_way : thresholds::couples_of_made;
  for (const int coupled : s.coupled(k)) {
    const Symbolic::Pivot& later = s.pivot(coupled);
    for (int c = 0; c < later.dimension; ++c, column += d) {
      double largest = 0;
      for (int i = 0; i < d; ++i) largest = std::max(largest, std::abs(x[i] = column[i]));
      for (int q = 0; q < d; ++q) std::swap(x[q], x[row_exchange_[row + q]]);
      for (int q = 0; q < rank_[k]; ++q)
        for (int i = q + 1; i < d; ++i) x[i] -= a[q * d + i] * x[q];
      const double own = later.saddle ? std::abs(values_[later.diagonal + c * (later.dimension + 1) * later.stride]) : 0;
      for (int i = rank_[k]; i < d; ++i) {
        const int original = original_row(k, i);
        const double made_of = std::max(references_.panel(k, original), std::sqrt(references_.own(k, original) * own));
        const double rest = std::abs(x[i]);  // NaN couples
        if (!(rest <= couples * largest) && !(rest <= couples_of_made * made_of)) return true;
      }
    }
  }
  return false;
}

/// Was this pivot made in a pack?
bool Factorization::Impl::is_packed(int k) const {
  const int place = symbolic_->program().place(k);
  return place >= 0 && (packed_[place / simd::lanes] >> place % simd::lanes & 1u) != 0;
}

void Factorization::Impl::dependency(const DroppedRow& dropped, std::span<double> y) const {
  const Symbolic& s = *symbolic_;
  check_size(y, 1);
  if (std::ranges::none_of(dropped_, [&](const DroppedRow& d) { return d.node == dropped.node && d.row == dropped.row; }))
    throw std::invalid_argument("dependency: row " + std::to_string(dropped.row) + " of node " +
                                std::to_string(dropped.node.index) + " was not left out");
  std::fill(y.begin(), y.end(), 0.0);
  const int k = s.position(dropped.node);
  const Symbolic::Pivot& p = s.pivot(k);
  const int d = p.dimension, row = first_row_[k];
  double buffer[simd::largest_factor];
  const double* a = factor_of(k, buffer).diagonal;
  double* yk = y.data() + p.row;
  // z^T (P^T L) = e_m^T with m the place where the dropped row ended; beyond the rank L is the identity.
  yk[dropped.row] = 1;
  for (int q = 0; q < rank_[k]; ++q) std::swap(yk[q], yk[row_exchange_[row + q]]);
  for (int q = rank_[k] - 1; q >= 0; --q)
    for (int i = q + 1; i < d; ++i) yk[q] -= a[q * d + i] * yk[i];
  for (int q = rank_[k] - 1; q >= 0; --q) std::swap(yk[q], yk[row_exchange_[row + q]]);
  for (int j = k - 1; j >= s.component_begin(s.component(dropped.node)); --j) {
    const Symbolic::Pivot& pj = s.pivot(j);
    double* yj = y.data() + pj.row;
    const auto [diagonal, lower_panel, upper_panel] = factor_of(j, buffer);
    const double* lower = lower_panel;
    for (const int i : s.coupled(j)) {
      const Symbolic::Pivot& pi = s.pivot(i);
      kernels::subtract_transposed_times_vector(yj, lower, y.data() + pi.row, pi.dimension, pj.dimension);
      lower += pi.dimension * pj.dimension;
    }
    if (symmetric() && (is_packed(j) || is_halved(j)))  // y_j was zero
      for (int q = pj.dimension - 1; q >= 0; --q)
        for (int i = q + 1; i < pj.dimension; ++i) yj[q] -= diagonal[q * pj.dimension + i] * yj[i];
    else if (rank_[j] == pj.dimension)
      kernels::solve_block_transposed(diagonal, row_exchange_.data() + first_row_[j], yj, pj.dimension);
    else
      solve_rank_deficient_transposed(diagonal, pj.dimension, rank_[j],
                                      row_exchange_.data() + first_row_[j], column_exchange_.data() + first_row_[j], yj);
  }
}

}  // namespace graphsolve
