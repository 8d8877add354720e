#pragma once

#include "simd/program.hpp"

namespace graphsolve::simd {

/// When a pivot of a symmetric block is as good as its node promises: sign * pivot > smallest * its reference.
struct Definite {
  double sign, smallest;
};

/// Numbers that eliminations read and write.
struct PackNumbers {
  double* values;        ///< of the matrix, and then of the factor
  double* scratch;       ///< Program::scratch_size()
  double* reference;     ///< per row in pivot order: amounts that pivots are compared with (Factorization)
  const int* first_row;  ///< per pivot: its first row in pivot order
  double saddle_shift;
};

/// What a pack's elimination works on.
struct PackJob {
  const Symbolic& symbolic;
  const Program& program;
  const PivotPack& pack;
  const PackNumbers& numbers;
  unsigned active;  ///< lanes to be done
};

/// What a pack's part of a solve works on.
struct PackSolve {
  const Shape& shape;
  const PivotPack& pack;
  const int* rows;
  const double* factor;
  double* x;
  unsigned active;
};

/// What a pack's part of a residual works on.
struct PackResidual {
  const Shape& shape;
  const PivotPack& pack;
  const int* rows;
  const double* matrix;  ///< of this pack, as it was before it was factored
  const double* x;
  double *residual, *magnitude;
  unsigned active;
};

/// A pivot of a block that may depend, below this part of what was added to it, is rounding error.
inline constexpr double dependent = 1e-11;

/// D = L U without exchanges and W = D^-1 U, in place; then the blocks between the couplings lose L W. Returns the lanes
/// whose block needs exchanges, or whose rows may depend: if there are any, nothing was written.
unsigned eliminate(const PackJob& job);
/// The same for a symmetric matrix of which the lower triangle is given, D = L D L^T; of blocks on the diagonal only
/// that triangle is updated. Returns the lanes whose block is not definite: if there are any, nothing was written.
/// `watch`: remember what is added to diagonals of blocks that may depend.
enum class Watch { no, yes };
unsigned eliminate_symmetric(const PackJob& job, const Definite& definite, Watch watch);

/// x_k := D^-1 x_k, then the coupled rows lose L x_k.
void solve_forward(const PackSolve& job);
/// x_k -= W x_coupled.
void solve_backward(const PackSolve& job);
/// Of the transposed matrix: the coupled rows lose W^T x_k.
void solve_forward_transposed(const PackSolve& job);
/// x_k := D^-T (x_k - L^T x_coupled).
void solve_backward_transposed(const PackSolve& job);
/// residual -= A x and magnitude += |A| |x| for the blocks of the pack.
void subtract_product(const PackResidual& job);

}  // namespace graphsolve::simd
