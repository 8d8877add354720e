#include <algorithm>
#include <cmath>

#include "graphsolve/largest.hpp"
#include "interior_point/impl.hpp"
#include "interior_point/constants.hpp"

/// What becomes of a component after each step: solved, polished, taken back, refined from here on, or another attempt.
namespace graphsolve {

namespace {

constexpr double refine_below = 1e-2;  ///< residual from which Newton is expected to gain a digit
constexpr double barrier_share = 10;  ///< the residual that a barrier explains, over that of equal pairs
constexpr int most_polishes = 3;
constexpr int patience = 3;            ///< this many short steps in a row end an attempt
constexpr int last_patience = 6;       ///< from the third attempt on: there may be no better one
constexpr int newton_halvings = 3;     ///< more hold it where the constraints curve
constexpr int newton_iterations = 20;  ///< without ports it converges fast or not at all

}  // namespace

/// Ends, restarts or passes on every running component. One that was passed on and has not moved since, because another
/// one made the loop begin anew, is not judged twice: what becomes of it must not depend on the others.
void InteriorPoint::Impl::judge() {
  bool any_restarted = false;
  bool ended = false;
  keep_running_.clear();
  for (const int c : running_) keep_running_.push_back(c);
  for (std::size_t k = 0; k < keep_running_.size(); ++k) {
    const int c = keep_running_[k];
    if (judged_[c] && trouble_[c] == Status::solved) continue;
    restarted_ = false;
    judge_component(c);
    if (trouble_[c] != Status::solved) next_attempt(c);
    if (attempt_iterations_[c] < 0) ended = true;
    judged_[c] = !restarted_;
    any_restarted = any_restarted || restarted_;
  }
  restarted_ = any_restarted;
  if (!ended) return;
  if (undone_) {
    evaluate(linearized_ ? With::matrix : With::residual_alone);  // terms keep what belongs to x: bring them back to the point that is handed out
    undone_ = false;
  }
  std::erase_if(running_, [&](int c) { return attempt_iterations_[c] < 0; });
  set_running();
}

void InteriorPoint::Impl::judge_component(int c) {
  reports_[c].residual = error_[c];
  if (attempt_iterations_[c] == 0 && reports_[c].attempts == 2) keep_largest(start_residual_[c], port_error_[c]);
  if (!std::isfinite(error_[c]) && !good_[c]) {
    trouble_[c] = Status::not_finite;
    return;
  }
  if (trouble_[c] == Status::singular && good_[c]) {
    trouble_[c] = Status::solved;
    end(c);  // only the products were to be polished
    return;
  }
  if (trouble_[c] != Status::solved) return;
  if (good_[c] && !(error_[c] <= tolerance(c))) {
    undo(c);
    end(c);
    return;
  }
  if (error_[c] <= tolerance(c) && product_[c] <= settings_.largest_product * scale_[c]) {
    end(c);
    return;
  }
  if (unsound(c)) return;
  // Products that do not fall in a few steps belong to forces that are not unique; rounding keeps them up.
  const bool polishing_ends = good_[c] >= most_polishes || (good_[c] > 0 && alpha_[c] < centre_below);
  if (error_[c] <= tolerance(c) && polishing_ends) {
    end(c);
    return;
  }
  good_[c] = static_cast<char>(error_[c] <= tolerance(c) ? good_[c] + 1 : 0);
  if (degree_[c] == 0 && backtrack(c)) return;
  const int most = degree_[c] == 0 ? newton_iterations : settings_.max_iterations;
  if (attempt_iterations_[c] >= most) trouble_[c] = Status::max_iterations;
  else if (short_steps_[c] >= (reports_[c].attempts < 3 ? patience : last_patience)) trouble_[c] = bounded_[c] ? Status::step_bound : Status::stalled;
}

/// The last step only polished the products s z and made the residual worse: forces that are not unique amplify
/// rounding errors by the stiffness of their pairs. The point before it was a solution.
void InteriorPoint::Impl::undo(int c) {
  const double step = alpha_[c];
  alpha_[c] = -step;
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->accept(of_component(port_lists_[b], c), alpha_);
  move_by(c, -step);
  reports_[c].residual = previous_error_[c];
  undone_ = true;
}

/// Newton gains at least a digit near the solution, or arrives where the barrier lets it. Where it does not, rounding in
/// the elimination of very stiff pairs is the cause: refine from here on; a step that made things much worse is taken
/// back first.
bool InteriorPoint::Impl::unsound(int c) {
  if (refine_[c] || degree_[c] == 0 || attempt_iterations_[c] == 0) return false;
  if (previous_error_[c] > refine_below || error_[c] <= tolerance(c)) return false;
  const double of_barrier = barrier_share * std::sqrt(mu_[c] / scale_[c]);  // pairs end near s = z / scale = this
  if (error_[c] < std::max(0.1 * previous_error_[c], of_barrier) || alpha_[c] < 0.9) {
    if (!(error_[c] > 10 * previous_error_[c])) return false;
  }
  refine_[c] = 1;
  if (!(error_[c] > 10 * previous_error_[c])) return false;
  undo(c);
  alpha_[c] = 1;
  short_steps_[c] = 0;
  restarted_ = true;
  return true;
}

/// The present phase of a component is solved.
void InteriorPoint::Impl::end(int c) {
  if (phase_[c] == Phase::frozen || phase_[c] == Phase::refrozen) {
    refreeze(c);
  } else if (phase_[c] == Phase::rescaled) {  // the laws' own scale has the last word
    phase_[c] = Phase::polish;
    scale_[c] = scale_of_laws(c);
    start_phase(c);
  } else {
    attempt_iterations_[c] = -1;
  }
}

/// Newton far from the solution: halve the last step while it made the residual larger.
bool InteriorPoint::Impl::backtrack(int c) {
  const bool worse = attempt_iterations_[c] > 0 && previous_error_[c] > 1e-2 && error_[c] > previous_error_[c];
  if (!worse || halvings_[c] >= newton_halvings) {
    halvings_[c] = 0;
    return false;
  }
  ++halvings_[c];
  alpha_[c] *= 0.5;
  move_by(c, -alpha_[c]);
  restarted_ = true;
  return true;
}

}  // namespace graphsolve
