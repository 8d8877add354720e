#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "graphsolve/symbolic.hpp"

namespace graphsolve {

/// What is known of the matrix, and so how it is factored. All kinds share one Symbolic and one layout.
///
/// The symmetric kinds read the lower triangle in elimination order: the lower triangle of each diagonal block and
/// the blocks (later, earlier). Writers may fill both triangles; packs leave the other one as it is, pivots that go by
/// themselves put L^-1 P^T there. Half the operations of ldu or less (Symbolic::Counts::symmetric_operations).
enum class FactorizationKind {
  ldu,       ///< structurally symmetric, any values; saddle systems as [H -J^T; J C]
  ldlt,      ///< symmetric, indefinite allowed; saddle systems as [H J^T; J -C]
  cholesky,  ///< symmetric positive definite, whatever the kinds of the nodes; without square roots
};

/// Signs of the eigenvalues of a symmetric matrix, which are those of D (Sylvester). zero: rows left out, and boosted
/// ones, whose sign is not known: they need not be zero. Each boost is a change of rank one with a sign, so that with
/// boosts `positive` and `negative` are the least that there can be (interlacing).
struct Inertia {
  int positive = 0;
  int negative = 0;
  int zero = 0;
  friend bool operator==(const Inertia&, const Inertia&) = default;
};

/// Block LDU of a structurally symmetric matrix with any values, A = (I + L) D (I + U), or block LDL^T of a symmetric
/// one, in the order of a Symbolic, pivoting inside the diagonal blocks only. Allocates in the constructor, nowhere
/// else. One per thread, for solves too, which write to memory of their own; the Symbolic is shared. Components are checked,
/// but by set_zero: std::invalid_argument where there is no such component, or one is named twice.
class Factorization {
 public:
  /// Values are zero. Throws std::invalid_argument for a null pointer, and where GRAPHSOLVE_SIMD holds a word that is none
  /// (simd/lanes.hpp).
  explicit Factorization(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind = FactorizationKind::ldu);
  ~Factorization();
  Factorization(Factorization&&) noexcept;
  Factorization& operator=(Factorization&&) noexcept;

  /// Another one of the same plan, kind and shift; without numbers, and keeping no matrix.
  [[nodiscard]] Factorization twin() const;

  [[nodiscard]] const Symbolic& symbolic() const;
  [[nodiscard]] FactorizationKind kind() const;

  /// The numbers of the matrix, symbolic().values_size() of them, written through BlockHandles. factorize() overwrites them.
  [[nodiscard]] std::span<double> values() { return values_; }
  /// An entry of a block.
  [[nodiscard]] double& entry(const BlockHandle& handle, int row = 0, int column = 0) {
    return values_[handle.place(row, column)];
  }
  /// What factorize() reads: of the symmetric kinds one triangle, the other is left as it is. The factor is gone.
  void set_zero();
  void set_zero(std::span<const int> components);
  /// From now on set_zero(components) may leave these blocks as they are: somebody assigns all their entries. Throws
  /// std::logic_error when one is named twice. Allocates now.
  void leave_unzeroed(std::span<const BlockHandle> blocks);

  /// Makes room for a copy of the matrix, which refine() needs; allocates now.
  void allow_refinement();
  /// Whether the next factorizations keep that copy, which they throw std::logic_error for where there is no room. Off
  /// at first.
  void keep_matrix(bool keep);

  /// The kept copy, laid out like values(); empty before the first. The symmetric kinds fill both triangles of it.
  [[nodiscard]] std::span<const double> matrix() const;

  /// Proximal shift: every saddle row gets this part of what its neighbours added to its diagonal on top, with the
  /// same sign. Bounds what rounding can do where neighbours are very stiff; refine() and Newton iterations take it
  /// out again. 0 at first: the matrix is factored as it is; usual are 1e-12 to 1e-8. No effect on cholesky.
  /// leave_out: in ldu, rows that may depend on others (Symbolic::may_depend) are left out instead, as without a shift,
  /// where their pivot is below this part of what was added, and no more than a tenth of them couples to later blocks.
  /// For iterations that evaluate such rows anew: a shift of 1e-12 makes 1e12 times what is left of the residual along a
  /// dependence a multiplier, which nothing takes back. Usual is 1e-8; 0: none.
  void set_saddle_shift(double relative, double leave_out = 0);

  struct Outcome {
    int dropped_rows = 0;         ///< dependent rows found inside saddle blocks and left out
    int boosts = 0;               ///< rows of no size of their own that got one, see factorize()
    int first_bad_pivot = -1;     ///< pivot with NaN, infinity or a singular block that cannot be left out; cholesky:
                                  ///< one that is not positive definite. -1: none
    Inertia inertia;              ///< ldlt, cholesky; zeros for ldu
    double growth = 0;            ///< max |entry met in the elimination| / max |entry of the matrix|; measured when
                                  ///< the matrix is kept, else 0
    std::int64_t operations = 0;  ///< multiplications and divisions done
    int pivots = 0;               ///< pivots factored
    [[nodiscard]] bool ok() const { return first_bad_pivot < 0; }
  };
  /// Factors all components, or one. Dependent rows of saddle blocks that the eligibility rule does not vouch for
  /// (pivot below 1e-11 of what was added to the block) are left out: their unknowns become zero. Where such rows still
  /// couple to later pivots they are not dependent, only early, and are boosted: 1e-7 of the row's size is added to the
  /// diagonal (ldu: only when the matrix is kept, else the block is singular). ldlt boosts any other pivot below 1e-13
  /// of its row's size, with the sign of its node (saddle negative, others positive). After boosts the factors are
  /// those of a matrix nearby: call refine().
  [[nodiscard]] Outcome factorize();
  [[nodiscard]] Outcome factorize(int component);
  /// Several components, side by side; one named twice throws std::invalid_argument. Returns outcomes by component,
  /// valid until the next factorization; those of the others are of earlier calls. The numbers of a component do not
  /// depend on which others are factored with it, nor on how many equal ones there are (blocks of up to 6 rows).
  std::span<const Outcome> factorize(std::span<const int> components);

  /// factorize() and solve(x) in one pass: each pivot goes through the first half of the solve while its factor is at
  /// hand. The same bits where packs are used, else equal to rounding; where the outcome is not ok, x means nothing.
  [[nodiscard]] Outcome factorize_and_solve(std::span<double> x);
  /// The rows of the other components are not touched.
  std::span<const Outcome> factorize_and_solve(std::span<const int> components, std::span<double> x);

  /// Makes room for refactorize(), and for the kept matrix; allocates now. Pivots go one by one from now on, which is
  /// faster in a Symbolic without packs.
  void allow_refactorization();
  /// An entry of a block of the kept matrix, for new numbers before refactorize(). Throws std::logic_error before there
  /// is one.
  [[nodiscard]] double& kept_entry(const BlockHandle& handle, int row = 0, int column = 0);
  /// Factors again after some blocks of the kept matrix changed: the diagonal blocks of the nodes in `changed`, and
  /// couplings with both ends in it. Only these nodes and their ancestors in the elimination tree are done again
  /// (Outcome::pivots), from the kept matrix, after the updates of their other descendants were applied anew: the same
  /// bits as factorize() of the whole. Cost: the updates that arrive at the redone pivots, and their own elimination;
  /// nothing that grows with the rest of the graph. Needs allow_refactorization() and a factorize() of all components
  /// with the matrix kept; after a failure everything is done again. Inertia, dropped rows and boosts are of the whole
  /// matrix; growth is of the redone pivots, over the largest entry that the matrix has had since it was kept. Throws
  /// std::logic_error where no whole matrix was kept. Allocates nothing.
  [[nodiscard]] Outcome refactorize(std::span<const NodeId> changed);

  /// x := A^-1 x, rows in the user's numbering; or only the rows of one component.
  void solve(std::span<double> x) const { solve(x, 1); }
  void solve_component(std::span<double> x, int component) const;
  void solve_components(std::span<double> x, std::span<const int> components) const;
  /// X := A^-1 X, X being rows() x columns, column-major. Throws std::invalid_argument when x has another size, as all
  /// of these do std::logic_error where one of their components has no factor: none was made, or it failed, or set_zero()
  /// came after it.
  void solve(std::span<double> x, int columns) const;
  /// x := A^-T x; X := A^-T X.
  void solve_transposed(std::span<double> x) const { solve_transposed(x, 1); }
  void solve_transposed(std::span<double> x, int columns) const;

  struct Refinement {
    int sweeps = 0;
    double backward_error = 0;  ///< componentwise: max |A x - b| / (|A| |x| + |b|)
  };
  /// x := refined solution of A x = b, until the componentwise backward error is <= 4 eps or no longer falls, in twice
  /// the precision where it must be. b stays. Throws std::logic_error where the last factorization of a component kept no
  /// matrix, std::invalid_argument where b and x overlap.
  Refinement refine(std::span<const double> b, std::span<double> x, int max_sweeps = 3);
  /// Several components, each until its own error is good; returns the most sweeps and the largest error.
  Refinement refine(std::span<const double> b, std::span<double> x, std::span<const int> components, int max_sweeps);
  /// The same of A^T x = b, after solve_transposed.
  Refinement refine_transposed(std::span<const double> b, std::span<double> x, int max_sweeps = 3);

  /// Rows left out by the last factorize: node and row within it.
  struct DroppedRow {
    NodeId node;
    int row;
  };
  [[nodiscard]] std::span<const DroppedRow> dropped_rows() const;
  /// Left null vector that goes with a dropped row: y with y^T A = 0, y = 1 at that row. Its nonzero blocks
  /// name the group of dependent rows. y has rows() entries; another length, and a row that was not left out, throw
  /// std::invalid_argument. Allocates nothing.
  void dependency(const DroppedRow& dropped, std::span<double> y) const;

 private:
  class Impl;

  std::unique_ptr<Impl> impl_;
  std::span<double> values_;  ///< of impl_
};

}  // namespace graphsolve
