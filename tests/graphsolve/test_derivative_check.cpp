#include "graphsolve/derivative_check.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "chain_terms.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/problem.hpp"

namespace test_derivative_check {

using namespace graphsolve;
using cases::chain;
using cases::ChainQuadratic;
using cases::Spoils;

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

}  // namespace test_derivative_check
