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
  some_.assign(running_.begin(), running_.end());
  for (const int c : some_) {
    if (course_[c].judged && course_[c].trouble == Status::solved) continue;
    restarted_ = false;
    judge_component(c);
    if (course_[c].trouble != Status::solved) next_attempt(c);
    if (course_[c].ended) ended = true;
    course_[c].judged = !restarted_;
    any_restarted = any_restarted || restarted_;
  }
  restarted_ = any_restarted;
  if (!ended) return;
  if (undone_) {
    evaluate(linearized_ ? With::matrix : With::residual_alone);  // terms keep what belongs to x: bring them back to the point that is handed out
    undone_ = false;
  }
  std::erase_if(running_, [&](int c) { return course_[c].ended; });
  set_running();
}

void InteriorPoint::Impl::judge_component(int c) {
  Course& course = course_[c];
  reports_[c].residual = error_[c];
  if (course.iterations == 0 && reports_[c].attempts == 2) keep_largest(course.start_residual, port_error_[c]);
  if (!std::isfinite(error_[c]) && !course.good) {
    course.trouble = Status::not_finite;
    return;
  }
  if (course.trouble == Status::singular && course.good) {
    course.trouble = Status::solved;
    end(c);  // only the products were to be polished
    return;
  }
  if (course.trouble != Status::solved) return;
  if (course.good && !(error_[c] <= tolerance(c))) {
    undo(c);
    end(c);
    return;
  }
  const double enough = course.iterations == 0 ? start_tolerance(c) : tolerance(c);
  if (error_[c] <= enough && product_[c] <= settings_.largest_product * scale_[c]) {
    end(c);
    return;
  }
  if (unsound(c)) return;
  // Products that do not fall in a few steps belong to forces that are not unique; rounding keeps them up.
  const bool polishing_ends = course.good >= most_polishes || (course.good > 0 && alpha_[c] < centre_below);
  if (error_[c] <= tolerance(c) && polishing_ends) {
    end(c);
    return;
  }
  course.good = static_cast<char>(error_[c] <= tolerance(c) ? course.good + 1 : 0);
  if (degree_[c] == 0 && backtrack(c)) return;
  const int most = degree_[c] == 0 ? newton_iterations : settings_.max_iterations;
  if (course.iterations >= most) course.trouble = Status::max_iterations;
  else if (course.short_steps >= (reports_[c].attempts < 3 ? patience : last_patience))
    course.trouble = course.bounded ? Status::step_bound : Status::stalled;
}

/// The last step only polished the products s z and made the residual worse: forces that are not unique amplify
/// rounding errors by the stiffness of their pairs. The point before it was a solution.
void InteriorPoint::Impl::undo(int c) {
  const double step = alpha_[c];
  alpha_[c] = -step;
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->accept(of_component(port_lists_[b], c), alpha_);
  move_by(c, -step);
  reports_[c].residual = course_[c].previous_error;
  undone_ = true;
}

/// Newton gains at least a digit near the solution, or arrives where the barrier lets it. Where it does not, rounding in
/// the elimination of very stiff pairs is the cause: refine from here on; a step that made things much worse is taken
/// back first.
bool InteriorPoint::Impl::unsound(int c) {
  Course& course = course_[c];
  if (course.refine || degree_[c] == 0 || course.iterations == 0) return false;
  if (course.previous_error > refine_below || error_[c] <= tolerance(c)) return false;
  const double of_barrier = barrier_share * std::sqrt(mu_[c] / scale_[c]);  // pairs end near s = z / scale = this
  if (error_[c] < std::max(0.1 * course.previous_error, of_barrier) || alpha_[c] < 0.9) {
    if (!(error_[c] > 10 * course.previous_error)) return false;
  }
  course.refine = true;
  if (!(error_[c] > 10 * course.previous_error)) return false;
  undo(c);
  alpha_[c] = 1;
  course.short_steps = 0;
  restarted_ = true;
  return true;
}

/// The present phase of a component is solved.
void InteriorPoint::Impl::end(int c) {
  Course& course = course_[c];
  if (course.phase == Phase::frozen || course.phase == Phase::refrozen) {
    refreeze(c);
  } else if (course.phase == Phase::rescaled) {  // the laws' own scale has the last word
    course.phase = Phase::polish;
    scale_[c] = scale_of_laws(c);
    start_phase(c);
  } else {
    course.ended = true;
  }
}

/// Newton far from the solution: halve the last step while it made the residual larger.
bool InteriorPoint::Impl::backtrack(int c) {
  Course& course = course_[c];
  const bool worse = course.iterations > 0 && course.previous_error > 1e-2 && error_[c] > course.previous_error;
  if (!worse || course.halvings >= newton_halvings) {
    course.halvings = 0;
    return false;
  }
  ++course.halvings;
  alpha_[c] *= 0.5;
  move_by(c, -alpha_[c]);
  restarted_ = true;
  return true;
}

}  // namespace graphsolve
