#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/problem.hpp"
#include "graphsolve/status.hpp"

namespace graphsolve {

namespace simd {
struct VectorKernels;
}

struct InteriorPointSettings {
  double tolerance = 1e-8;       ///< natural residual, in the units that the row scales make
  double largest_product = 1e-15;  ///< s z / scale of every pair at the end (its creep times its reserve)
  int max_iterations = 60;       ///< per attempt
};

/// Outcome for one connected component of the graph.
struct ComponentReport {
  Status status = Status::solved;
  int iterations = 0;      ///< factorizations, all attempts
  int attempts = 1;        ///< 1: warm start; 2, 3: cold starts; 4: frozen couplings first; then cold, at
                           ///< the size of the residual that the start showed, where that is larger; last in the unit
                           ///< of the rows (one over their scale), where it is 100 times that of the laws
  double residual = 0;     ///< natural residual at the end
  // Where an unsolved component is worst: rows of a node, or an instance of a port batch.
  NodeId worst_node;       ///< index -1: it is a port
  int worst_batch = -1;    ///< as numbered by Problem::add
  int worst_instance = -1;
};

/// Seconds (steady clock) spent in the phases of all solves; filled when given to InteriorPoint::set_profile.
struct Profile {
  double evaluate = 0, factorize = 0, solve = 0;
};

/// Primal-dual interior point (Mehrotra predictor-corrector) on the graph. Every connected component has a barrier,
/// step length and end of its own; without an active port plain Newton. symbolic: of problem.graph() after every add();
/// what is added later, and another InteriorPoint or check_terms of the same problem, which wires its terms anew, make
/// solve, linearize and factorize_terms throw std::logic_error. Allocates in the constructor only. Laws keep their
/// private unknowns between solves: the next solve starts warm.
class InteriorPoint {
 public:
  /// Throws std::invalid_argument where `symbolic` is of another graph, or a setting makes no sense.
  InteriorPoint(Problem& problem, std::shared_ptr<const Symbolic> symbolic, InteriorPointSettings settings = {});

  /// Which instances of a port batch exist in the next solves; all of them at first. Throws std::invalid_argument where
  /// one is named twice or is not there.
  void activate(int batch, std::span<const int> instances);

  /// Which components the next solves are about; all of them at first. The others are left as they are. Throws as
  /// activate does.
  void select(std::span<const int> components);
  /// Other numbers for Problem::set_row_scale, checked as they are there.
  void set_row_scale(NodeId node, std::span<const double> scale);

  /// In: start. Out: solution of all selected components that were solved; the others keep their start, and their laws
  /// what they remembered.
  /// force_factor: remembered forces are multiplied by it first (a change of the step length, where z is an impulse).
  /// noise: by component, the rounding error below which the residual cannot fall (may be empty).
  /// Returns `solved` when all were, else the status of the first that was not; reports() has every one.
  /// Throws std::invalid_argument when x or noise has another length than the graph has rows or components.
  Status solve(std::span<double> x, double force_factor = 1, std::span<const double> noise = {});

  [[nodiscard]] std::span<const ComponentReport> reports() const { return reports_; }
  [[nodiscard]] const Factorization& factorization() const { return factorization_; }
  void set_profile(Profile* profile) { profile_ = profile; }

  /// Derivative of a solution: brings x and the laws, as a solve left them, to the central path of
  /// s z = smoothing * scale (scale: largest of the component's active pairs), and factors the matrix there into
  /// `target`, which shares this Symbolic. A smoothing not above settings.largest_product is that of the solution
  /// itself: nothing moves. stiffness: bound on z/s over scale in the matrix; 1 over it is the relative error of the
  /// derivative, and rounding costs 2e-16 of it. Of all components, whatever was selected.
  /// The laws keep the private unknowns of that point until restore_laws(). Allocates nothing.
  Status linearize(std::span<double> x, double smoothing, double stiffness, Factorization& target);
  /// After linearize: private unknowns of the laws as the solve left them.
  void restore_laws();

  /// Matrix at x as factored by the last iteration is gone after a solve, and constraint rows had a shift of 1e-12 in it;
  /// this evaluates and factors all smooth terms at x anew, without ports or shift, and keeps the matrix: dropped_rows()
  /// of the result are dependent constraint rows, and diagnose(graph, result, {}) names their groups.
  const Factorization& factorize_terms(std::span<const double> x);

 private:
  struct Lists {  ///< instances of one batch, sorted by component
    std::vector<int> component;  ///< by instance
    std::vector<int> given;      ///< active instances, as they were named
    std::vector<int> all;        ///< the same by component
    std::vector<int> begin;      ///< by component, into all
    std::vector<int> running;    ///< those of running components
    std::uint64_t version = 0;   ///< of `running`
  };
  /// refrozen: started cold at the size of the last change; rescaled: in the unit of the rows, where that of the laws
  /// is much smaller
  enum class Phase { full, frozen, refrozen, rescaled, polish };
  enum class With { residual_alone, matrix };

  void check_point(std::size_t size) const;
  void make_lists(Lists& lists, std::span<const int> component_of_instance);
  void sort_by_component(Lists& lists, std::span<const int> instances);
  void find_row_ranges();
  void set_running();
  void run_all();
  [[nodiscard]] static Instances of_component(const Lists& lists, int component) {
    return {std::span(lists.all).subspan(lists.begin[component], lists.begin[component + 1] - lists.begin[component]),
            lists.component, 0};
  }
  [[nodiscard]] static Instances running(const Lists& lists) { return {lists.running, lists.component, lists.version}; }
  struct RowRange {
    int begin, end;
  };
  [[nodiscard]] std::span<const RowRange> rows_of(int component) const {
    return std::span(row_ranges_).subspan(row_range_begin_[component],
                                          row_range_begin_[component + 1] - row_range_begin_[component]);
  }
  static void join(std::vector<RowRange>& ranges, std::size_t first, const RowRange& next);
  template <class F>
  static void each_run(std::span<const RowRange> ranges, F&& f);
  static void copy_rows(std::span<const RowRange> ranges, std::span<const double> from, std::span<double> to);
  void move_by(int component, double factor);

  void begin(std::span<const double> x, double force_factor, std::span<const double> noise);
  void start_warm();
  void evaluate(With with);
  void evaluate_terms(With with, std::span<double> residual);
  [[nodiscard]] bool most_expect_to_end() const;
  void evaluate_ports();
  void set_default_scales();
  void judge();
  void judge_component(int component);
  void undo(int component);
  bool unsound(int component);
  void end(int component);
  bool backtrack(int component);
  void next_attempt(int component);
  void refreeze(int component);
  void start_phase(int component);
  void restart_cold(int component, double velocity);
  [[nodiscard]] double scale_of_laws(int component) const;
  [[nodiscard]] double unit_of_forces(int component) const;
  void blame(int component);
  bool factorize();
  /// Of the residual.
  [[nodiscard]] double tolerance(int component) const {
    return noise_.empty() ? settings_.tolerance : std::max(settings_.tolerance, noise_[component]);
  }
  /// The lowest barrier.
  [[nodiscard]] double mu_floor(int component) const {
    const double least = 0.01 * settings_.tolerance;
    return least * least * scale_[component];
  }
  [[nodiscard]] bool straight_to_floor(int component) const;
  [[nodiscard]] double floor_target(int component) const;
  void first_target();
  void affine_step();
  void combined_step();
  void take_step();
  void right_hand_side();
  void solve_linear();
  void evaluate_terms_into(Factorization& target);
  [[nodiscard]] bool centre(const Factorization& matrix);

  Problem& problem_;
  std::int64_t wiring_;         ///< that this one took
  std::int64_t instances_ = 0;  ///< of all batches, when it was made
  InteriorPointSettings settings_;
  Factorization factorization_;
  std::vector<Lists> term_lists_, port_lists_;
  std::vector<int> selected_, running_, keep_running_, refining_;
  std::vector<int> listed_;  ///< components that the lists of running instances and rows are of
  bool lists_changed_ = true;
  const simd::VectorKernels* kernels_;
  std::vector<RowRange> row_ranges_;    ///< rows of each component, neighbours joined
  std::vector<int> row_range_begin_;    ///< by component, into row_ranges_
  std::vector<RowRange> running_rows_;  ///< of all running components, neighbours joined
  std::vector<double> x_, dx_, rhs_, residual_, row_scale_;
  std::span<const double> start_;  ///< the caller's x, which keeps the start until the end of a solve
  std::span<const double> noise_;  ///< the caller's, likewise
  // By component.
  std::vector<ComponentReport> reports_;
  std::vector<double> error_, previous_error_, product_, mu_, alpha_, ratio_, sum_, correction_, scale_, change_,
      last_alpha_, port_error_, start_error_, start_residual_;
  std::vector<int> degree_, attempt_iterations_, short_steps_, halvings_, freezes_,
      expected_iterations_;  ///< those that the solve before took
  std::vector<Status> trouble_;  ///< why the present attempt has to end; solved: it need not
  std::vector<Phase> phase_;
  std::vector<char> doublings_;  ///< of the steps of frozen couplings
  std::vector<char> at_start_;  ///< > 0: one of the last two solves ended where it began
  std::vector<char> judged_;   ///< passed on at the point where it is
  std::vector<char> scaled_;   ///< has its default scales
  std::vector<char> bounded_;  ///< a term's bound_step alone would have made the last step short
  std::vector<char> refine_;   ///< solutions of the linear system are refined
  std::vector<char> good_;  ///< number of points in a row, the last one included, that were solutions but for their products
  bool restarted_ = false;
  bool scales_known_ = false;  ///< of all running components
  bool linearized_ = false;    ///< the matrix was evaluated at x_
  bool predicts_ = false;      ///< some component wants a predictor in this iteration
  bool solved_ = false;        ///< dx_ was solved for while the matrix was factored
  bool undone_ = false;  ///< some component went back by a step
  Profile* profile_ = nullptr;
};

/// f(first, count)
template <class F>
void InteriorPoint::each_run(std::span<const RowRange> ranges, F&& f) {
  for (const RowRange& r : ranges) f(r.begin, r.end - r.begin);
}

}  // namespace graphsolve
