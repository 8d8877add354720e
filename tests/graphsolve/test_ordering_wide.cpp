#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "support/graph_families.hpp"

namespace {

using namespace graphsolve;

Symbolic::Counts counts(const BlockGraph& graph, const Ordering& ordering) {
  return Symbolic(graph, ordering).counts();
}

TEST(WideOrdering, TreeOfAChainIsLogarithmicallyHighAtAtMostTwoAndAHalfTimesTheOperations) {
  for (const int n : {10, 100, 1000, 10000, 100000}) {
    const BlockGraph graph = families::chain(n);
    const auto wide = counts(graph, wide_ordering(graph)), least = counts(graph, minimum_fill_ordering(graph));
    EXPECT_LE(wide.tree_height, 2 + std::ceil(std::log2(n))) << n;
    EXPECT_LE(static_cast<double>(wide.operations), 2.5 * static_cast<double>(least.operations)) << n;
  }
}

TEST(WideOrdering, TreesLoopsAndLaddersAreLowToo) {
  const BlockGraph loop = families::loop(1000), ladder = families::ladder(1000), tree = families::random_tree(1000, 1);
  EXPECT_LE(counts(loop, wide_ordering(loop)).tree_height, 13);
  EXPECT_LE(counts(ladder, wide_ordering(ladder)).tree_height, 25);
  EXPECT_LE(counts(tree, wide_ordering(tree)).tree_height, 40);
}

TEST(WideOrdering, OfAChainAllRegularNodesComeFirstWithEqualShapesSideBySide) {
  const int n = 64;
  const BlockGraph graph = families::chain(n);
  const Ordering ordering = wide_ordering(graph);
  for (int k = 0; k < n; ++k) EXPECT_EQ(graph.kind(ordering.sequence[k]), NodeKind::regular) << k;
  const Symbolic symbolic(graph, ordering);
  int changes = 0;
  for (int k = 1; k < n; ++k) changes += symbolic.pivot(k).coupled_rows != symbolic.pivot(k - 1).coupled_rows;
  EXPECT_EQ(changes, 1);  // the two ends, then all others
  // Every second link of those that are left, from round to round: half of them couple to two later ones.
  for (int k = n; k < n + 31; ++k) EXPECT_EQ(symbolic.parent(k) >= n + 31, true) << k;
}

TEST(WideOrdering, OneRoundOfAStarTakesAllLeaves) {
  const BlockGraph graph = families::star(500);
  EXPECT_EQ(counts(graph, wide_ordering(graph)).tree_height, 3);
  EXPECT_EQ(counts(graph, wide_ordering(graph)).fill_blocks, 0);
}

TEST(WideOrdering, CostlessStatesAreNeverForced) {
  for (int seed = 1; seed <= 100; ++seed) EXPECT_EQ(wide_ordering(families::control(2 + seed % 30, seed)).forced, 0);
}

}  // namespace
