#pragma once

#include <time.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "graph.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/io/block_view.hpp"
#include "graphsolve/largest.hpp"

namespace pose_graph {

inline double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Progress {
  double chi2 = 0, gradient = 0, damping = 0;  ///< gradient: largest entry of J' W e
};

struct Report {
  std::vector<Progress> steps;     ///< the start, then every accepted step
  int iterations = 0, damped = 0;  ///< factorizations; those of them with damping
  double seconds_per_iteration = 0;
  double reduction = 0;    ///< of the gradient, last over first
  bool at_rounding = false;  ///< the next step promised less than 1e-16 of chi^2
  /// Are chi^2 and gradient numbers in the end? Else the file's are too large to be squared.
  [[nodiscard]] bool finite() const { return std::isfinite(steps.back().chi2) && std::isfinite(steps.back().gradient); }
};

/// Gauss-Newton for  min 1/2 sum e' W e  over all poses but the first, which is held:
///   (J' W J + damping D) d = -J' W e,   pose <- pose moved by d,
/// D = diag(J' W J). Damping is zero until a step does not lower chi^2; then it rises, and falls again with success.
/// One node of the BlockGraph per pose, one edge per pair of poses that measure each other.
template <class S>
class Optimizer {
 public:
  using Pose = typename S::Pose;
  using Matrix = typename S::Matrix;
  using Vector = typename S::Vector;

  explicit Optimizer(const Graph<S>& graph) : graph_(graph) {
    graphsolve::BlockGraph blocks;
    for (int k = 1; k < graph.poses; ++k) blocks.add_node("pose " + std::to_string(k), S::size);
    for (const auto& e : graph.edges)
      if (e.from > 0 && e.to > 0) blocks.add_edge(node(e.from), node(e.to));
    symbolic_ = std::make_shared<const graphsolve::Symbolic>(blocks, graphsolve::minimum_fill_ordering(blocks));
    factorization_ = std::make_unique<graphsolve::Factorization>(symbolic_, graphsolve::FactorizationKind::cholesky);
    for (const auto& e : graph.edges) {
      const auto block = [&](int a, int b) {
        return a > 0 && b > 0 ? symbolic_->block(node(a), node(b)) : graphsolve::BlockHandle{};
      };
      places_.push_back({block(e.from, e.from), block(e.from, e.to), block(e.to, e.from), block(e.to, e.to)});
    }
    step_.resize(symbolic_->rows());
    gradient_.resize(symbolic_->rows());
  }
  [[nodiscard]] const graphsolve::Symbolic& symbolic() const { return *symbolic_; }

  [[nodiscard]] double chi2(const std::vector<Pose>& pose) const {
    double sum = 0;
    for (const auto& e : graph_.edges) {
      const Vector error = S::error(e.measured, pose[e.from], pose[e.to], nullptr, nullptr);
      sum += error.dot(e.information * error);
    }
    return sum;
  }

  /// In: start. Out: the least chi^2 found. Ends when the gradient has fallen by `reduction` or no step helps.
  Report run(std::vector<Pose>& pose, double reduction = 1e-10, int most_iterations = 200) {
    Report report;
    std::vector<Pose> trial;
    double now = chi2(pose), damping = 0, spent = 0;
    linearize(pose);
    report.steps.push_back({now, largest_gradient(), 0});
    while (report.iterations < most_iterations && largest_gradient() > reduction * report.steps[0].gradient &&
           !report.at_rounding) {
      const double begin = thread_seconds();
      const bool factored = solve(damping);
      report.at_rounding = factored && damping == 0 && promise() <= 1e-16 * now;
      trial = pose;
      for (int k = 1; k < graph_.poses && factored; ++k)
        trial[k] = S::retract(pose[k], Eigen::Map<const Vector>(&step_[S::size * (k - 1)]));
      const double then = factored ? chi2(trial) : NAN;
      ++report.iterations;
      report.damped += damping > 0;
      if (then <= now * (1 + 1e-13)) {
        pose.swap(trial);
        now = then;
        damping = damping > 1e-7 ? 0.1 * damping : 0;
        linearize(pose);
        report.steps.push_back({now, largest_gradient(), damping});
      } else {
        damping = damping > 0 ? 10 * damping : 1e-6;
        linearize(pose);  // factorize() has overwritten the matrix
        if (damping > 1e6) break;
      }
      spent += thread_seconds() - begin;
    }
    report.seconds_per_iteration = report.iterations > 0 ? spent / report.iterations : 0;
    // A start without any gradient is a solution.
    report.reduction = report.steps[0].gradient > 0 ? report.steps.back().gradient / report.steps[0].gradient : 0;
    return report;
  }

 private:
  static graphsolve::NodeId node(int pose) { return {pose - 1}; }
  struct Place {
    graphsolve::BlockHandle from_from, from_to, to_from, to_to;  ///< offset -1: the held pose
  };

  void linearize(const std::vector<Pose>& pose) {
    factorization_->set_zero();
    std::fill(gradient_.begin(), gradient_.end(), 0.0);
    const auto add = [&](const graphsolve::BlockHandle& block, const Matrix& m) {
      if (block.offset >= 0) graphsolve::block_view(factorization_->values(), block) += m;
    };
    Matrix by_from, by_to;
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      const auto& e = graph_.edges[k];
      const Place& p = places_[k];
      const Vector error = S::error(e.measured, pose[e.from], pose[e.to], &by_from, &by_to);
      const Matrix weighted_from = e.information * by_from, weighted_to = e.information * by_to;
      const Matrix across = by_from.transpose() * weighted_to;
      add(p.from_from, by_from.transpose() * weighted_from);
      add(p.to_to, by_to.transpose() * weighted_to);
      add(p.from_to, across);
      add(p.to_from, across.transpose());
      if (e.from > 0) gradient(e.from) += weighted_from.transpose() * error;
      if (e.to > 0) gradient(e.to) += weighted_to.transpose() * error;
    }
  }
  Eigen::Map<Vector> gradient(int pose) { return Eigen::Map<Vector>(&gradient_[S::size * (pose - 1)]); }

  bool solve(double damping) {
    for (int k = 1; k < graph_.poses && damping > 0; ++k)
      graphsolve::block_view(factorization_->values(), symbolic_->block(node(k), node(k))).diagonal() *= 1 + damping;
    if (!factorization_->factorize().ok()) return false;
    for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = -gradient_[i];
    factorization_->solve(step_);
    return true;
  }
  /// By how much the step lowers chi^2 if the errors were linear.
  [[nodiscard]] double promise() const {
    double sum = 0;
    for (std::size_t i = 0; i < step_.size(); ++i) sum -= step_[i] * gradient_[i];
    return sum;
  }
  [[nodiscard]] double largest_gradient() const {
    double largest = 0;
    for (const double g : gradient_) graphsolve::keep_largest(largest, std::abs(g));
    return largest;
  }

  const Graph<S>& graph_;
  std::shared_ptr<const graphsolve::Symbolic> symbolic_;
  std::unique_ptr<graphsolve::Factorization> factorization_;
  std::vector<Place> places_;
  std::vector<double> step_, gradient_;
};

}  // namespace pose_graph
