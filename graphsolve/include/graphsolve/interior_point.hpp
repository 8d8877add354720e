#pragma once

#include <memory>
#include <span>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/problem.hpp"
#include "graphsolve/status.hpp"

namespace graphsolve {

struct InteriorPointSettings {
  double tolerance = 1e-8;       ///< natural residual, in the units that the row scales make
  double largest_product = 1e-15;  ///< s z / scale of every pair at the end (its creep times its reserve)
  int max_iterations = 60;       ///< per attempt
  /// Part of the tolerance up to which the start is the solution, without an iteration: of a component without active
  /// ports, and of one whose last solve had to iterate where the one before that ended at its start. What a start misses
  /// adds up where one solve begins at the end of the one before; see residual().
  double start_part = 1;
  /// Factorization::set_saddle_shift's: constraint rows that may depend on others keep their multiplier where less than
  /// this part of their pivot is left. 1e-8 suits curved constraints that are solved step after step. Where bounds alone
  /// hold some unknowns, independent rows can have pivots as small: 0, none is left out.
  double leave_out = 0;
};

/// Outcome for one connected component of the graph.
struct ComponentReport {
  Status status = Status::solved;
  int iterations = 0;      ///< factorizations, all attempts
  int attempts = 1;        ///< 1: warm start; 2, 3: cold starts; 4: frozen couplings first; then cold, at the size of
                           ///< the residual that the start or the second attempt's showed, where that is larger; last in
                           ///< the unit of the rows (one over their scale), where it is 100 times that of the laws
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
/// what is added later, and another InteriorPoint or check_terms that wires one of its terms anew, make solve, linearize and
/// factorize_terms throw std::logic_error. Allocates in the constructor only. Laws keep their
/// private unknowns between solves: the next solve starts warm.
class InteriorPoint {
 public:
  /// Keeps a reference to the problem, which must live as long and is used by one thread at a time; the Symbolic may be
  /// shared. Throws std::invalid_argument where `symbolic` is of another graph, or a setting makes no sense, and what a term
  /// or port throws when it is wired.
  InteriorPoint(Problem& problem, std::shared_ptr<const Symbolic> symbolic, InteriorPointSettings settings = {});
  ~InteriorPoint();
  InteriorPoint(InteriorPoint&&) noexcept;
  InteriorPoint& operator=(InteriorPoint&&) noexcept;

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

  /// By component, of the last solve that it took part in; before the first, solved in no iterations.
  [[nodiscard]] std::span<const ComponentReport> reports() const;
  /// By row, where the last solve of each component ended: what it was accepted with, forces of terms and ports together.
  /// A caller whose solves follow each other in time owes it to the next one.
  [[nodiscard]] std::span<const double> residual() const;
  [[nodiscard]] const Factorization& factorization() const;
  /// Of the caller, who keeps it as long as there are solves; null: none.
  void set_profile(Profile* profile);
  /// Whether a component that fails starts cold fourteen times more, from pairs of other sizes, in place of the attempt with
  /// frozen couplings: for who has nothing else left to try. Off at first.
  void set_more_starts(bool more);

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
  /// this evaluates and factors all smooth terms at x anew, without ports or shift, and keeps the matrix: dropped_rows() of
  /// factorization() are dependent constraint rows then, and diagnose(graph, factorization(), outcome) names their groups.
  [[nodiscard]] Factorization::Outcome factorize_terms(std::span<const double> x);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace graphsolve
