#include "graphsolve/symbolic.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <limits>

#include "graphsolve/ordering_method.hpp"
#include "support/graph_families.hpp"

namespace test_symbolic {

using namespace graphsolve;

/// Structure of the factor by dense elimination of blocks: what Symbolic has to predict.
Eigen::MatrixXi eliminated_pattern(const BlockGraph& graph, const Symbolic& s) {
  const int n = graph.size();
  Eigen::MatrixXi pattern = Eigen::MatrixXi::Identity(n, n);
  for (int a = 0; a < n; ++a)
    for (const auto& edge : graph.edges({a})) pattern(s.position({a}), s.position(edge.to)) = 1;
  for (int k = 0; k < n; ++k)
    for (int i = k + 1; i < n; ++i)
      for (int j = k + 1; j < n; ++j)
        if (pattern(i, k) && pattern(k, j) && !pattern(i, j)) pattern(i, j) = 2;
  return pattern;
}

TEST(Symbolic, FillBlocksAreThoseOfDenseElimination) {
  for (int seed = 1; seed <= 100; ++seed) {
    const BlockGraph graph = families::random_with_loops(10, 5, seed);
    for (const Ordering& ordering : {natural_ordering(graph), depth_first_ordering(graph), minimum_fill_ordering(graph)}) {
      const Symbolic s(graph, ordering);
      const Eigen::MatrixXi pattern = eliminated_pattern(graph, s);
      int fill = 0;
      for (int k = 0; k < s.pivots(); ++k) {
        const auto coupled = s.coupled(k);
        int at = 0;
        for (int i = k + 1; i < s.pivots(); ++i) {
          if (!pattern(i, k)) continue;
          ASSERT_LT(at, static_cast<int>(coupled.size()));
          EXPECT_EQ(coupled[at], i);
          EXPECT_EQ(s.is_fill(k, at), pattern(i, k) == 2);
          fill += pattern(i, k) == 2;
          ++at;
        }
        EXPECT_EQ(at, static_cast<int>(coupled.size()));
      }
      EXPECT_EQ(s.counts().fill_blocks, fill);
    }
  }
}

TEST(Symbolic, TreesHaveNoFillAndTheirOperationsGrowByAConstantPerNode) {
  const auto operations = [](int n) {
    const BlockGraph graph = families::chain(n);
    const Symbolic s(graph, minimum_fill_ordering(graph));
    EXPECT_EQ(s.counts().fill_blocks, 0) << n;
    return s.counts().operations;
  };
  const auto step = operations(21) - operations(20);
  for (const int n : {50, 100, 500, 1000}) EXPECT_EQ(operations(n + 1) - operations(n), step) << n;
  for (int seed = 1; seed <= 50; ++seed) {
    const BlockGraph tree = families::random_tree(40, seed);
    EXPECT_EQ(Symbolic(tree, minimum_fill_ordering(tree)).counts().fill_blocks, 0) << seed;
  }
}

TEST(Symbolic, CountsOfOneDenseBlockAreThoseOfLU) {
  BlockGraph graph;
  graph.add_node("only", 6);
  const Symbolic s(graph, natural_ordering(graph));
  EXPECT_EQ(s.counts().operations, 6 + 15 + 55);  // reciprocals, multipliers, updates
  EXPECT_EQ(s.counts().stored_scalars, 36);
  EXPECT_EQ(s.counts().tree_height, 1);
}

TEST(Symbolic, CostsArePredictedWithoutAndNoFurtherThanAsked) {
  for (int seed = 1; seed <= 10; ++seed) {
    const BlockGraph graph = families::random_with_loops(40, 20, seed);
    const Ordering ordering = natural_ordering(graph);
    const Symbolic::Counts counts = Symbolic(graph, ordering).counts();
    const PredictedCost cost = predict_cost(graph, ordering);
    const PredictedCost some = predict_cost(graph, ordering, counts.fill_blocks / 2);
    EXPECT_EQ(cost.fill_blocks, counts.fill_blocks);
    EXPECT_EQ(cost.stored_scalars, counts.stored_scalars);
    EXPECT_EQ(cost.operations, counts.operations);
    EXPECT_LT(some.operations, cost.operations);
  }
}

TEST(Symbolic, TreeOrdersVouchForEverySaddleBlockAndLoopOrdersNotForAll) {
  const BlockGraph tree = families::balanced_tree(31), loop = families::loop(12);
  const Symbolic of_tree(tree, minimum_fill_ordering(tree)), of_loop(loop, minimum_fill_ordering(loop));
  int uncertain = 0;
  for (int k = 0; k < of_tree.pivots(); ++k) EXPECT_FALSE(of_tree.may_depend(k));
  for (int k = 0; k < of_loop.pivots(); ++k) uncertain += of_loop.may_depend(k);
  EXPECT_GE(uncertain, 1);
}

TEST(BlockGraph, RefusesWhatIsNoGraphByName) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 1);
  EXPECT_THROW(graph.add_node("empty", 0), std::invalid_argument);
  for (const int rows : {BlockGraph::largest_dimension + 1, 1'000'000, 2'000'000'000})
    EXPECT_THROW(graph.add_node("b", rows), std::invalid_argument) << "more than a dense block may have";
  EXPECT_THROW(graph.add_edge(a, a), std::invalid_argument);
  EXPECT_THROW(graph.add_edge(a, NodeId{1}), std::invalid_argument);
  EXPECT_EQ(graph.size(), 1);
  constexpr int largest = BlockGraph::largest_dimension;
  while (graph.rows() <= std::numeric_limits<int>::max() - largest) graph.add_node("b", largest);
  EXPECT_THROW(graph.add_node("c", largest), std::invalid_argument) << "the rows do not fit into an int";
}

/// A hub goes first and couples 1500 of the largest blocks: the order is absurd, and must not look cheap.
TEST(Symbolic, OperationsBeyondAllNumbersStayTheLargestOne) {
  BlockGraph graph;
  const NodeId hub = graph.add_node("hub", BlockGraph::largest_dimension);
  for (int k = 0; k < 1500; ++k) graph.add_edge(hub, graph.add_node("leaf", BlockGraph::largest_dimension));
  const Symbolic::Counts counts = Symbolic(graph, natural_ordering(graph)).counts();
  for (const std::int64_t operations : {counts.operations, counts.symmetric_operations, counts.pack_operations,
                                        counts.symmetric_pack_operations})
    EXPECT_EQ(operations, std::numeric_limits<std::int64_t>::max());
  const Symbolic::Counts chosen = Symbolic(graph, make_ordering(graph, OrderingMethod::best)).counts();
  EXPECT_EQ(chosen.fill_blocks, 0);
}

TEST(Symbolic, BlockWithoutAPlaceInTheFactorIsRefused) {
  const BlockGraph graph = families::chain(3);
  const Symbolic s(graph, natural_ordering(graph));
  EXPECT_THROW(static_cast<void>(s.block({0}, {2})), std::invalid_argument);
  EXPECT_THROW(Symbolic(graph, Ordering{.sequence = {{0}, {0}, {1}, {2}, {3}}}), std::invalid_argument);
  EXPECT_THROW(Symbolic(graph, Ordering{.sequence = {{0}}}), std::invalid_argument);
}

}  // namespace test_symbolic
