#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <limits>
#include <memory>
#include <numeric>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"

namespace test_one_pass {

using namespace graphsolve;
using cases::right_hand_side;
using cases::view;

/// The symmetric part of a dominant matrix.
Eigen::MatrixXd symmetric_matrix(const BlockGraph& graph, std::uint64_t seed) {
  const Eigen::MatrixXd a = families::dominant_matrix(graph, seed);
  return 0.5 * (a + a.transpose());
}

/// Equal chains side by side.
constexpr int links = 5, nodes_of_one = 2 * links - 1;
BlockGraph herd(int copies) {
  BlockGraph graph;
  for (int c = 0; c < copies; ++c) {
    NodeId last;
    for (int i = 0; i < links; ++i) {
      const NodeId node = graph.add_node("n", 6);
      if (i > 0) {
        const NodeId link = graph.add_node("l", 3, NodeKind::saddle);
        graph.add_edge(link, last, EdgeRank::full_row);
        graph.add_edge(link, node, EdgeRank::full_row);
      }
      last = node;
    }
  }
  return graph;
}

constexpr std::array kinds{FactorizationKind::ldu, FactorizationKind::ldlt, FactorizationKind::cholesky};

TEST(OnePass, GivesTheBitsOfTwo) {
  int seed = 0;
  for (const auto& [name, graph] : cases::all())
    for (const FactorizationKind kind : kinds)
      for (const Packs packs : {Packs::on, Packs::off}) {
        SCOPED_TRACE(name + ", kind " + std::to_string(static_cast<int>(kind)) + (packs == Packs::on ? ", packs" : ""));
        const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
        const Eigen::MatrixXd matrix = kind == FactorizationKind::ldu ? families::dominant_matrix(graph, ++seed)
                                                                      : symmetric_matrix(graph, ++seed);
        Factorization two(symbolic, kind), one(symbolic, kind);
        families::load(matrix, graph, *symbolic, two.values());
        families::load(matrix, graph, *symbolic, one.values());
        Eigen::VectorXd x = right_hand_side(graph.rows()), y = x;
        const auto expected = two.factorize();
        two.solve(view(x));
        const auto outcome = one.factorize_and_solve(view(y));
        EXPECT_EQ(outcome.ok(), expected.ok());
        EXPECT_EQ(outcome.operations, expected.operations);
        EXPECT_EQ(outcome.inertia, expected.inertia);
        if (!expected.ok()) continue;  // cholesky of a matrix with saddle nodes
        EXPECT_EQ(x, y);
        EXPECT_LE((matrix * y - right_hand_side(graph.rows())).norm(), 1e-9 * y.norm());
      }
}

TEST(OnePass, LeavesComponentsAloneThatTakeNoPartAndSpoilsNoneByOneThatFails) {
  const BlockGraph graph = herd(6);
  const int rows = graph.rows() / 6;
  const Eigen::MatrixXd matrix = families::dominant_matrix(graph, 3);
  for (const Packs packs : {Packs::on, Packs::off}) {
    const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
    ASSERT_EQ(symbolic->components(), 6);
    const auto component_of = [&](int copy) { return symbolic->component({copy * nodes_of_one}); };
    Factorization f(symbolic);
    families::load(matrix, graph, *symbolic, f.values());
    f.entry(symbolic->block({2 * nodes_of_one}, {2 * nodes_of_one})) = std::numeric_limits<double>::quiet_NaN();
    const Eigen::VectorXd right = right_hand_side(graph.rows());
    Eigen::VectorXd x = right;
    const std::array some{component_of(0), component_of(2), component_of(5)};
    const auto outcomes = f.factorize_and_solve(some, view(x));
    EXPECT_TRUE(outcomes[some[0]].ok());
    EXPECT_FALSE(outcomes[some[1]].ok());
    EXPECT_TRUE(outcomes[some[2]].ok());
    for (const int copy : {0, 5}) {
      const auto block = matrix.block(copy * rows, copy * rows, rows, rows);
      EXPECT_LE((block * x.segment(copy * rows, rows) - right.segment(copy * rows, rows)).norm(), 1e-10);
    }
    for (const int copy : {1, 3, 4}) EXPECT_EQ(x.segment(copy * rows, rows), right.segment(copy * rows, rows));
  }
}

TEST(OnePass, RefusesVectorsOfAnotherSize) {
  const BlockGraph graph = families::chain(4);
  Factorization f(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)));
  Eigen::VectorXd x = right_hand_side(graph.rows() + 1);
  EXPECT_THROW((void)f.factorize_and_solve(view(x)), std::invalid_argument);
}

}  // namespace test_one_pass
