#pragma once

namespace graphsolve {

/// LU of a small block with complete pivoting on its equilibrated entries |a_ij| / sqrt(ref_i ref_j), stopped at
/// the first pivot below `threshold`. In place: L unit below the diagonal, reciprocals of the pivots on it, and
/// zeros on the diagonal from place `rank` on. Returns the rank.
/// rows[p], columns[p]: exchanged with place p at stage p.  reference: d magnitudes, permuted with the rows
/// during the work and restored.  scratch: 2 d doubles.
int factor_rank_revealing(double* a, int d, const double* reference, double threshold, int* rows, int* columns,
                          double* scratch);

/// X (d x n) := A^+ X: unknowns beyond the rank become zero, the equations beyond it are ignored.
void solve_rank_deficient(const double* a, int d, int rank, const int* rows, const int* columns, double* x, int n);

/// x := A^+T x
void solve_rank_deficient_transposed(const double* a, int d, int rank, const int* rows, const int* columns, double* x);

}  // namespace graphsolve
