#pragma once

#include "graphsolve/factorization.hpp"

namespace graphsolve {

/// Signs of the eigenvalues of a symmetric block, from Bunch-Parlett pivoting (J. R. Bunch, B. N. Parlett, SIAM J.
/// Numer. Anal. 8, 1971): 1x1 and 2x2 pivots with complete pivoting. Exact up to rounding, where the signs of the
/// pivots of an LU with exchanges would say nothing: exchanges are not a congruence.
/// a: d x d, both triangles, overwritten; equilibrated first with 1 / sqrt(scale[i]), which changes no sign.
/// Stops after `rank` pivots and counts the rest as zero.
Inertia block_inertia(double* a, int d, const double* scale, int rank);

}  // namespace graphsolve
