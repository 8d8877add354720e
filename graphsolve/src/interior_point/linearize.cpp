#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "interior_point/impl.hpp"
#include "graphsolve/largest.hpp"

/// The derivative of a solution: the matrix of one Newton step on the central path of a given barrier.
namespace graphsolve {

namespace {

constexpr int most_centrings = 50;
constexpr double last_move = 1e-8;     ///< a full Newton step this small leaves rounding errors only
constexpr double off_path = 1e-6;      ///< of the mean product from its barrier, relative

}  // namespace

void InteriorPoint::Impl::run_all() {
  running_.resize(reports_.size());
  std::iota(running_.begin(), running_.end(), 0);
  set_running();
}

Status InteriorPoint::Impl::linearize(std::span<double> x, double smoothing, double stiffness, Factorization& target) {
  check_point(x.size());
  if (&target.symbolic() != &factorization_.symbolic())
    throw std::invalid_argument("linearize: the target has another elimination");
  if (target.kind() != FactorizationKind::ldu)
    throw std::invalid_argument("linearize: the matrix is not symmetric, the target has to be an LDU");
  std::copy(x.begin(), x.end(), x_.begin());
  run_all();
  const auto ports = problem_.ports();
  for (const int c : running_) scale_[c] = 0, degree_[c] = 0;
  for (std::size_t b = 0; b < ports.size(); ++b) {
    ports[b]->remember(running(port_lists_[b]), 1.0);
    for (const int i : port_lists_[b].running) {
      const int c = port_lists_[b].component[i];
      scale_[c] = std::max(scale_[c], ports[b]->scale(i));
      degree_[c] += ports[b]->degree(i);
    }
  }
  for (const int c : running_) {
    mu_[c] = smoothing * scale_[c];
    correction_[c] = 0;
  }
  const bool moves = smoothing > settings_.largest_product &&
                     std::any_of(running_.begin(), running_.end(), [&](int c) { return degree_[c] > 0; });
  if (moves) {
    evaluate_terms_into(target);  // ports may read what terms compute from x
    for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->start_warm(running(port_lists_[b]), x_, mu_, scale_);
  }
  bool arrived = !moves;
  for (int k = 0;; ++k) {
    evaluate_terms_into(target);
    for (const int c : running_) ratio_[c] = stiffness * scale_[c];
    for (std::size_t b = 0; b < ports.size(); ++b) {
      ports[b]->evaluate(running(port_lists_[b]), x_, residual_, scale_, error_, product_);
      ports[b]->condense(running(port_lists_[b]), ratio_, target.values().data());
    }
    if (!target.factorize().ok()) return Status::singular;
    if (arrived) break;
    if (k == most_centrings) return Status::max_iterations;
    arrived = centre(target);
  }
  std::copy(x_.begin(), x_.end(), x.begin());
  return Status::solved;
}

void InteriorPoint::Impl::evaluate_terms_into(Factorization& target) {
  target.set_zero();
  std::fill(residual_.begin(), residual_.end(), 0.0);
  const auto terms = problem_.terms();
  for (std::size_t b = 0; b < terms.size(); ++b)
    terms[b]->evaluate(running(term_lists_[b]), x_, residual_, target.values().data());
}

/// One Newton step at a fixed barrier. True when it was the last that is needed.
bool InteriorPoint::Impl::centre(const Factorization& matrix) {
  const auto ports = problem_.ports();
  right_hand_side();
  matrix.solve(dx_);
  for (const int c : running_) ratio_[c] = sum_[c] = 0;
  for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->recover(running(port_lists_[b]), dx_, ratio_);
  for (const int c : running_) error_[c] = 1;  // the closer to zero, the closer take_step goes to the boundary
  take_step();
  std::fill(change_.begin(), change_.end(), 0.0);  // products where the step has led to
  for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->complementarity(running(port_lists_[b]), change_, sum_);
  bool last = true;
  for (const int c : running_) {
    double size = 1, move = 0;
    each_run(rows_of(c), [&](int first, int count) {
      for (int i = first; i < first + count; ++i) {
        size = std::max(size, std::abs(x_[i]));
        keep_largest(move, std::abs(dx_[i]));
      }
    });
    const double wanted = degree_[c] * mu_[c];
    if (!(alpha_[c] == 1.0 && move <= last_move * size && std::abs(sum_[c] - wanted) <= off_path * wanted)) last = false;
  }
  return last;
}

void InteriorPoint::Impl::restore_laws() {
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b) ports[b]->restore(running(port_lists_[b]));
}

}  // namespace graphsolve
