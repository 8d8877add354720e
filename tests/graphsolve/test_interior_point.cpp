#include "graphsolve/interior_point.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <limits>
#include <random>

#include "graphsolve/bound.hpp"
#include "graphsolve/derivative_check.hpp"
#include "graphsolve/io/block_view.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"
#include "support/dense.hpp"

namespace test_interior_point {

using namespace graphsolve;

/// Gradient of 1/2 x' H x + g' x on a chain of nodes of two unknowns: diagonal and coupling blocks of H.
class ChainQuadratic final : public Term {
 public:
  ChainQuadratic(int nodes, std::uint64_t seed) : h(2 * nodes, 2 * nodes), g(2 * nodes), nodes_(nodes) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    h.setZero();
    for (int i = 0; i < nodes; ++i) {
      const int rows = i + 1 < nodes ? 4 : 2;
      const Eigen::MatrixXd m = Eigen::MatrixXd::NullaryExpr(rows, rows, [&] { return normal(random); });
      h.block(2 * i, 2 * i, rows, rows) += m * m.transpose() + 0.1 * Eigen::MatrixXd::Identity(rows, rows);
    }
    for (auto& value : g) value = 3 * normal(random);
    for (int i = 0; i + 1 < nodes; ++i) pairs_.push_back({NodeId{i}, NodeId{i + 1}});
  }
  Eigen::MatrixXd h;
  Eigen::VectorXd g;

  [[nodiscard]] int size() const override { return static_cast<int>(pairs_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override { return pairs_[i]; }
  void wire(const Wiring& wiring) override {
    blocks_.clear();
    for (int i = 0; i < nodes_; ++i)
      for (int j = std::max(0, i - 1); j <= std::min(nodes_ - 1, i + 1); ++j)
        blocks_.push_back({i, j, wiring.block({i}, {j})});
  }
  /// All instances belong to one component: the first carries the whole product.
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override {
    if (instances.index.empty()) return;
    const Eigen::Map<const Eigen::VectorXd> at(x.data(), h.rows());
    Eigen::Map<Eigen::VectorXd>(residual.data(), h.rows()) += h * at + g;
    for (const auto& b : blocks_)
      if (values) block_view(values, b.handle) += h.block<2, 2>(2 * b.row, 2 * b.column);
  }

 private:
  struct Block {
    int row, column;
    BlockHandle handle;
  };
  int nodes_;
  std::vector<std::array<NodeId, 2>> pairs_;
  std::vector<Block> blocks_;
};

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

BlockGraph chain(int nodes) {
  BlockGraph graph;
  for (int i = 0; i < nodes; ++i) graph.add_node("x" + std::to_string(i), 2);
  return graph;
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

/// Adds nothing; its residual in row 0 is not a number.
class Spoils final : public Term {
 public:
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] std::span<const NodeId> nodes(int) const override { return {&node_, 1}; }
  void wire(const Wiring&) override {}
  void evaluate(Instances, std::span<const double>, std::span<double> residual, double*) override {
    residual[0] = std::numeric_limits<double>::quiet_NaN();
  }

 private:
  NodeId node_{0};
};

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

TEST(DerivativeCheck, AcceptsARightTermAndNamesTheWrongEntryOfAWrongOne) {
  ChainQuadratic cost(3, 9);
  Problem problem(chain(3));
  problem.add(cost);
  const std::vector<double> x{0.3, -0.1, 0.5, 0.2, -0.4, 0.1};
  EXPECT_LE(check_terms(problem, x).largest_error, 1e-8);

  class Wrong final : public Term {
   public:
    [[nodiscard]] int size() const override { return 1; }
    [[nodiscard]] std::span<const NodeId> nodes(int) const override { return {&node_, 1}; }
    void wire(const Wiring& wiring) override { block_ = wiring.block(node_, node_); }
    void evaluate(Instances, std::span<const double> at, std::span<double> residual, double* values) override {
      residual[2] += at[3] * at[3];
      if (values) values[block_.place(0, 1)] += 2.1 * at[3];  // entry (0, 1): should be 2 x_3
    }

   private:
    NodeId node_{1};
    BlockHandle block_;
  } wrong;
  problem.add(wrong);
  const auto report = check_terms(problem, x);
  EXPECT_GT(report.largest_error, 1e-3);
  EXPECT_EQ(report.where, "row 0 of 'x1' by column 1 of 'x1'");
}

TEST(DerivativeCheck, ANumberAfterNotANumberDoesNotHideIt) {
  ChainQuadratic cost(3, 5);
  Spoils spoils;
  Problem problem(chain(3));
  problem.add(cost);
  problem.add(spoils);
  EXPECT_TRUE(std::isnan(check_terms(problem, std::vector(6, 0.1)).largest_error));

  struct NoSlope : Bound {
    using Bound::Bound;
    void rate(const double*, double* du) const { du[0] = std::nan(""); }
  };
  BlockGraph graph;
  const NodeId node = graph.add_node("x", 1);
  NoSlope port(node, 0, Bound::Side::lower, 0);
  port.wire(Wiring(Symbolic(graph, natural_ordering(graph)), graph));
  EXPECT_TRUE(std::isnan(check_port(port, std::vector{0.1}).largest_error));
}

TEST(DerivativeCheck, NonnegativeLawAndBoundPortAreConsistent) {
  Nonnegative law(2.0, 1e300);
  law.start_cold(0.7, 2.0);
  const double u[] = {0.3}, du[] = {-0.2};
  EXPECT_LE(check_law(law, u, du, 0.01).largest_error, 1e-4);

  BlockGraph graph;
  const NodeId node = graph.add_node("x", 3);
  const Symbolic symbolic(graph, natural_ordering(graph));
  Bound bound(node, 1, Bound::Side::upper, 0.4);
  bound.wire(Wiring(symbolic, graph));
  const std::vector<double> x{0.1, 0.2, 0.3};
  EXPECT_LE(check_port(bound, x).largest_error, 1e-9);
}

/// u = x_a + 2 y_b - 3 x_c of nodes of one, two and one rows. `wrong`: its condensed block of b and c is transposed in sign.
struct Three {
  static constexpr int rows = 1;
  static constexpr std::array slope{1.0, 2.0, -3.0};
  std::array<NodeId, 3> nodes;
  bool wrong = false;
  std::array<int, 3> row{};
  std::int64_t place[3][3] = {};

  void wire(const Wiring& wiring) {
    for (int a = 0; a < 3; ++a) {
      row[a] = wiring.row(nodes[a]) + (a == 1 ? 1 : 0);
      for (int b = 0; b < 3; ++b) place[a][b] = wiring.block(nodes[a], nodes[b]).place(a == 1 ? 1 : 0, b == 1 ? 1 : 0);
    }
  }
  void evaluate(std::span<const double> x, double* u) const { rate(x.data(), u); }
  void rate(const double* dx, double* du) const {
    du[0] = 0;
    for (int a = 0; a < 3; ++a) du[0] += slope[a] * dx[row[a]];
  }
  void add_force(const double* f, double* residual, double sign) const {
    for (int a = 0; a < 3; ++a) residual[row[a]] += sign * slope[a] * f[0];
  }
  void add_condensed(const double* k, double* values) const {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) values[place[a][b]] += (wrong && a == 1 && b == 2 ? -1 : 1) * slope[a] * k[0] * slope[b];
  }
};

TEST(DerivativeCheck, JudgesAPortOverSeveralNodesOfAGraphThatHasMore) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 1), other = graph.add_node("other", 3), b = graph.add_node("b", 2), c = graph.add_node("c", 1);
  graph.add_edge(a, b);
  graph.add_edge(b, c);
  graph.add_edge(a, c);
  graph.add_edge(other, b);
  const Symbolic symbolic(graph, minimum_fill_ordering(graph));
  const std::vector<double> x{0.1, 7, 8, 9, 0.2, 0.3, 0.4};
  for (const bool wrong : {false, true}) {
    Three port{{a, b, c}, wrong};
    port.wire(Wiring(symbolic, graph));
    const DerivativeReport report = check_port(port, symbolic, x);
    if (!wrong) EXPECT_LE(report.largest_error, 1e-9) << report.where;
    else EXPECT_EQ(report.where, "condensed entry 5, 6");
  }
}

TEST(Status, EveryOneHasANameAndAllButSolvedAnExplanation) {
  for (const Status status : {Status::solved, Status::max_iterations, Status::stalled, Status::singular,
                              Status::not_finite, Status::step_bound}) {
    EXPECT_FALSE(name(status).empty());
    EXPECT_EQ(explanation(status).empty(), status == Status::solved);
  }
}

}  // namespace test_interior_point
