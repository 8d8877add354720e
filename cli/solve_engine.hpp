#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "matrix_source.hpp"

/// What `solve` does with a matrix: a chain of factorizations, each tried when the one before was not good enough.
namespace cli {

/// A x = b, or A^T x = b with the factors of A.
enum class System { plain, transposed };

struct SolveRequest {
  graphsolve::OrderingMethod ordering = graphsolve::OrderingMethod::minimum_fill;
  std::optional<graphsolve::FactorizationKind> kind;  ///< none: by the matrix
  int columns = 1;                                    ///< of the right-hand side
  System system = System::plain;
};

/// One factorization that was tried.
struct Attempt {
  std::string method;  ///< "cholesky", "ldlt", "ldu", "robust: reordered" (RobustSolver and its rung)
  std::string trouble = {};  ///< why it was not the last; empty when it was good
  graphsolve::Factorization::Outcome outcome = {};
  std::string reason = {};  ///< of a robust solve: why it took its rung
  int sweeps = 0;        ///< of refinement, the most over the columns
  graphsolve::BackwardError error = {};  ///< the worst over the columns
  double setup_seconds = 0, factor_seconds = 0, solve_seconds = 0;  ///< CPU; solve with refinement, all columns
};

struct SolveResult {
  std::vector<double> x;  ///< rows x columns, of the last attempt
  std::vector<Attempt> attempts;
  std::vector<std::string> diagnosis;  ///< sentences that name blocks, when the matrix is singular or no attempt was good
  double fill_ratio = 1;
  bool good = false;      ///< the last attempt reached the bar
  bool singular = false;  ///< found to be; x, if good, is one solution of many
};

/// Largest normwise backward error that counts as solved.
constexpr double solved_below = 1e-12;

/// Throws std::invalid_argument where fill would take more memory than the machine has.
SolveResult solve_system(const MatrixSource& source, std::span<const double> b, const SolveRequest& request);

}  // namespace cli
