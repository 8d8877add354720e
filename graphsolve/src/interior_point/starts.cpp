#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "interior_point/impl.hpp"

/// Where components start from, and start again when they got nowhere.
namespace graphsolve {

namespace {

/// Sizes of pairs in further cold starts: which of them leads to a solution where the first does not is anybody's guess.
constexpr double more_starts[] = {0.1, 10, 0.03, 3, 0.3, 30, 0.003, 0.5, 2, 0.2, 5, 0.05, 20, 0.02};
constexpr int most_freezes = 80;
constexpr int undamped_freezes = 8;
constexpr int most_doublings = 20;
constexpr double small_scale = 0.01;  ///< of the laws, over the unit of the rows: pairs cannot grow stiff enough

}  // namespace

/// Projects the remembered point at the lowest barrier, and chooses the barrier from the residual found there.
void InteriorPoint::Impl::start_warm() {
  const auto ports = problem_.ports();
  const auto start = [&] {
    for (std::size_t b = 0; b < ports.size(); ++b)
      if (!port_lists_[b].running.empty()) ports[b]->start_warm(running(port_lists_[b]), x_, mu_, scale_);
  };
  // Ports may read what terms compute from x. A solve that may end where it starts needs no matrix.
  evaluate_terms(most_expect_to_end() ? With::residual_alone : With::matrix, residual_);
  const bool with_ports = std::ranges::any_of(running_, [&](int c) { return degree_[c] > 0; });
  if (with_ports) copy_rows(running_rows_, residual_, rhs_);
  for (const int c : running_) mu_[c] = mu_floor(c);
  start();
  evaluate_ports();
  bool again = false;
  for (const int c : running_) {
    course_[c].start_error = port_error_[c];
    course_[c].start_residual = error_[c];
    if (degree_[c] == 0 || error_[c] <= tolerance(c)) continue;
    // Rows that know nothing of the ports say little about how far these are from their path.
    const double e = std::max(port_error_[c], 0.03 * error_[c]);
    // Only what the ports themselves see may lift the barrier above 1 m/s: rows with a large scale are no measure.
    const double most = std::max(1.0, 0.1 * port_error_[c] * port_error_[c]);
    mu_[c] = std::clamp(0.1 * e * e * scale_[c], mu_floor(c), most * scale_[c]);
    again = true;
  }
  if (!again) return;
  start();  // x is where it was: so is what the terms made of it
  copy_rows(running_rows_, rhs_, residual_);
  evaluate_ports();
}

void InteriorPoint::Impl::restart_cold(int c, double velocity) {
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b)
    ports[b]->start_cold(of_component(port_lists_[b], c), velocity, scale_);
}

/// Finds where the residual of a component that failed is largest; a NaN counts as largest.
void InteriorPoint::Impl::blame(int c) {
  const Symbolic& s = factorization_.symbolic();
  ComponentReport& report = reports_[c];
  double largest = -1;
  for (int k = s.component_begin(c); k < s.component_begin(c + 1); ++k)
    for (int i = s.row(k); i < s.row(k) + s.dimension(k); ++i) {
      const double e = std::abs(residual_[i]) * row_scale_[i];
      if (e <= largest || std::isnan(largest)) continue;
      largest = e;
      report.worst_node = s.node(k);
    }
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b)
    for (const int i : of_component(port_lists_[b], c).index) {
      if (std::isnan(largest)) return;
      error_[c] = product_[c] = 0;
      ports[b]->evaluate({{&i, 1}, port_lists_[b].component, 0}, x_, rhs_, scale_, error_, product_);  // rhs_: nobody's now
      if (error_[c] <= largest) continue;
      largest = error_[c];
      report.worst_node = {};
      report.worst_batch = static_cast<int>(b);
      report.worst_instance = i;
    }
}

/// From where x is.
void InteriorPoint::Impl::start_phase(int c) {
  Course& course = course_[c];
  course.iterations = course.short_steps = 0;
  course.good = 0;
  restarted_ = true;
}

double InteriorPoint::Impl::scale_of_laws(int c) const {
  double scale = 0;
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b)
    for (const int i : of_component(port_lists_[b], c).index) scale = std::max(scale, ports[b]->scale(i));
  return scale;
}

/// Force over u where the rows are comparable with u: one over the smallest row scale.
double InteriorPoint::Impl::unit_of_forces(int c) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const RowRange& rows : rows_of(c))
    for (int i = rows.begin; i < rows.end; ++i) smallest = std::min(smallest, row_scale_[i]);
  return 1 / smallest;
}

/// Ladder: warm, cold at 1 m/s, cold at another scale, frozen couplings (or cold at many scales), cold at the size of all
/// residuals, cold in the unit of the rows, end.
void InteriorPoint::Impl::next_attempt(int c) {
  Course& course = course_[c];
  const Status cause = course.trouble;
  const auto ports = problem_.ports();
  const double usual = std::max(1.0, course.start_error), large = course.start_residual;
  course.trouble = Status::solved;
  if (course.phase == Phase::refrozen && std::isfinite(error_[c])) {  // too small a start: pairs jam at their bounds
    course.phase = Phase::frozen;
    start_phase(c);
    restart_cold(c, usual);
    return;
  }
  for (std::size_t b = 0; b < ports.size(); ++b) {
    change_[c] = 0;
    ports[b]->relax(of_component(port_lists_[b], c), 0.0, change_);
  }
  scale_[c] = scale_of_laws(c);
  const double unit = unit_of_forces(c);
  const bool rescale = scale_[c] < small_scale * unit;
  const int more = more_starts_ ? static_cast<int>(std::size(more_starts)) : 0, fourth = more > 0 ? more : 1;
  const int most_attempts = 3 + fourth + (large > usual ? 1 : 0) + (rescale ? 1 : 0);
  if (degree_[c] == 0 || reports_[c].attempts == most_attempts) {
    reports_[c].status = cause;
    blame(c);
    course.ended = true;
    for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->restore(of_component(port_lists_[b], c));
    return;
  }
  copy_rows(rows_of(c), start_, x_);
  alpha_[c] = 1;
  start_phase(c);
  course.halvings = course.freezes = course.doublings = 0;
  course.phase = Phase::full;
  const int attempt = ++reports_[c].attempts;
  if (rescale && attempt == most_attempts) {
    course.phase = Phase::rescaled;
    scale_[c] = unit;
    restart_cold(c, std::max(usual, large));
    return;
  }
  // The natural size of velocities here is what the start showed, but not less than 1. Where the data are much larger
  // than 1 (costs, prices), pairs that start small jam at their bounds.
  if (attempt > 3 && attempt <= 3 + more) restart_cold(c, more_starts[attempt - 4]);
  else restart_cold(c, attempt == 3 ? 0.01 : attempt > 3 + fourth ? large : usual);
  if (attempt == 4 && more == 0) {
    course.phase = Phase::frozen;
    for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->relax(of_component(port_lists_[b], c), 1.0, change_);
  }
}

/// The frozen problem is solved: move the frozen couplings to what they should be, or set them free. Where they drift, each
/// time by about as much as the time before, they flee from a fixed point or creep along a bound, and the solution is
/// far away, where other bounds hold: twice as far each time.
void InteriorPoint::Impl::refreeze(int c) {
  Course& course = course_[c];
  const auto ports = problem_.ports();
  const double last = change_[c];
  change_[c] = 0;
  const double damping = course.freezes < undamped_freezes ? 1.0 : std::ldexp(0.5, course.doublings);
  for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->relax(of_component(port_lists_[b], c), damping, change_);
  const bool drifts = course.freezes >= undamped_freezes && change_[c] > 0.9 * last && change_[c] < 4 * last;
  course.doublings = static_cast<char>(drifts ? std::min(course.doublings + 1, most_doublings) : 0);
  if (change_[c] < 1e-6 || ++course.freezes > most_freezes) {
    course.phase = Phase::polish;
    for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->relax(of_component(port_lists_[b], c), 0.0, change_);
    start_phase(c);
    return;
  }
  course.phase = Phase::refrozen;
  start_phase(c);
  restart_cold(c, std::max(change_[c], 1e-4));
}

}  // namespace graphsolve
