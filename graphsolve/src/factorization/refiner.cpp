#include "factorization/refiner.hpp"

#include <limits>
#include <utility>

#include "graphsolve/largest.hpp"
#include "factorization/thresholds.hpp"

namespace graphsolve {

namespace {

constexpr int patience = 3;  ///< sweeps in a row that may bring nothing: the worst row is not always the same

}  // namespace

void Refiner::reserve() {
  residual_.reserve();
  best_.reserve(symbolic_.rows());
  least_error_.assign(symbolic_.components(), 0.0);
  precision_.assign(symbolic_.components(), Precision::plain);
  in_vain_.assign(symbolic_.components(), 0);
  refined_.reserve(symbolic_.components());
}

void Refiner::keep(int component, std::span<const double> x) {
  each_row(symbolic_, component, [&](int i) { best_[i] = x[i]; });
}

bool Refiner::is_done(int component) const {
  return in_vain_[component] == patience || !(least_error_[component] > thresholds::refined);
}

bool Refiner::judge(const Residual::System& system, int component) {
  if (precision_[component] == Precision::twice) residual_.measure_twice(system, component);
  const double error = residual_.error(component);
  const bool slow = !(error <= 0.9 * least_error_[component]), better = error < least_error_[component];
  in_vain_[component] = slow ? in_vain_[component] + 1 : 0;
  if (better) {
    least_error_[component] = error;
    keep(component, system.x);
  }
  // Rows may stand still because others, whose error is small, are wrong by what rounding takes.
  if (slow && std::exchange(precision_[component], Precision::twice) == Precision::plain) residual_.measure_twice(system, component);
  return better;
}

Factorization::Refinement Refiner::refine(const double* matrix, Side side, std::span<const double> b, std::span<double> x,
                                          std::span<const int> components, int max_sweeps, Participants& participants,
                                          const std::function<void(double*)>& solve) {
  best_.resize(symbolic_.rows());
  refined_.assign(components.begin(), components.end());
  const Residual::System system{matrix, side, b, x};
  participants.set(components);
  residual_.measure(system, participants);
  for (const int c : components) {
    precision_[c] = Precision::plain;
    in_vain_[c] = 0;
    least_error_[c] = residual_.error(c);
    keep(c, x);
  }
  Factorization::Refinement result;
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    std::erase_if(refined_, [&](int c) { return is_done(c); });
    if (refined_.empty()) break;
    participants.set(refined_);
    solve(residual_.rows());
    for (const int c : refined_) each_row(symbolic_, c, [&](int i) { x[i] += residual_.rows()[i]; });
    residual_.measure(system, participants);
    for (const int c : refined_)
      if (judge(system, c)) result.sweeps = sweep + 1;
  }
  for (const int c : components) {
    each_row(symbolic_, c, [&](int i) { x[i] = best_[i]; });
    keep_largest(result.backward_error, least_error_[c]);
  }
  return result;
}

}  // namespace graphsolve
