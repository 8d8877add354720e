#include "interior_point/impl.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "graphsolve/largest.hpp"
#include "interior_point/constants.hpp"
#include "simd/vector_kernels.hpp"

namespace graphsolve {

namespace {

constexpr double affine_from = 1e-5;   ///< below this residual the barrier follows its square, without a predictor
constexpr double centring = 0.5;
constexpr double short_step = 0.15;    ///< several of these in a row end an attempt
constexpr double stiffest = 1e5;        ///< bound on z/s over its scale, as long as the residual is above 1e-6
constexpr double stiffest_move = 0.1;   ///< below that the bound is this over the residual
constexpr double superlinear = 0.01;   ///< mu over scale and the square of the ports' residual, near the solution

/// Adds the time since the last call to a phase of the profile; costs nothing without one. What lies between the phases
/// counts with the next.
class Laps {
 public:
  explicit Laps(Profile* profile) : profile_(profile) {
    if (profile_) begin_ = std::chrono::steady_clock::now();
  }
  void add_to(double Profile::* phase) {
    if (!profile_) return;
    const auto now = std::chrono::steady_clock::now();
    profile_->*phase += std::chrono::duration<double>(now - begin_).count();
    begin_ = now;
  }

 private:
  Profile* profile_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace

/// The paper's loop (section III-C) with a predictor, until every component has ended.
Status InteriorPoint::Impl::solve(std::span<double> x, double force_factor, std::span<const double> noise) {
  Laps laps(profile_);
  begin(x, force_factor, noise);
  if (running_.empty()) return Status::solved;
  start_warm();
  while (!running_.empty()) {
    judge();
    if (restarted_) {
      evaluate(With::matrix);
      continue;
    }
    if (running_.empty()) break;
    if (!linearized_) evaluate_terms(With::matrix, rhs_);  // the residual is there, the ports' forces in it
    laps.add_to(&Profile::evaluate);
    const bool regular = factorize();
    laps.add_to(&Profile::factorize);
    if (!regular) {
      judge();
      evaluate(With::matrix);
      continue;
    }
    affine_step();
    combined_step();
    laps.add_to(&Profile::solve);
    take_step();
    evaluate(most_expect_to_end() ? With::residual_alone : With::matrix);
  }
  laps.add_to(&Profile::evaluate);
  Status status = Status::solved;
  for (const int c : selected_) {
    if (reports_[c].status != Status::solved) {
      if (status == Status::solved) status = reports_[c].status;
      continue;
    }
    copy_rows(rows_of(c), x_, x);
  }
  return status;
}

/// A solve that takes as many iterations as the one before, as in a simulation it mostly does, needs no matrix at its
/// last point. One may end at its first when one of the two before did. Where it goes on all the same, the matrix is made
/// then.
bool InteriorPoint::Impl::most_expect_to_end() const {
  std::size_t ending = 0;
  for (const int c : running_)
    ending += course_[c].iterations == 0 ? at_start_[c] > 0 : course_[c].iterations >= expected_iterations_[c];
  return 2 * ending > running_.size();
}

void InteriorPoint::Impl::evaluate(With with) {
  evaluate_terms(with, residual_);
  evaluate_ports();
}

void InteriorPoint::Impl::evaluate_terms(With with, std::span<double> residual) {
  linearized_ = with == With::matrix || default_scales_;
  if (linearized_) factorization_.set_zero(running_);
  each_run(running_rows_, [&](int first, int count) { std::fill_n(residual.data() + first, count, 0.0); });
  const auto terms = problem_.terms();
  double* values = linearized_ ? factorization_.values().data() : nullptr;
  for (std::size_t b = 0; b < terms.size(); ++b) terms[b]->evaluate(running(term_lists_[b]), x_, residual, values);
  if (default_scales_) set_default_scales();
}

/// On top of evaluate_terms: forces of the ports, and the natural residual of every running component.
void InteriorPoint::Impl::evaluate_ports() {
  for (const int c : running_) error_[c] = product_[c] = 0;
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b) {
    const Instances instances = running(port_lists_[b]);
    if (instances.index.empty()) continue;
    ports[b]->evaluate(instances, x_, residual_, scale_, error_, product_);
  }
  for (const int c : running_) {
    port_error_[c] = error_[c];
    each_run(rows_of(c), [&](int first, int count) {
      error_[c] = kernels_->largest_scaled(residual_.data() + first, row_scale_.data() + first, count, error_[c]);
    });
  }
}

/// With the first direction of the iteration, solved in the same pass: factors are still in the cache. False when some
/// component has a singular block.
bool InteriorPoint::Impl::factorize() {
  const auto ports = problem_.ports();
  double* values = factorization_.values().data();
  // Forces that are not unique move by stiffness times residual: a stiffness of 1 / residual keeps that move finite,
  // and what it leaves undone is quadratic in the residual, as Newton's own error is.
  for (const int c : running_) ratio_[c] = scale_[c] * std::max(stiffest, stiffest_move / error_[c]);
  for (std::size_t b = 0; b < ports.size(); ++b)
    if (!port_lists_[b].running.empty()) ports[b]->condense(running(port_lists_[b]), ratio_, values);
  first_target();
  right_hand_side();
  bool regular = true;
  const bool keep = std::ranges::any_of(running_, [&](int c) { return course_[c].refine != 0; });
  factorization_.keep_matrix(keep);
  const auto outcomes = keep ? factorization_.factorize(running_) : factorization_.factorize_and_solve(running_, dx_);
  solved_ = !keep;
  for (const int c : running_) {
    if (!outcomes[c].ok()) {
      course_[c].trouble = Status::singular;
      regular = false;
    }
  }
  for (const int c : running_) {
    if (!regular && course_[c].trouble == Status::solved) continue;  // does not step now, but after the next factorization
    ++reports_[c].iterations;
    ++course_[c].iterations;
    course_[c].previous_error = error_[c];
  }
  return regular;
}

void InteriorPoint::Impl::right_hand_side() {
  each_run(running_rows_,
           [&](int first, int count) { kernels_->negate(residual_.data() + first, dx_.data() + first, count); });
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b)
    if (!port_lists_[b].running.empty())
      ports[b]->right_hand_side(running(port_lists_[b]), mu_, correction_, dx_);
}

/// What factorize() has not done yet.
void InteriorPoint::Impl::solve_linear() {
  if (!solved_) {
    some_.clear();
    for (const int c : running_)
      if (course_[c].refine) {
        some_.push_back(c);
        copy_rows(rows_of(c), dx_, rhs_);
      }
    factorization_.solve_components(dx_, running_);
    if (!some_.empty()) (void)factorization_.refine(rhs_, dx_, some_, 2);
  }
  solved_ = false;
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b)
    if (!port_lists_[b].running.empty()) ports[b]->recover(running(port_lists_[b]), dx_, ratio_);
}

/// Near the solution, and on a central enough path, no predictor is needed.
bool InteriorPoint::Impl::straight_to_floor(int c) const {
  return error_[c] < affine_from && !(course_[c].last_alpha < centre_below);
}

/// Without a predictor. One pair that lags behind jams at its bound when the others' targets fall faster than the residual
/// does.
double InteriorPoint::Impl::floor_target(int c) const {
  return std::max(mu_floor(c), superlinear * port_error_[c] * port_error_[c] * scale_[c]);
}

/// Of the iteration's first direction: mu = 0 where some component wants a predictor, else where all go.
void InteriorPoint::Impl::first_target() {
  predicts_ = false;
  for (const int c : running_) {
    ratio_[c] = mu_[c] = correction_[c] = 0;
    course_[c].last_alpha = alpha_[c];
    if (degree_[c] > 0 && !straight_to_floor(c)) predicts_ = true;
  }
  for (const int c : running_)
    if (!predicts_ && degree_[c] > 0) mu_[c] = floor_target(c);
}

/// Predictor: how far does the step to mu = 0 lead? Sets mu and the weight of the second-order term.
void InteriorPoint::Impl::affine_step() {
  if (!predicts_) return;
  solve_linear();
  const auto ports = problem_.ports();
  const auto sum_products = [&] {
    for (const int c : running_) sum_[c] = 0;
    for (std::size_t b = 0; b < ports.size(); ++b)
      if (!port_lists_[b].running.empty()) ports[b]->complementarity(running(port_lists_[b]), alpha_, sum_);
  };
  for (const int c : running_) alpha_[c] = 0;
  sum_products();
  for (const int c : running_) {
    mu_[c] = sum_[c];
    alpha_[c] = std::min(1.0, 1.0 / ratio_[c]);
  }
  sum_products();
  for (const int c : running_) {
    if (degree_[c] == 0) continue;
    if (straight_to_floor(c)) {
      mu_[c] = floor_target(c);
      continue;
    }
    const double nu = mu_[c] / degree_[c], nu_affine = sum_[c] / degree_[c];
    const double reduction = std::clamp(nu_affine / nu, 0.0, 1.0);
    // After a short step the pairs are unbalanced: centre before going on.
    const double sigma = course_[c].last_alpha < centre_below ? std::max(centring, reduction) : reduction * reduction * reduction;
    mu_[c] = std::max(sigma * nu, mu_floor(c));
    correction_[c] = alpha_[c] > 0.1 ? 1 : 0;
  }
}

void InteriorPoint::Impl::combined_step() {
  if (predicts_) {
    for (const int c : running_) ratio_[c] = 0;
    right_hand_side();
  }
  solve_linear();
}

/// x += factor dx
void InteriorPoint::Impl::move_by(int c, double factor) {
  each_run(rows_of(c), [&](int first, int count) {
    kernels_->add_scaled(factor, dx_.data() + first, x_.data() + first, count);
  });
}

void InteriorPoint::Impl::copy_rows(std::span<const RowRange> ranges, std::span<const double> from, std::span<double> to) {
  each_run(ranges, [&](int first, int count) { std::copy_n(from.data() + first, count, to.data() + first); });
}

void InteriorPoint::Impl::take_step() {
  for (const int c : running_) alpha_[c] = 1;
  const auto terms = problem_.terms();
  for (std::size_t b = 0; b < terms.size(); ++b) terms[b]->bound_step(running(term_lists_[b]), x_, dx_, alpha_);
  for (const int c : running_) {
    course_[c].bounded = alpha_[c] < short_step;
    const double tau = std::max(0.995, 1 - error_[c]);
    if (ratio_[c] > tau) alpha_[c] = std::min(alpha_[c], tau / ratio_[c]);
  }
  const auto ports = problem_.ports();
  for (std::size_t b = 0; b < ports.size(); ++b)
    if (!port_lists_[b].running.empty()) ports[b]->accept(running(port_lists_[b]), alpha_);
  for (const int c : running_) {
    const double alpha = alpha_[c];
    move_by(c, alpha);
    course_[c].judged = 0;
    course_[c].short_steps = static_cast<char>(alpha < short_step ? course_[c].short_steps + 1 : 0);
  }
}

}  // namespace graphsolve
