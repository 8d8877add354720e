#pragma once

#include <memory>
#include <span>
#include <vector>

#include "graphsolve/symbolic.hpp"

namespace graphsolve {

/// Block LDU of a structurally symmetric matrix with any values: A = (I + L) D (I + U) in the order of a
/// Symbolic, pivoting inside the diagonal blocks only. Allocates in the constructor, nowhere else.
/// One per thread; the Symbolic is shared.
class Factorization {
 public:
  explicit Factorization(std::shared_ptr<const Symbolic> symbolic);

  [[nodiscard]] const Symbolic& symbolic() const { return *symbolic_; }

  /// The numbers of the matrix, written through BlockHandles. factorize() overwrites them.
  [[nodiscard]] std::span<double> values() { return values_; }
  [[nodiscard]] double* block(const BlockHandle& handle) { return values_.data() + handle.offset; }
  void set_zero();
  void set_zero(int component);

  /// Makes room for a copy of the matrix, which refine() needs; allocates now.
  void allow_refinement();
  /// Whether the next factorizations keep that copy. Off at first.
  void keep_matrix(bool keep) { keep_matrix_ = keep; }

  /// Proximal shift: every saddle row gets this part of what its neighbours added to its diagonal on top, with the
  /// same sign. Bounds what rounding can do where neighbours are very stiff; refine() and Newton iterations take it
  /// out again. 0 at first: the matrix is factored as it is.
  void set_saddle_shift(double relative) { saddle_shift_ = relative; }

  struct Outcome {
    int dropped_rows = 0;        ///< dependent rows found inside saddle blocks and left out
    int first_bad_pivot = -1;    ///< pivot with NaN, infinity or a singular block that cannot be left out; -1: none
    [[nodiscard]] bool ok() const { return first_bad_pivot < 0; }
  };
  /// Factors all components, or one. Dependent rows of saddle blocks that the eligibility rule does not vouch for
  /// (pivot below 1e-11 of what was added to the block) are left out: their unknowns become zero.
  [[nodiscard]] Outcome factorize();
  [[nodiscard]] Outcome factorize(int component);

  /// x := A^-1 x, rows in the user's numbering.
  void solve(std::span<double> x) const;
  void solve(std::span<double> x, int component) const;
  /// x := A^-T x.
  void solve_transposed(std::span<double> x) const;

  struct Refinement {
    int sweeps = 0;
    double backward_error = 0;  ///< componentwise: max |A x - b| / (|A| |x| + |b|)
  };
  /// x := refined solution of A x = b, until the componentwise backward error is <= 4 eps rows or no longer
  /// halves. Needs the kept matrix. b is not changed.
  Refinement refine(std::span<const double> b, std::span<double> x, int max_sweeps = 3);
  Refinement refine(std::span<const double> b, std::span<double> x, int component, int max_sweeps);

  /// Rows left out by the last factorize: node and row within it.
  struct DroppedRow {
    NodeId node;
    int row;
  };
  [[nodiscard]] std::span<const DroppedRow> dropped_rows() const { return dropped_; }
  /// Left null vector that goes with a dropped row: y with y^T A = 0, y = 1 at that row. Its nonzero blocks
  /// name the group of dependent rows. Allocates nothing; y has rows() entries.
  void dependency(const DroppedRow& dropped, std::span<double> y) const;

 private:
  void factorize_range(int begin, int end, Outcome& outcome);
  bool factorize_pivot(int k, Outcome& outcome);
  bool couples_later(int k);
  void eliminate(int k);
  void solve_diagonal(int k, double* x, int columns) const;
  void solve_range(std::span<double> x, int begin, int end) const;
  Refinement refine_range(std::span<const double> b, std::span<double> x, int begin, int end, int max_sweeps);
  double residual(std::span<const double> b, std::span<const double> x, int begin, int end);
  template <class F>
  void each_row(int begin, int end, F&& f) const;

  std::shared_ptr<const Symbolic> symbolic_;
  std::vector<double> values_, matrix_;
  std::vector<int> row_exchange_;     ///< per row in pivot order: the row that took this place in its block
  std::vector<int> column_exchange_;  ///< same for columns; used only where rows were dropped
  std::vector<int> rank_;             ///< per pivot
  std::vector<int> first_row_;        ///< per pivot: first row in pivot order
  std::vector<double> reference_;     ///< per row in pivot order: largest amount, signed, added to a saddle diagonal
  std::vector<double> work_;          ///< of the largest block; solve_range needs none of it
  std::vector<double> residual_, magnitude_, correction_;
  std::vector<DroppedRow> dropped_;
  bool keep_matrix_ = false;
  double saddle_shift_ = 0;
};

}  // namespace graphsolve
