#include "graphsolve/supernodes.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <memory>

#include "graphsolve/factorization.hpp"
#include "support/graph_families.hpp"

namespace test_supernodes {

using namespace graphsolve;

/// Scalars on a square mesh: every row coupled with its four neighbours.
BlockGraph mesh(int side) {
  BlockGraph graph;
  for (int i = 0; i < side * side; ++i) graph.add_node("row " + std::to_string(i), 1);
  for (int i = 0; i < side * side; ++i) {
    if (i % side + 1 < side) graph.add_edge({i}, {i + 1});
    if (i + side < side * side) graph.add_edge({i}, {i + side});
  }
  return graph;
}

Eigen::MatrixXd permuted(const Eigen::MatrixXd& a, const std::vector<int>& row_of) {
  Eigen::MatrixXd b(a.rows(), a.cols());
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i) b(row_of[i], row_of[j]) = a(i, j);
  return b;
}

TEST(Supernodes, AFullMatrixOfScalarsBecomesBlocksOfTheLargestSizeWithoutZeros) {
  BlockGraph graph;
  for (int i = 0; i < 12; ++i) {
    graph.add_node("row", 1);
    for (int j = 0; j < i; ++j) graph.add_edge({i}, {j});
  }
  const Supernodes merged = merge_supernodes(graph, natural_ordering(graph), {.largest = 4, .zeros = 0, .always_below = 1});
  ASSERT_EQ(merged.graph.size(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(merged.graph.dimension({i}), 4);
  const Symbolic symbolic(merged.graph, merged.ordering);
  EXPECT_EQ(symbolic.counts().stored_scalars, 12 * 12);
  EXPECT_EQ(symbolic.counts().fill_blocks, 0);
}

TEST(Supernodes, NothingIsMergedWhereNoColumnsAreEqualAndNoZerosAllowed) {
  const BlockGraph graph = families::chain(10);
  const Supernodes merged = merge_supernodes(graph, minimum_fill_ordering(graph), {.largest = 48, .zeros = 0, .always_below = 1});
  ASSERT_EQ(merged.graph.size(), graph.size());  // kinds alternate along the chain
  for (int i = 0; i < graph.size(); ++i) {
    EXPECT_EQ(merged.graph.name(merged.node_of[i]), graph.name({i}));
    EXPECT_EQ(merged.graph.kind(merged.node_of[i]), graph.kind({i}));
  }
}

TEST(Supernodes, SolveTheSystemThatWasGiven) {
  for (const SupernodeSettings& settings : {SupernodeSettings{.largest = 2, .zeros = 0.2, .always_below = 1},
                                            SupernodeSettings{.largest = 4, .zeros = 0.1, .always_below = 2},
                                            SupernodeSettings{.largest = 9, .zeros = 0.5, .always_below = 9},
                                            SupernodeSettings{.largest = 48, .zeros = 1, .always_below = 1}})
    for (const auto& [graph, saddle] : {std::pair{mesh(9), false}, std::pair{families::ladder(20), true},
                                        std::pair{families::random_tree(30, 5), true}}) {
      const Eigen::MatrixXd a = saddle ? families::saddle_matrix(graph, 3) : families::dominant_matrix(graph, 3);
      const Supernodes merged = merge_supernodes(graph, minimum_fill_ordering(graph), settings);
      std::vector<int> rows = merged.row_of;
      std::sort(rows.begin(), rows.end());
      for (int i = 0; i < graph.rows(); ++i) ASSERT_EQ(rows[i], i);
      Factorization f(std::make_shared<const Symbolic>(merged.graph, merged.ordering));
      families::load(permuted(a, merged.row_of), merged.graph, f.symbolic(), f.values());
      ASSERT_TRUE(f.factorize().ok());
      const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(a.rows(), -1, 2);
      std::vector<double> x(a.rows());
      for (Eigen::Index i = 0; i < a.rows(); ++i) x[merged.row_of[i]] = b[i];
      f.solve(x);
      Eigen::VectorXd solution(a.rows());
      for (Eigen::Index i = 0; i < a.rows(); ++i) solution[i] = x[merged.row_of[i]];
      EXPECT_LE((a * solution - b).norm(), 1e-9 * b.norm());
    }
}

TEST(Supernodes, TheChosenOnesPromiseNoLessThanMergingNothingAndOnAMeshMore) {
  for (const BlockGraph& graph : {mesh(20), families::chain(50), families::grid(8), families::random_tree(40, 2)}) {
    const Ordering ordering = minimum_fill_ordering(graph);
    const Supernodes merged = merge_supernodes(graph, ordering);
    EXPECT_LE(predicted_time(merged.graph, merged.ordering), predicted_time(graph, ordering));
  }
  const BlockGraph graph = mesh(30);
  const Ordering ordering = minimum_fill_ordering(graph);
  const Supernodes merged = merge_supernodes(graph, ordering);
  EXPECT_LE(1.1 * predicted_time(merged.graph, merged.ordering), predicted_time(graph, ordering));
}

TEST(Supernodes, NodesThatAreLargerThanTheLargestStayAlone) {
  const BlockGraph graph = families::balanced_tree(15);
  const Supernodes merged = merge_supernodes(graph, minimum_fill_ordering(graph), {.largest = 2, .zeros = 1, .always_below = 2});
  EXPECT_EQ(merged.graph.size(), graph.size());
}

TEST(Supernodes, AnOrderingOfAnotherGraphIsRefused) {
  const BlockGraph graph = mesh(3);
  EXPECT_THROW(merge_supernodes(graph, natural_ordering(mesh(2))), std::invalid_argument);
  Ordering twice = natural_ordering(graph);
  twice.sequence[1] = twice.sequence[0];
  EXPECT_THROW(merge_supernodes(graph, twice), std::invalid_argument);
}

}  // namespace test_supernodes
