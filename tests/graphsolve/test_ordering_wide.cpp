#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "ordering/counted_ordering.hpp"
#include "ordering/least_rows.hpp"
#include "ordering/quotient_graph.hpp"
#include "support/graph_families.hpp"

namespace test_ordering_wide {

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
  const int n = 16;
  const BlockGraph graph = families::chain(n);
  const Ordering ordering = wide_ordering(graph);
  for (int k = 0; k < n; ++k) EXPECT_EQ(graph.kind(ordering.sequence[k]), NodeKind::regular) << k;
  const Symbolic symbolic(graph, ordering);
  int changes = 0;
  for (int k = 1; k < n; ++k) changes += symbolic.pivot(k).coupled_rows != symbolic.pivot(k - 1).coupled_rows;
  EXPECT_EQ(changes, 1);  // the two ends, then all others
  // Every second link of those that are left, from round to round: half of them couple to two later ones.
  for (int k = n; k < n + 7; ++k) EXPECT_EQ(symbolic.parent(k) >= n + 7, true) << k;
}

/// Share of the couplings of pivots in packs of eight that lie in the pivot's own lane.
double side_by_side(const BlockGraph& graph, const Ordering& ordering) {
  const Symbolic symbolic(graph, ordering);
  int all = 0, beside = 0;
  for (int k = 0; k < symbolic.pivots(); ++k) {
    const Symbolic::Pivot& p = symbolic.pivot(k);
    if (p.stride != 8) continue;
    for (const int later : symbolic.coupled(k)) {
      const Symbolic::Pivot& other = symbolic.pivot(later);
      ++all;
      beside += other.stride == 8 && other.diagonal % 8 == p.diagonal % 8;
    }
  }
  return static_cast<double>(beside) / all;
}

/// Regular nodes alone, numbered in any order along the path; closed: a ring.
BlockGraph path(std::vector<int> number, bool closed) {
  BlockGraph graph;
  const int n = static_cast<int>(number.size());
  for (int i = 0; i < n; ++i) graph.add_node("n" + std::to_string(i), 3);
  for (int i = closed ? 0 : 1; i < n; ++i) graph.add_edge({number[i]}, {number[(i + n - 1) % n]});
  return graph;
}

TEST(WideOrdering, EightEqualSegmentsOfALongPathLieInTheLanes) {
  for (const int n : {100, 101, 103, 107, 150, 200, 333}) {
    EXPECT_GT(side_by_side(families::chain(n), wide_ordering(families::chain(n))), 0.77) << n;
    EXPECT_GT(side_by_side(families::loop(n), wide_ordering(families::loop(n))), 0.77) << n;
    EXPECT_GT(side_by_side(families::anchored_chain(n), wide_ordering(families::anchored_chain(n))), 0.77) << n;
  }
}

TEST(WideOrdering, SegmentsDoNotDependOnHowNodesAreNumbered) {
  std::mt19937 random(1);
  for (const bool closed : {false, true})
    for (const int n : {180, 222, 300}) {
      std::vector<int> number(n);
      std::iota(number.begin(), number.end(), 0);
      for (int trial = 0; trial < 5; ++trial, std::shuffle(number.begin(), number.end(), random)) {
        const BlockGraph graph = path(number, closed);
        const Ordering ordering = wide_ordering(graph);
        EXPECT_GT(side_by_side(graph, ordering), 0.75) << n << closed << trial;
        EXPECT_LE(counts(graph, ordering).tree_height, 5 + std::ceil(std::log2(n))) << n << closed << trial;
      }
    }
}

/// Paths between hubs, and one that leads nowhere.
TEST(WideOrdering, PathsThatHangOnOthersAreCutToo) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 3), b = graph.add_node("b", 3);
  graph.add_edge(a, b);
  const auto hang = [&](NodeId from, int n) {
    for (int i = 0; i < n; ++i) {
      const NodeId next = graph.add_node("p" + std::to_string(graph.size()), 3);
      graph.add_edge(from, next);
      from = next;
    }
    return from;
  };
  for (int i = 0; i < 3; ++i) graph.add_edge(hang(a, 220), b);
  hang(b, 220);
  EXPECT_GT(side_by_side(graph, wide_ordering(graph)), 0.75);
}

TEST(WideOrdering, OneRoundOfAStarTakesAllLeaves) {
  const BlockGraph graph = families::star(500);
  EXPECT_EQ(counts(graph, wide_ordering(graph)).tree_height, 3);
  EXPECT_EQ(counts(graph, wide_ordering(graph)).fill_blocks, 0);
}

TEST(WideOrdering, CostlessStatesAreNeverForced) {
  for (int seed = 1; seed <= 100; ++seed) EXPECT_EQ(wide_ordering(families::control(2 + seed % 30, seed)).forced, 0);
}

BlockGraph complete(int n) {
  BlockGraph graph;
  for (int i = 0; i < n; ++i) {
    graph.add_node("x" + std::to_string(i), 1 + i % 3);
    for (int k = 0; k < i; ++k) graph.add_edge({k}, {i});
  }
  return graph;
}

TEST(WideOrdering, OfACompleteGraphLooksAtEveryEdgeAFewTimes) {
  for (const int n : {10, 100, 400}) {
    const CountedOrdering result = counted_wide_ordering(complete(n));
    EXPECT_LE(result.walked, 3 * n * n) << n;
    for (int k = 0; k + 1 < n; ++k)  // large ones first, then as numbered
      EXPECT_TRUE(std::pair(-result.ordering.sequence[k].index % 3, result.ordering.sequence[k].index) <
                  std::pair(-result.ordering.sequence[k + 1].index % 3, result.ordering.sequence[k + 1].index)) << n << ", " << k;
  }
}

/// Stages x_i = f(x_(i-1), u_i) with an input of its own each.
BlockGraph stages(int n, NodeKind input, NodeKind last_state) {
  BlockGraph graph;
  NodeId before;
  for (int i = 0; i < n; ++i) {
    const std::string k = std::to_string(i);
    const NodeId u = graph.add_node("u" + k, 1, input);
    const NodeId x = graph.add_node("x" + k, 2, i + 1 < n ? NodeKind::regular : last_state);
    const NodeId d = graph.add_node("d" + k, 2, NodeKind::saddle);
    graph.add_edge(d, x, EdgeRank::full);
    graph.add_edge(d, u);
    if (i > 0) graph.add_edge(d, before, EdgeRank::full);
    before = x;
  }
  return graph;
}

/// Costless variables, and constraints on three of them each.
BlockGraph linear_program(int n) {
  BlockGraph graph;
  for (int i = 0; i < n; ++i) graph.add_node("x" + std::to_string(i), 1, NodeKind::semidefinite);
  for (int i = 0; i < n / 2; ++i) {
    const NodeId row = graph.add_node("r" + std::to_string(i), 1, NodeKind::saddle);
    for (const int k : {2 * i, 2 * i + 1, (2 * i + 2) % n}) graph.add_edge(row, {k});
  }
  return graph;
}

TEST(WideOrdering, WorkGrowsWithTheSizeNotItsSquareWhereNodesComeOneByOne) {
  const int n = 2000;
  const auto work = [](const BlockGraph& graph) {
    const CountedOrdering result = counted_wide_ordering(graph);
    return result.walked + result.waiting;
  };
  const auto one_costless = [](int m) { return stages(m, NodeKind::regular, NodeKind::semidefinite); };
  const auto costless_inputs = [](int m) { return stages(m, NodeKind::semidefinite, NodeKind::regular); };
  EXPECT_LE(work(one_costless(4 * n)), 5 * work(one_costless(n)));
  EXPECT_LE(work(costless_inputs(4 * n)), 5 * work(costless_inputs(n)));
  EXPECT_LE(work(linear_program(4 * n)), 5 * work(linear_program(n)));
  EXPECT_EQ(wide_ordering(linear_program(n)).forced, n);
}

TEST(LeastRows, AreThoseOfTheFirstNodeWithTheFewestWhateverWasEliminated) {
  std::mt19937 random(1);
  for (int seed = 1; seed <= 20; ++seed) {
    const BlockGraph graph = families::random_with_loops(80, 20 * seed, seed);
    QuotientGraph rest(graph);
    LeastRows rows(rest);
    for (int left = graph.size(); left > 0; --left) {
      if (left % 3 == 0) {  // not every time: several eliminations lie between two questions
        int least = -1;
        for (int i = 0; i < graph.size(); ++i)
          if (rest.alive(i) && (least < 0 || rest.rows_around(i) < rest.rows_around(least))) least = i;
        ASSERT_EQ(rows.least(), least) << "seed " << seed << ", left " << left;
      }
      int node = static_cast<int>(random() % graph.size());
      while (!rest.alive(node)) node = (node + 1) % graph.size();
      rows.change(rest.eliminate(node));
    }
  }
}

TEST(QuotientGraph, RowsAroundAreThoseOfTheNeighbours) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 40; ++trial) {
    const BlockGraph graph = trial == 0 ? complete(60) : families::random_with_loops(60, trial * trial / 4, trial);
    QuotientGraph rest(graph);
    std::vector<int> sequence(graph.size()), around;
    std::iota(sequence.begin(), sequence.end(), 0);
    std::shuffle(sequence.begin(), sequence.end(), random);
    for (const int gone : sequence) {
      rest.eliminate(gone);
      for (int i = 0; i < graph.size(); ++i) {
        if (!rest.alive(i)) continue;
        rest.neighbours(i, graph.size(), around);
        int rows = 0;
        for (const int k : around) rows += graph.dimension({k});
        ASSERT_EQ(rest.rows_around(i), rows) << trial << ", node " << i;
      }
    }
  }
}

}  // namespace test_ordering_wide
