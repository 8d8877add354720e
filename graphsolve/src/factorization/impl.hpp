#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "graphsolve/aligned.hpp"
#include "graphsolve/factorization.hpp"
#include "factorization/kernels.hpp"
#include "factorization/participants.hpp"
#include "factorization/references.hpp"
#include "factorization/refiner.hpp"
#include "factorization/side.hpp"
#include "factorization/standing.hpp"
#include "simd/pivot_kernels.hpp"

namespace graphsolve {

/// What a factorization is made of, from room.cpp, which sets memory aside, over zero.cpp, before the first pivot, to
/// steps.cpp, which goes along the program: packs, and pivots by themselves (pivots.cpp, symmetric.cpp, update.cpp, group.cpp;
/// again.cpp for some of them once more). Then solve.cpp, dependency.cpp. Who takes part, what has become of every component
/// (Standing), what pivots are compared with, and refinement are objects of their own; thresholds.hpp says what decides.
class Factorization::Impl {
 public:
  Impl(std::shared_ptr<const Symbolic> symbolic, FactorizationKind kind);

  // As in Factorization.
  [[nodiscard]] const std::shared_ptr<const Symbolic>& symbolic() const { return symbolic_; }
  [[nodiscard]] FactorizationKind kind() const { return kind_; }
  [[nodiscard]] std::span<double> values() { return values_; }
  void set_zero();
  void set_zero(std::span<const int> components);
  void leave_unzeroed(std::span<const BlockHandle> blocks);
  void allow_refinement();
  void keep_matrix(bool keep) { keep_matrix_ = keep; }
  [[nodiscard]] std::span<const double> matrix() const { return matrix_; }
  void set_saddle_shift(double relative, double leave_out) {
    if (relative != saddle_shift_ || leave_out != leave_out_) complete_ = false;
    saddle_shift_ = relative;
    leave_out_ = leave_out;
    references_.set_shifted(relative != 0);
  }
  [[nodiscard]] double saddle_shift() const { return saddle_shift_; }
  [[nodiscard]] double leave_out() const { return leave_out_; }
  /// Are rows of this block left out where they depend on others, and shifted only else?
  [[nodiscard]] bool leaves_out(int k) const {
    return saddle_shift_ != 0 && leave_out_ != 0 && !symmetric() && symbolic_->pivot(k).may_depend;
  }
  /// Below this part of what was added, a pivot of a block that may depend is looked at again: 0 where all are shifted. A
  /// small pivot can hide in two that are small, where no columns are exchanged.
  [[nodiscard]] double suspicious_pivot() const;
  [[nodiscard]] Outcome factorize();
  std::span<const Outcome> factorize(std::span<const int> components);
  [[nodiscard]] Outcome factorize_and_solve(std::span<double> x);
  std::span<const Outcome> factorize_and_solve(std::span<const int> components, std::span<double> x);
  void allow_refactorization();
  [[nodiscard]] double& kept_entry(std::size_t place) {
    if (matrix_.empty()) throw std::logic_error("kept_entry: a factorize() that keeps the matrix comes first");
    return matrix_[place];
  }
  [[nodiscard]] Outcome refactorize(std::span<const NodeId> changed);
  void solve_components(std::span<double> x, std::span<const int> components) const;
  void solve(std::span<double> x, int columns) const;
  void solve_transposed(std::span<double> x, int columns) const;
  Refinement refine(std::span<const double> b, std::span<double> x, int max_sweeps);
  Refinement refine(std::span<const double> b, std::span<double> x, std::span<const int> components, int max_sweeps) {
    return refine(b, x, components, max_sweeps, Side::plain);
  }
  Refinement refine_transposed(std::span<const double> b, std::span<double> x, int max_sweeps);
  [[nodiscard]] std::span<const DroppedRow> dropped_rows() const { return dropped_; }
  void dependency(const DroppedRow& dropped, std::span<double> y) const;

 private:
  [[nodiscard]] bool symmetric() const { return kind_ != FactorizationKind::ldu; }
  /// Of one solve: the vector at work, in lanes where there are packs, and the user's, which gets the result.
  struct Vectors {
    double *x, *result;
  };
  enum class Count { each, together };  ///< by component, or all in the first outcome
  // Before the elimination.
  void make_room_for_packs();
  void keep();
  // One pivot by itself.
  struct PivotBlocks {
    double *diagonal, *lower, *upper;
  };
  struct PivotFactor {
    const double *diagonal, *lower, *upper;
  };
  [[nodiscard]] PivotBlocks open(int k);
  void close(int k, const PivotBlocks& blocks);
  void gather(int k, double* to) const;
  [[nodiscard]] PivotFactor factor_of(int k, double* buffer) const;
  void eliminate_from(int k, Outcome& outcome);
  void eliminate_alone(int k, Outcome& outcome);
  void begin_alone(int k, Outcome& outcome);
  void eliminate_group(int begin, int size, Outcome& outcome);
  void gather_member(int begin, int r, int size, double* l);
  void update_member(int begin, int k, const double* l, int depth);
  void update_after(int begin, int size, const double* l, const double* spread_w);
  void alone_if_active(int k);
  bool factorize_pivot(int k, const PivotBlocks& blocks, Outcome& outcome);
  bool factorize_one(int k, const PivotBlocks& blocks, Outcome& outcome);
  bool factorize_pivot_any(int k, const PivotBlocks& blocks, Outcome& outcome);
  bool factorize_suspicious(int k, const PivotBlocks& blocks, const double* reference, Outcome& outcome);
  [[nodiscard]] simd::Definite definite(int k) const;
  bool factorize_pivot_symmetric(int k, const PivotBlocks& blocks, Outcome& outcome);
  bool factorize_pivot_indefinite(int k, const PivotBlocks& blocks, Outcome& outcome);
  bool boost(int k, const PivotBlocks& blocks, double* block);
  void shift_pivot(int k, double* diagonal);
  [[nodiscard]] int original_row(int k, int place) const;
  void drop_rows(int k, Outcome& outcome);
  bool couples_later(int k, const PivotBlocks& blocks);
  [[nodiscard]] double largest_of(int k) const;
  void transpose_panel(int k, const PivotBlocks& blocks) const;
  void halve_panel(int k, const PivotBlocks& blocks) const;
  void finish_panel(int k, const PivotBlocks& blocks) const;
  [[nodiscard]] bool may_be_spread(int k) const;
  void spread_panel(int k, const PivotBlocks& blocks, int from, double* l, std::ptrdiff_t next, int begin, int depth);
  [[nodiscard]] std::int64_t panel_operations(int k) const;
  [[nodiscard]] bool is_halved(int pivot) const { return symmetric() && halved_[pivot] != Halved::no; }
  [[nodiscard]] bool is_half_kept(int pivot) const { return symmetric() && halved_[pivot] == Halved::and_spread; }
  void mirror_matrix(int k);
  void eliminate(int k, const PivotBlocks& blocks, Outcome& outcome);
  void update(int k, const PivotBlocks& blocks, int from, Outcome& outcome);
  void remember_diagonal(const double* block, int d, int stride = 1);
  void note_added(int k, const double* block, int d, int stride = 1);
  [[nodiscard]] std::int64_t updated_scalars(std::int64_t couplings, std::int64_t rows) const;
  std::int64_t update_row_scattered(int k, int i, int from, const double* lower, const double* upper);
  // Along the program. all: the outcome of whatever takes part, where one is enough.
  [[nodiscard]] bool in_packs() const;
  [[nodiscard]] bool is_packed(int pivot) const;
  void start(std::span<const int> components);
  void start_all();
  void finish(std::span<const int> components);
  [[nodiscard]] Outcome finish_all();
  void factorize_active(Count count, const Vectors* right = nullptr);
  void eliminate_together(int number, unsigned active, Outcome* all, const simd::PackNumbers& numbers);
  [[nodiscard]] unsigned eliminate_pack(int number, const simd::PackJob& job) const;
  void eliminate_lanes(int number, unsigned active, unsigned other, Outcome* all, const simd::PackNumbers& numbers);
  void note_packed(int number, unsigned lanes);
  void measure_growth(const simd::PivotPack& pack, unsigned active);
  void count_pack(const simd::PivotPack& pack, unsigned active, Outcome* all);
  // refactorize().
  void restore(int k);
  void collect_redone(std::span<const NodeId> changed);
  void forget_redone(Outcome& outcome);
  // Solving.
  void solve_diagonal(int k, const double* diagonal, double* x, int columns, std::ptrdiff_t stride) const;
  void solve_active(double* x, int columns) const;
  void solve_transposed_active(double* x) const;
  void forward_pack(int number, unsigned active, const Vectors& v) const;
  void backward(const Vectors& v, int columns) const;
  [[nodiscard]] Vectors enter(double* x) const;
  void leave(int k, const Vectors& v) const;
  template <class Kernels, class Alone>
  void solve_pack(int number, unsigned active, const Vectors& v, const Kernels& kernels, Alone&& alone) const;
  void solve_forward(int k, double* x, int columns) const;
  void solve_backward(int k, double* x, int columns) const;
  void solve_forward_transposed(int k, double* x) const;
  void solve_backward_transposed(int k, double* x) const;
  void check_size(std::span<const double> x, int columns) const;
  void check_room() const;
  void check_factored(std::span<const int> components) const;
  Refinement refine(std::span<const double> b, std::span<double> x, std::span<const int> components, int max_sweeps,
                    Side side);

  std::shared_ptr<const Symbolic> symbolic_;
  FactorizationKind kind_;
  // Of the instruction set in use when this was made: for single blocks, and for packs.
  const kernels::Table* kernels_;
  const simd::Eliminations* eliminations_;
  const simd::Solves* solves_;
  mutable Participants taking_part_;
  References references_;
  Refiner refiner_;
  AlignedVector values_, matrix_;
  std::vector<int> row_exchange_;     ///< per row in pivot order: the row that took this place in its block
  std::vector<int> column_exchange_;  ///< same for columns, where the rank is not full; empty where it always is
  std::vector<int> rank_;             ///< per pivot
  /// A panel below a definite block goes through half a solve; where it is spread at once its L^-1 P^T is not kept.
  enum class Halved : char { no, yes, and_spread };
  std::vector<Halved> halved_;        ///< per pivot of a symmetric kind that went by itself
  std::vector<int> first_row_;        ///< per pivot: first row in pivot order
  std::vector<double> work_;          ///< two of the largest block and 3 of its rows; solving needs none of it
  std::vector<double> opened_, target_;  ///< blocks of one pivot, and one that it changes, where they lie interleaved
  std::vector<char> equal_;           ///< per pivot: equal_couplings
  std::vector<char> group_;           ///< per pivot: how many the group has that it begins, see group_size; 0 inside one
  std::vector<char> scattered_;       ///< per pivot: may blocks that it changes lie interleaved with others?
  std::vector<char> among_single_;    ///< per pivot: do it and all that it changes go by themselves?
  AlignedVector spread_;              ///< for the update of equal couplings
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
  bool complete_ = false;  ///< share_ and total_ are those of the factors of all components
  std::vector<std::uint8_t> packed_;    ///< by pack: lanes whose factor was made together
  std::vector<simd::Definite> definite_;  ///< by pack, of the symmetric kinds
  AlignedVector scratch_;               ///< of packs
  mutable AlignedVector lane_rows_;     ///< the vector that is solved for, interleaved as the packs are
  struct Range {
    std::int64_t begin, end;
  };
  std::vector<Range> zeroed_;           ///< of the values, ascending; empty: all of them
  std::vector<int> zeroed_begin_;       ///< by group of the program, into zeroed_
  std::vector<Outcome> outcomes_;       ///< by component, of the last factorization
  Standing standing_;
  bool keep_matrix_ = false;
  double largest_entry_ = 0;          ///< of the kept part of the matrix
  double saddle_shift_ = 0, leave_out_ = 0;
  double sign_ = 1;  ///< of what was added to the diagonal of the saddle block at hand
};

}  // namespace graphsolve
