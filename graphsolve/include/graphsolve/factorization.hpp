#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "graphsolve/symbolic.hpp"

namespace graphsolve {

namespace kernels {
struct Table;
}

namespace simd {
class PackedFactor;
struct PivotPack;
struct Definite;
struct PackData;
}  // namespace simd

/// Whether equal pivots are eliminated eight at a time (SIMD, without exchanges of rows where that is sound) or all of
/// them one by one.
enum class Packs { on, off };

/// What is known of the matrix, and so how it is factored. All kinds share one Symbolic and one layout.
///
/// The symmetric kinds read the lower triangle in elimination order: the lower triangle of each diagonal block and
/// the blocks (later, earlier). Writers may fill both triangles; the other panel becomes W = D^-1 P^T. About half the
/// operations of ldu (Symbolic::Counts::symmetric_operations).
enum class FactorizationKind {
  ldu,       ///< structurally symmetric, any values; saddle systems as [H -J^T; J C]
  ldlt,      ///< symmetric, indefinite allowed; saddle systems as [H J^T; J -C]
  cholesky,  ///< symmetric positive definite, whatever the kinds of the nodes; without square roots
};

/// Signs of the eigenvalues of a symmetric matrix, which are those of D (Sylvester). zero: rows left out or boosted.
struct Inertia {
  int positive = 0;
  int negative = 0;
  int zero = 0;
  friend bool operator==(const Inertia&, const Inertia&) = default;
};

/// Block LDU of a structurally symmetric matrix with any values, A = (I + L) D (I + U), or block LDL^T of a symmetric
/// one, in the order of a Symbolic, pivoting inside the diagonal blocks only. Allocates in the constructor, nowhere
/// else. One per thread; the Symbolic is shared.
class Factorization {
 public:
  explicit Factorization(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind = FactorizationKind::ldu);
  ~Factorization();
  Factorization(Factorization&&) noexcept;
  Factorization& operator=(Factorization&&) noexcept;

  /// Another one of the same plan, kind, shift and use of packs; without numbers, and keeping no matrix.
  [[nodiscard]] Factorization twin() const;

  /// From the next factorization on; `on` at first. Without effect where refactorize() is allowed.
  void use_packs(Packs packs) { packs_ = packs; }

  [[nodiscard]] const Symbolic& symbolic() const { return *symbolic_; }
  [[nodiscard]] FactorizationKind kind() const { return kind_; }

  /// The numbers of the matrix, written through BlockHandles. factorize() overwrites them.
  [[nodiscard]] std::span<double> values() { return values_; }
  [[nodiscard]] double* block(const BlockHandle& handle) { return values_.data() + handle.offset; }
  void set_zero();
  void set_zero(int component);

  /// Makes room for a copy of the matrix, which refine() needs; allocates now.
  void allow_refinement();
  /// Whether the next factorizations keep that copy. Off at first.
  void keep_matrix(bool keep) { keep_matrix_ = keep; }

  /// The kept copy, laid out like values(). The symmetric kinds fill both triangles of it.
  [[nodiscard]] std::span<const double> matrix() const { return matrix_; }

  /// Proximal shift: every saddle row gets this part of what its neighbours added to its diagonal on top, with the
  /// same sign. Bounds what rounding can do where neighbours are very stiff; refine() and Newton iterations take it
  /// out again. 0 at first: the matrix is factored as it is. No effect on cholesky.
  void set_saddle_shift(double relative) { saddle_shift_ = relative; }

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
  /// Several components, side by side; outcomes by component, others are not touched. The numbers of a component do not
  /// depend on which others are factored with it.
  void factorize(std::span<const int> components, std::span<Outcome> outcomes);

  /// Makes room for refactorize(), and for the kept matrix; allocates now. Pivots go one by one from now on,
  /// whatever use_packs() says.
  void allow_refactorization();
  /// A block of the kept matrix, for new numbers before refactorize().
  [[nodiscard]] double* kept_block(const BlockHandle& handle) { return matrix_.data() + handle.offset; }
  /// Factors again after some blocks of the kept matrix changed: the diagonal blocks of the nodes in `changed`, and
  /// couplings with both ends in it. Only these nodes and their ancestors in the elimination tree are done again
  /// (Outcome::pivots), from the kept matrix, after the updates of their other descendants were applied anew: the same
  /// bits as factorize() of the whole. Cost: the updates that arrive at the redone pivots, and their own elimination;
  /// nothing that grows with the rest of the graph. Needs allow_refactorization() and a factorize() of all components
  /// with the matrix kept; after a failure everything is done again. Inertia, dropped rows and boosts are of the whole
  /// matrix, growth of the redone pivots. Allocates nothing.
  [[nodiscard]] Outcome refactorize(std::span<const NodeId> changed);

  /// x := A^-1 x, rows in the user's numbering; or only the rows of one component.
  void solve(std::span<double> x) const { solve(x, 1); }
  void solve_component(std::span<double> x, int component) const;
  void solve_components(std::span<double> x, std::span<const int> components) const;
  /// X := A^-1 X, X being rows() x columns, column-major. Throws std::invalid_argument when x has another size.
  void solve(std::span<double> x, int columns) const;
  /// x := A^-T x; X := A^-T X.
  void solve_transposed(std::span<double> x) const { solve_transposed(x, 1); }
  void solve_transposed(std::span<double> x, int columns) const;

  struct Refinement {
    int sweeps = 0;
    double backward_error = 0;  ///< componentwise: max |A x - b| / (|A| |x| + |b|)
  };
  /// x := refined solution of A x = b, until the componentwise backward error is <= 4 eps or no longer falls, the
  /// residual being taken in twice the precision where it stops falling in the plain one. b is not changed. Needs the kept matrix; throws std::logic_error where none was allowed.
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
  [[nodiscard]] bool symmetric() const { return kind_ != FactorizationKind::ldu; }
  [[nodiscard]] bool tracks_reference(int k) const;
  void keep(int begin, int end);
  void start_reference(int k);
  void start_panel_reference(int k);
  void prepare_range(int begin, int end);
  void factorize_range(int begin, int end, Outcome& outcome);
  [[nodiscard]] bool in_packs() const;
  enum class Count { each, together };  ///< by component, or all in the first outcome
  void factorize_steps(std::span<Outcome> outcomes, Count count);
  void eliminate_alone(int k, Outcome& outcome);
  void begin_alone(int k, Outcome& outcome);
  void eliminate_group(int begin, int size, Outcome& outcome);
  void update_member(int begin, int k, const double* l, int depth);
  void update_after(int begin, int size, const double* l, const double* spread_w);
  void alone_if_active(int k, std::span<Outcome> outcomes);
  void eliminate_together(int number, unsigned active, std::span<Outcome> outcomes, Count count, const simd::PackData& data);
  void count_pack(const simd::PivotPack& pack, unsigned active, std::span<Outcome> outcomes, Count count);
  void set_active(std::span<const int> components) const;
  void set_all_active() const;
  [[nodiscard]] unsigned active_lanes(std::span<const int> pivots, unsigned used) const;
  bool factorize_pivot(int k, Outcome& outcome);
  bool factorize_one(int k, Outcome& outcome);
  void restore(int k);
  void collect_redone(std::span<const NodeId> changed);
  void forget_redone(Outcome& outcome);
  bool factorize_pivot_any(int k, Outcome& outcome);
  [[nodiscard]] simd::Definite definite(bool saddle, bool may_depend) const;
  bool factorize_pivot_symmetric(int k, Outcome& outcome);
  bool factorize_pivot_indefinite(int k, Outcome& outcome);
  bool boost(int k, double* block);
  void shift_pivot(int k);
  [[nodiscard]] int original_row(int k, int place) const;
  void drop_rows(int k, Outcome& outcome);
  bool couples_later(int k);
  [[nodiscard]] double largest_of(int k) const;
  void transpose_panel(int k, double* values) const;
  void mirror_matrix(int k);
  void eliminate(int k, Outcome& outcome);
  void update(int k, int from, Outcome& outcome);
  void remember_diagonal(const double* block, int d);
  void note_added(int k, const double* block, int d);
  [[nodiscard]] std::int64_t updated_scalars(std::int64_t couplings, std::int64_t rows) const;
  void solve_diagonal(int k, double* x, int columns, std::ptrdiff_t stride) const;
  void solve_range(double* x, int columns, int begin, int end) const;
  void solve_pivots(double* x, int columns, int begin, int end) const;
  void solve_steps(double* x) const;
  void solve_forward(int k, double* x, int columns) const;
  void solve_backward(int k, double* x, int columns) const;
  struct PivotFactor {
    const double *diagonal, *lower, *upper;
  };
  [[nodiscard]] PivotFactor factor_of(int k, double* buffer) const;
  void solve_column_transposed(double* x) const;
  void check_size(std::span<const double> x, int columns) const;
  Refinement refine_range(std::span<const double> b, std::span<double> x, int begin, int end, int max_sweeps);
  enum class Precision { plain, twice };
  double residual(std::span<const double> b, std::span<const double> x, int begin, int end, Precision precision);
  template <class F>
  void each_row(int begin, int end, F&& f) const;

  std::shared_ptr<const Symbolic> symbolic_;
  FactorizationKind kind_;
  const kernels::Table* kernels_;     ///< of the instruction set in use when this was made
  std::vector<double> values_, matrix_;
  std::vector<int> row_exchange_;     ///< per row in pivot order: the row that took this place in its block
  std::vector<int> column_exchange_;  ///< same for columns; used only where rows were dropped
  std::vector<int> rank_;             ///< per pivot
  std::vector<int> first_row_;        ///< per pivot: first row in pivot order
  std::vector<int> uncertain_;        ///< pivots that may depend, ascending
  std::vector<double> reference_;     ///< per row in pivot order: largest amount, signed, added to a saddle diagonal;
                                      ///< in the symmetric kinds |diagonal of the matrix| for other nodes
  std::vector<double> panel_reference_;  ///< where dependence is looked for: largest entry of the row right of the block
  std::vector<double> work_;          ///< two of the largest block and 3 of its rows; solving needs none of it
  std::vector<char> equal_;           ///< per pivot: equal_couplings
  std::vector<char> group_;           ///< per pivot that is not inside a group: how many it begins, see group_size
  std::vector<double> spread_;        ///< for the update of equal couplings
  std::vector<double> residual_, residual_low_, magnitude_, correction_, best_;
  std::vector<DroppedRow> dropped_;
  // For refactorize().
  struct Share {
    Inertia inertia;
    int dropped_rows = 0, boosts = 0;
  };
  enum class Mark : char { none, redo, apply };
  std::vector<int> earlier_begin_, earlier_;  ///< per pivot: earlier pivots coupled to it in the factor
  std::vector<Share> share_;                  ///< per pivot: its part of the last outcome
  std::vector<Mark> mark_;
  std::vector<int> queue_;
  Outcome total_;
  bool complete_ = false;
  std::unique_ptr<simd::PackedFactor> packed_;  ///< null where the program has no packs
  std::vector<Outcome> outcomes_;     ///< by component
  mutable std::vector<char> active_;  ///< by component: taking part in this call
  mutable bool all_active_ = false;
  Packs packs_ = Packs::on;
  bool any_packed_ = false;           ///< may any pivot's factor be in a pack?
  bool keep_matrix_ = false;
  double largest_entry_ = 0;          ///< of the kept part of the matrix
  double saddle_shift_ = 0;
};

}  // namespace graphsolve
