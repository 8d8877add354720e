#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/status.hpp"

namespace graphsolve {

/// How a solution was come by, cheapest first.
enum class Rung {
  factorization,       ///< the chosen kind in the chosen order, refined
  reordered,           ///< stiff nodes and the block that failed eliminated later
  shifted,             ///< with a proximal shift on the saddle rows, taken out by refinement
  threshold_pivoting,  ///< by Eigen::SparseLU, or the solver that was given, refined
};
std::string_view name(Rung rung);

/// Solves A x = b or says why not: factorization and refinement first; where their backward error is not acceptable,
/// what Rung lists, one after the other. Never silent: every solve reports its rung, why it was taken and the backward
/// error of what it hands out. The first rung allocates nothing, but for a first solve of more columns than before, or
/// with rows left out; the others do, and each costs an analysis of its own the first time. One per thread.
class RobustSolver {
 public:
  /// x := solution of A x = b for a matrix in compressed columns, rows of each in ascending order, numbered as the graph's
  /// rows are; false where there is none. What it throws comes out of solve().
  struct Matrix {
    int rows = 0;
    std::span<const int> column_begin, row_index;
    std::span<const double> values;
  };
  using Fallback = std::function<bool(const Matrix& a, std::span<const double> b, std::span<double> x)>;

  struct Options {
    FactorizationKind kind = FactorizationKind::ldu;
    double acceptable = 1e-12;  ///< componentwise backward error
    int max_sweeps = 10;        ///< of refinement, on each rung
    Fallback fallback = {};     ///< in place of Eigen::SparseLU
    OrderingMethod ordering = OrderingMethod::minimum_fill;  ///< of the first rung; parse_ordering_method finds names
    std::vector<NodeId> sequence = {};  ///< that of OrderingMethod::user: every node once, repaired by user_ordering
  };
  /// Copies the graph. Throws std::invalid_argument when the ordering is not available in this build, when `sequence` is
  /// no permutation of the nodes, or is given and the ordering is not `user`.
  explicit RobustSolver(BlockGraph graph) : RobustSolver(std::move(graph), Options{}) {}
  RobustSolver(BlockGraph graph, Options options);
  ~RobustSolver();
  RobustSolver(RobustSolver&&) noexcept;
  RobustSolver& operator=(RobustSolver&&) noexcept;

  [[nodiscard]] const BlockGraph& graph() const;
  [[nodiscard]] const Ordering& ordering() const;
  [[nodiscard]] const Symbolic& symbolic() const;
  /// The numbers of the matrix, written through symbolic().block(); they stay as they are. The symmetric kinds read
  /// one triangle (factorization.hpp), so fill both.
  [[nodiscard]] std::span<double> values();
  [[nodiscard]] double& entry(const BlockHandle& handle, int row = 0, int column = 0) {
    return values()[handle.place(row, column)];
  }

  struct Report {
    /// solved; singular: no solution, or no rung found one and is_singular() says so; not_finite: of the input, or the solution
    /// is too large for doubles; stalled: none was accurate enough, although the matrix is not singular; also where the
    /// fallback that was given found nothing, or returned numbers that are not finite
    Status status = Status::solved;
    Rung rung = Rung::factorization;
    std::string why;            ///< what was wrong with the rungs before, or with the system; empty: nothing
    double backward_error = 0;  ///< componentwise, of the x handed out or of the best one found; infinity: none was
    Factorization::Outcome outcome;  ///< of the first rung
    int column = 0;    ///< of several right-hand sides the worst, which all the above is of: the first that is not
                       ///< solved, else the one of the highest rung, else of the largest error
    int unsolved = 0;  ///< right-hand sides whose status is not `solved`
  };
  /// Factors on the first rung. A solve does so by itself where values are not those that were factored.
  const Factorization::Outcome& factorize();
  /// x := A^-1 b. x stays as it was when the status is not `solved`; it may be b itself. Redundant rows: one solution, or `singular` with
  /// the names of the rows that b contradicts.
  Report solve(std::span<const double> b, std::span<double> x) { return solve(b, x, 1); }
  /// X := A^-1 B, both rows() x columns, column-major; each column is refined, climbs and is judged by itself. Columns that
  /// are not solved stay as they were. Throws std::invalid_argument when B or X has another size, or when they overlap
  /// without being the same.
  Report solve(std::span<const double> b, std::span<double> x, int columns);
  /// x := A^-T b; X := A^-T B. With the factors of A, refined against A^T. Where these will not do, or rows were left out,
  /// A^T is factored too (as much memory again, once per set of values) and climbs as A does: the outcome is its own then,
  /// `fallback` gets A^T, and what depends is named as columns. The symmetric kinds solve with A itself.
  Report solve_transposed(std::span<const double> b, std::span<double> x) { return solve_transposed(b, x, 1); }
  Report solve_transposed(std::span<const double> b, std::span<double> x, int columns);
  /// The factorization of the first rung, with its matrix: for diagnose().
  [[nodiscard]] const Factorization& factorization() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace graphsolve
