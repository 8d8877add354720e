#pragma once

#include "simd/program.hpp"

namespace graphsolve::simd {

/// What a pack's elimination works on.
struct PackJob {
  const Symbolic& symbolic;
  const Shape& shape;
  const PivotPack& pack;
  double* values;       ///< of the matrix, block after block; pivots' own blocks are read, targets written
  double* factor;       ///< of this pack
  double* scratch;
  double saddle_shift;
  unsigned active;      ///< lanes to be done
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

/// D = L U without exchanges and W = D^-1 U; then the blocks between the couplings lose L W. Returns the lanes whose
/// block needs exchanges: nothing was written for them, and they have to be done one by one.
unsigned eliminate(const PackJob& job);
/// x_k := D^-1 x_k, then the coupled rows lose L x_k.
void solve_forward(const PackSolve& job);
/// x_k -= W x_coupled.
void solve_backward(const PackSolve& job);

}  // namespace graphsolve::simd
