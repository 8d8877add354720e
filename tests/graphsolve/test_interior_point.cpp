#include "graphsolve/interior_point.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <limits>

#include "chain_terms.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"
#include "support/dense.hpp"

namespace test_interior_point {

using namespace graphsolve;
using cases::chain;
using cases::ChainQuadratic;
using cases::Spoils;

/// Accelerated projected gradient: slow, sure, and nothing like an interior point.
Eigen::VectorXd projected_gradient(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, double low, double high) {
  const double step = 1 / dense::eigenvalues(h).maxCoeff();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(g.size()), y = x;
  double t = 1;
  for (int k = 0; k < 20000; ++k) {
    const Eigen::VectorXd next = (y - step * (h * y + g)).cwiseMax(low).cwiseMin(high);
    const double faster = 0.5 * (1 + std::sqrt(1 + 4 * t * t));
    // Restart the momentum where it points uphill: without it ill-conditioned cases oscillate.
    if ((y - next).dot(next - x) > 0) t = 1, y = next;
    else y = next + (t - 1) / faster * (next - x), t = faster;
    x = next;
  }
  return x;
}

TEST(InteriorPoint, BoxConstrainedQuadraticProgramsMatchProjectedGradient) {
  int at_bound = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const int nodes = 8;
    ChainQuadratic cost(nodes, seed);
    PortLawBatch<Bound, Nonnegative> bounds;
    for (int i = 0; i < nodes; ++i)
      for (int k = 0; k < 2; ++k) {
        bounds.add(Bound({i}, k, Bound::Side::lower, -0.5), Nonnegative());
        bounds.add(Bound({i}, k, Bound::Side::upper, 0.7), Nonnegative());
      }
    Problem problem(chain(nodes));
    problem.add(cost);
    problem.add(bounds);
    InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())),
                         {.tolerance = 1e-10});
    std::vector<double> x(2 * nodes, 0.0);
    ASSERT_EQ(solver.solve(x), Status::solved) << seed;
    const Eigen::VectorXd expected = projected_gradient(cost.h, cost.g, -0.5, 0.7);
    for (int i = 0; i < 2 * nodes; ++i) {
      EXPECT_NEAR(x[i], expected[i], 1e-6) << "seed " << seed << ", unknown " << i;
      at_bound += expected[i] < -0.5 + 1e-9 || expected[i] > 0.7 - 1e-9;
    }
    EXPECT_LE(solver.reports()[0].iterations, 25);
    // Solving again from the solution costs next to nothing.
    ASSERT_EQ(solver.solve(x), Status::solved);
    EXPECT_LE(solver.reports()[0].iterations, 1);
  }
  EXPECT_GT(at_bound, 20);
}

TEST(InteriorPoint, WithoutActivePortsOneNewtonStepSolvesALinearProblem) {
  ChainQuadratic cost(5, 3);
  Problem problem(chain(5));
  problem.add(cost);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
  std::vector<double> x(10, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  EXPECT_EQ(solver.reports()[0].iterations, 1);
  const Eigen::VectorXd expected = -dense::solve(cost.h, cost.g);
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(x[i], expected[i], 1e-9);
}

TEST(InteriorPoint, ContradictingBoundsAreNotSolvedAndTheStartIsKept) {
  ChainQuadratic cost(2, 5);
  PortLawBatch<Bound, Nonnegative> bounds;
  bounds.add(Bound({0}, 0, Bound::Side::lower, 1), Nonnegative());
  bounds.add(Bound({0}, 0, Bound::Side::upper, -1), Nonnegative());
  Problem problem(chain(2));
  problem.add(cost);
  problem.add(bounds);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
  std::vector<double> x{0.1, 0.2, 0.3, 0.4};
  const auto start = x;
  const Status status = solver.solve(x);
  EXPECT_TRUE(status == Status::stalled || status == Status::max_iterations) << name(status);
  EXPECT_EQ(x, start);
  EXPECT_FALSE(explanation(status).empty());
}

/// Adds nothing; keeps |x_0| below a bound.
class KeepsWithin final : public Term {
 public:
  explicit KeepsWithin(double bound) : bound_(bound) {}
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] std::span<const NodeId> nodes(int) const override { return {&node_, 1}; }
  void wire(const Wiring&) override {}
  void evaluate(Instances, std::span<const double>, std::span<double>, double*) override {}
  void bound_step(Instances instances, std::span<const double> x, std::span<const double> dx,
                  std::span<double> alpha) const override {
    double& a = alpha[instances.component[0]];
    if (!instances.index.empty() && std::abs(x[0] + a * dx[0]) > bound_)
      a = 0.99 * (bound_ - x[0] * std::copysign(1.0, dx[0])) / std::abs(dx[0]);
  }

 private:
  NodeId node_{0};
  double bound_;
};

TEST(InteriorPoint, ASolutionBeyondTheBoundOnTheStepIsReportedAsSuch) {
  for (const bool with_ports : {false, true}) {
    ChainQuadratic cost(2, 5);
    const Eigen::VectorXd free = -dense::solve(cost.h, cost.g);
    PortLawBatch<Bound, Nonnegative> bounds;
    if (with_ports) bounds.add(Bound({1}, 0, Bound::Side::lower, free[2] - 1), Nonnegative());
    const double solution = std::abs(free[0]);
    ASSERT_GT(solution, 0.1);
    for (const double bound : {0.5 * solution, 2 * solution}) {
      KeepsWithin within(bound);
      Problem problem(chain(2));
      problem.add(cost);
      problem.add(within);
      if (with_ports) problem.add(bounds);
      InteriorPoint solver(problem,
                           std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
      std::vector<double> x(4, 0.0);
      EXPECT_EQ(solver.solve(x), bound < solution ? Status::step_bound : Status::solved) << with_ports;
      if (bound >= solution) continue;
      EXPECT_EQ(x, std::vector<double>(4, 0.0)) << "the start is kept";
    }
  }
}

TEST(InteriorPoint, StartsAndNoiseOfAnotherLengthAreRefused) {
  ChainQuadratic cost(2, 5);
  Problem problem(chain(2));
  problem.add(cost);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
  std::vector<double> x(4, 0.0), shorter(3, 0.0), longer(5, 0.0);
  EXPECT_THROW((void)solver.solve(shorter), std::invalid_argument);
  EXPECT_THROW((void)solver.solve(longer), std::invalid_argument);
  EXPECT_THROW((void)solver.solve(x, 1, std::vector<double>{0, 0}), std::invalid_argument);
  EXPECT_EQ(solver.solve(x, 1, std::vector<double>{0}), Status::solved);
}

TEST(InteriorPoint, NotANumberIsReportedAsSuch) {
  ChainQuadratic cost(2, 5);
  cost.g[1] = std::numeric_limits<double>::quiet_NaN();
  Problem problem(chain(2));
  problem.add(cost);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
  std::vector<double> x(4, 0.0);
  EXPECT_EQ(solver.solve(x), Status::not_finite);
  EXPECT_EQ(x, std::vector<double>(4, 0.0));
}

TEST(InteriorPoint, ANumberAfterNotANumberDoesNotHideIt) {
  for (const bool with_ports : {false, true}) {
    ChainQuadratic cost(3, 5);
    Spoils spoils;
    PortLawBatch<Bound, Nonnegative> bounds;
    bounds.add(Bound({2}, 0, Bound::Side::lower, -100), Nonnegative());
    Problem problem(chain(3));
    problem.add(cost);
    problem.add(spoils);
    if (with_ports) problem.add(bounds);
    InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
    // At the solution of all that is a number: only the first row can tell.
    const Eigen::VectorXd solution = -dense::solve(cost.h, cost.g);
    std::vector<double> x(solution.begin(), solution.end());
    EXPECT_EQ(solver.solve(x), Status::not_finite) << with_ports;
  }
}

TEST(InteriorPoint, SingularProblemIsReportedAsSuch) {
  ChainQuadratic cost(2, 5);
  cost.h.setZero();
  Problem problem(chain(2));
  problem.add(cost);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())));
  std::vector<double> x(4, 0.0);
  EXPECT_EQ(solver.solve(x), Status::singular);
}

TEST(Status, EveryOneHasANameAndAllButSolvedAnExplanation) {
  for (const Status status : {Status::solved, Status::max_iterations, Status::stalled, Status::singular,
                              Status::not_finite, Status::step_bound}) {
    EXPECT_FALSE(name(status).empty());
    EXPECT_EQ(explanation(status).empty(), status == Status::solved);
  }
}

}  // namespace test_interior_point
