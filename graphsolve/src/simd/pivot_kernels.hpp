#pragma once

#include <array>
#include <span>

#include "simd/program.hpp"

namespace graphsolve::simd {

/// What the pivots of a block are compared with: with amounts in PackNumbers::reference, with the diagonal as it is where
/// no other pivot changes it, or with nothing.
enum class Compared { with_reference, with_own, with_nothing };

/// When a pivot of a symmetric block is as good as its node promises: sign * pivot > smallest * its reference.
struct Definite {
  double sign, smallest;
  Compared compared = Compared::with_reference;
};

/// Numbers that eliminations read and write.
struct PackNumbers {
  double* values;        ///< of the matrix, and then of the factor
  double* scratch;       ///< Program::scratch_size()
  double* reference;     ///< in lanes: amounts that pivots are compared with (Factorization)
  double saddle_shift;
  double suspicious;  ///< below this part of what was added, blocks that may depend go alone; 0: they are shifted
};

/// What a pack's elimination works on.
struct PackJob {
  const Program& program;
  const PivotPack& pack;
  const PackNumbers& numbers;
  unsigned active;  ///< lanes to be done
};

/// What an elimination left: of an LDU D = L U in place, the panel below as it was and W = D^-1 U; of an LDL^T the lower
/// triangle of L with the reciprocals of D, and P (L D L^T)^-1 L = P L^-T D^-1 in place of the panel P below.
enum class Form { ldu, ldlt };

/// What a pack's part of a solve works on.
struct PackSolve {
  const Program& program;
  const PivotPack& pack;
  const double* factor;  ///< values of all pivots
  double* x;       ///< in lanes
  double* result;  ///< the user's vector, which gets what is final; of the backward half only
  unsigned active;
  Form form;
};

/// What a pack's part of a residual works on.
struct PackResidual {
  const Program& program;
  const PivotPack& pack;
  const double* matrix;  ///< values of all pivots, as they were before they were factored
  const double* x;
  double *residual, *magnitude;
  unsigned active;
};

/// When what is added to diagonals of blocks that may depend is remembered.
enum class Watch { no, yes };

/// D = L U without exchanges and W = D^-1 U, in place; then the blocks between the couplings lose L W. Returns the lanes
/// whose block needs exchanges, or whose rows may depend: if there are any, nothing was written.
using Eliminate = unsigned (*)(const PackJob&);
/// The same for a symmetric matrix of which the lower triangle is given, in Form::ldlt; nothing else is read or written.
/// Returns the lanes whose block is not definite: if there are any, nothing was written.
using EliminateSymmetric = unsigned (*)(const PackJob&, const Definite&, Watch);
using Solve = void (*)(const PackSolve&);
using Residual = void (*)(const PackResidual&);

template <class Function>
using ByKind = std::array<Function, pack_kinds>;  ///< by PivotPack::kind

struct Eliminations {
  ByKind<Eliminate> any;
  ByKind<EliminateSymmetric> symmetric;
};

struct Solves {
  /// x_k := D^-1 x_k; in Form::ldlt L^-1 x_k, which is kept times D^-1: the second half need not read D. Then the coupled
  /// rows lose what lies below times x_k.
  ByKind<Solve> forward;
  /// x_k -= W x_coupled, which is final. Form::ldu.
  ByKind<Solve> backward;
  /// Of the transposed matrix: the coupled rows lose W^T x_k. Form::ldu.
  ByKind<Solve> forward_transposed;
  /// x_k := D^-T (x_k - L^T x_coupled), which is final; in Form::ldlt, where it is the second half of a solve,
  /// L^-T (x_k - P^T x_coupled).
  ByKind<Solve> backward_transposed;
  /// residual -= A x and magnitude += |A| |x| for the blocks of the pack.
  ByKind<Residual> residual;
};

/// For the instruction set in use (instruction_set()). They live as long as the process.
const Eliminations& eliminations();
const Solves& solves();

/// The rows of the packs among these steps, from the user's vector to the one in lanes.
void to_lanes(const Program& program, std::span<const Program::Step> steps, const double* x, double* to);

}  // namespace graphsolve::simd
