#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "graphsolve/interior_point.hpp"
#include "simd/vector_kernels.hpp"

namespace graphsolve {

/// What an interior point is made of: setup.cpp makes its lists and begins a solve, starts.cpp finds points to start from,
/// loop.cpp iterates, judge.cpp ends it or goes back, linearize.cpp makes derivatives of what was solved.
class InteriorPoint::Impl {
 public:
  Impl(Problem& problem, std::shared_ptr<const Symbolic> symbolic, InteriorPointSettings settings);

  // As in InteriorPoint.
  void activate(int batch, std::span<const int> instances);
  void select(std::span<const int> components);
  void set_row_scale(NodeId node, std::span<const double> scale);
  Status solve(std::span<double> x, double force_factor, std::span<const double> noise);
  [[nodiscard]] std::span<const ComponentReport> reports() const { return reports_; }
  [[nodiscard]] std::span<const double> residual() const { return residual_; }
  [[nodiscard]] const Factorization& factorization() const { return factorization_; }
  void set_profile(Profile* profile) { profile_ = profile; }
  void set_more_starts(bool more) { more_starts_ = more; }
  Status linearize(std::span<double> x, double smoothing, double stiffness, Factorization& target);
  void restore_laws();
  [[nodiscard]] Factorization::Outcome factorize_terms(std::span<const double> x);

 private:
  struct Lists {  ///< instances of one batch, sorted by component
    std::vector<int> component;  ///< by instance
    std::vector<int> given;      ///< active instances, as they were named; of ports
    std::vector<int> all;        ///< the same by component
    std::vector<int> begin;      ///< by component, into all
    std::vector<int> running;    ///< those of running components
    std::uint64_t version = 0;   ///< of `running`
  };
  /// refrozen: started cold at the size of the last change; rescaled: in the unit of the rows, where that of the laws
  /// is much smaller
  enum class Phase : char { full, frozen, refrozen, rescaled, polish };
  enum class With { residual_alone, matrix };

  /// Where the solve of a component stands; made anew for every solve.
  struct Course {
    int iterations = 0;     ///< of the attempt
    Status trouble = Status::solved;  ///< why it has to end; solved: it need not
    Phase phase = Phase::full;
    char short_steps = 0;   ///< in a row
    char halvings = 0;      ///< of the last step
    char freezes = 0;       ///< how often couplings were frozen
    char doublings = 0;     ///< of the steps of frozen couplings
    char good = 0;          ///< points in a row, the last one included, that were solutions but for their products
    bool ended = false;
    bool judged = false;    ///< passed on at the point where it is
    bool bounded = false;   ///< a term's bound_step alone would have made the last step short
    bool refine = false;    ///< solutions of the linear system are refined
    double previous_error = 0, last_alpha = 0;
    double start_error = 0;     ///< of the ports, at the warm start
    double start_residual = 0;  ///< of all rows there, or of the ports at the first cold start, whichever is larger
  };

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
  void find_reach();
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
  /// Where no step was taken yet. A barrier leaves more than a small part, so with ports that is asked for only once: after
  /// a solve that made good what those before it, each ended at its start, had left.
  /// Rows of default scale are accepted nowhere but after an iteration: a diagonal that cancels against its neighbours
  /// says little about how far x is.
  [[nodiscard]] double start_tolerance(int component) const {
    if (default_rows_[component] > 0) return 0;
    if (degree_[component] > 0 && at_start_[component] != 1) return tolerance(component);
    const double part = settings_.start_part * settings_.tolerance;
    return noise_.empty() ? part : std::max(part, noise_[component]);
  }
  /// The lowest barrier: however loose the tolerance, pairs that reach it have a product that ends a solve.
  [[nodiscard]] double mu_floor(int component) const {
    const double least = 0.01 * settings_.tolerance;
    return std::min(least * least, 0.1 * settings_.largest_product) * scale_[component];
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
  std::int64_t wiring_ = 0;     ///< that this one took
  std::int64_t instances_ = 0;  ///< of all batches, when it was made
  InteriorPointSettings settings_;
  Factorization factorization_;
  std::vector<Lists> term_lists_, port_lists_;
  std::vector<int> selected_, running_;
  std::vector<int> some_;    ///< components of the moment
  std::vector<int> listed_;  ///< components that the lists of running instances and rows are of
  bool lists_changed_ = true;
  const simd::VectorKernels* kernels_;
  std::vector<RowRange> row_ranges_;    ///< rows of each component, neighbours joined
  std::vector<int> row_range_begin_;    ///< by component, into row_ranges_
  std::vector<RowRange> running_rows_;  ///< of all running components, neighbours joined
  std::vector<double> x_, dx_, rhs_, residual_, row_scale_;
  std::vector<bool> default_row_;  ///< whose scale is one over the diagonal, not the caller's
  std::span<const double> start_;  ///< the caller's x, which keeps the start until the end of a solve
  std::span<const double> noise_;  ///< the caller's, likewise
  // By component.
  std::vector<ComponentReport> reports_;
  std::vector<Course> course_;
  std::vector<double> error_, product_, mu_, alpha_, ratio_, sum_, correction_, scale_, change_, port_error_;  // as ports have them
  std::vector<int> degree_;
  std::vector<int> default_rows_;  ///< rows without a scale of the caller's
  int defaults_ = 0;               ///< of all components
  std::vector<double> reach_;      ///< by row, see find_reach(); empty where all have a scale of the caller's
  bool reach_known_ = false;       ///< in this solve
  // What is remembered from one solve to the next.
  std::vector<int> expected_iterations_;  ///< those that the solve before took
  std::vector<char> at_start_;            ///< > 0: one of the last two solves ended where it began
  bool restarted_ = false;
  bool default_scales_ = false;  ///< some component of this solve has rows without a scale of the caller's
  bool linearized_ = false;    ///< the matrix was evaluated at x_
  bool predicts_ = false;      ///< some component wants a predictor in this iteration
  bool solved_ = false;        ///< dx_ was solved for while the matrix was factored
  bool undone_ = false;  ///< some component went back by a step
  Profile* profile_ = nullptr;
  bool more_starts_ = false;
};


/// f(first, count)
template <class F>
void InteriorPoint::Impl::each_run(std::span<const RowRange> ranges, F&& f) {
  for (const RowRange& r : ranges) f(r.begin, r.end - r.begin);
}

}  // namespace graphsolve
