#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "ordering/counted_ordering.hpp"
#include "ordering/sorted_runs.hpp"
#include "support/graph_families.hpp"

namespace test_minimum_fill {

using namespace graphsolve;

double fill_factor(const BlockGraph& graph) {
  return families::fill_factor(Symbolic(graph, minimum_fill_ordering(graph)));
}

TEST(MinimumFill, ChainHasNoFill) { EXPECT_EQ(fill_factor(families::chain(1000)), 1.0); }
TEST(MinimumFill, TreesHaveNoFill) {
  EXPECT_EQ(fill_factor(families::balanced_tree(1000)), 1.0);
  EXPECT_EQ(fill_factor(families::quadruped()), 1.0);
  EXPECT_EQ(fill_factor(families::star(1000)), 1.0);
  for (int seed = 1; seed <= 20; ++seed) EXPECT_EQ(fill_factor(families::random_tree(200, seed)), 1.0);
}

TEST(MinimumFill, FillOfTheFamiliesIsWithinTheBars) {
  const struct {
    const char* name;
    BlockGraph graph;
    double bar;
  } cases[] = {{"loop", families::loop(1000), 1.30},
               {"ladder", families::ladder(1000), 1.45},
               {"grid, links of 1", families::grid(32), 1.7},
               {"grid, links of 3", families::grid(32, 3), 3.5}};
  for (const auto& c : cases) {
    const double fill = fill_factor(c.graph);
    std::printf("             %-16s fill %.3f\n", c.name, fill);
    EXPECT_LE(fill, c.bar) << c.name;
  }
}

/// Elimination graph the obvious way.
class Replay {
 public:
  explicit Replay(const BlockGraph& graph)
      : rule(graph), graph_(graph), around_(graph.size()), alive_(graph.size(), 1) {
    for (int i = 0; i < graph.size(); ++i)
      for (const auto& edge : graph.edges({i})) around_[i].insert(edge.to.index);
  }
  [[nodiscard]] std::int64_t fill(int node) const {
    std::int64_t sum = 0;
    for (const int a : around_[node])
      for (const int b : around_[node])
        if (a < b && !around_[a].contains(b)) sum += std::int64_t{1} * graph_.dimension({a}) * graph_.dimension({b});
    return sum;
  }
  /// Least fill among the nodes that may come next and have at most 12 neighbours; `otherwise` when there is none.
  [[nodiscard]] std::int64_t least_fill(std::int64_t otherwise) const {
    for (int i = 0; i < graph_.size(); ++i)
      if (alive_[i] && rule.eligible({i}) && around_[i].size() <= 12) otherwise = std::min(otherwise, fill(i));
    return otherwise;
  }
  void eliminate(NodeId node) {
    alive_[node.index] = 0;
    for (const int a : around_[node.index]) {
      for (const int b : around_[node.index])
        if (a != b) around_[a].insert(b);
      around_[a].erase(node.index);
    }
    std::vector<NodeId> freed;
    rule.eliminate(node, freed);
  }
  Eligibility rule;

 private:
  const BlockGraph& graph_;
  std::vector<std::set<int>> around_;
  std::vector<char> alive_;
};

TEST(MinimumFill, NoEligibleNodeOfSmallDegreeWouldEverAddLess) {
  int steps = 0;
  for (int seed = 1; seed <= 12; ++seed)
    for (const BlockGraph& graph : {families::random_with_loops(60, 60 + 20 * seed, seed),
                                    families::grid(3 + seed % 5, 3), families::random_tree(60, seed)}) {
      Replay replay(graph);
      for (const NodeId node : minimum_fill_ordering(graph).sequence) {
        const std::int64_t fill = replay.fill(node.index);
        ASSERT_TRUE(replay.rule.eligible(node));
        ASSERT_EQ(replay.least_fill(fill), fill) << "seed " << seed << " node " << node.index;
        replay.eliminate(node);
        ++steps;
      }
    }
  EXPECT_GT(steps, 5000);
}

TEST(MinimumFill, EqualGraphsGetEqualOrders) {
  for (int seed = 1; seed <= 10; ++seed)
    EXPECT_EQ(minimum_fill_ordering(families::random_with_loops(200, 80, seed)).sequence,
              minimum_fill_ordering(families::random_with_loops(200, 80, seed)).sequence);
}

TEST(MinimumFill, IndependentNeighboursOfAStarLieSideBySide) {
  const int leaves = 6;  // node 0 is the hub, 1 .. 6 the leaves, 7 .. 12 their links
  std::vector<int> order;
  for (const NodeId node : minimum_fill_ordering(families::star(leaves)).sequence) order.push_back(node.index);
  // With one link left the hub adds no fill either, and it has been free for longer.
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 12}));
}

TEST(MinimumFill, ControlWithCostAtTheEndIsNeverForced) {
  for (int seed = 1; seed <= 100; ++seed)
    EXPECT_EQ(minimum_fill_ordering(families::control(2 + seed % 30, seed)).forced, 0);
}

TEST(SortedRuns, HoldWhatASetHoldsAndTakeInNumbersOneByOneAtFewMoves) {
  std::mt19937 random(1);
  for (const int n : {50, 5000, 50000}) {
    SortedRuns runs;
    std::set<int> set;
    std::vector<int> scratch;
    std::size_t written = 0;
    for (int k = 0; k < n; ++k) {
      const int number = static_cast<int>(random() % (2 * n));
      EXPECT_EQ(runs.contains(number), set.contains(number));
      if (set.insert(number).second) written += runs.add(std::vector{number}, scratch);
      if (k % (n / 3) == n / 4) {
        const auto odd = [](int i) { return i % 2 != 0; };
        runs.erase_if(odd);
        std::erase_if(set, odd);
      }
    }
    EXPECT_LE(static_cast<double>(written), n * (64 + 3 * std::log2(n))) << n;
    std::vector<int> entries = runs.entries();
    std::ranges::sort(entries);
    EXPECT_TRUE(std::ranges::equal(entries, set)) << n;
  }
}

/// Stages x_i = f(x_(i-1), u_i, T): the final time T is in the constraint of every one.
BlockGraph control_with_final_time(int stages, int position) {
  BlockGraph graph;
  NodeId state, time;
  std::vector<NodeId> constraints;
  for (int i = 0; i < stages; ++i) {
    if (i == position) time = graph.add_node("T", 1, NodeKind::shared);
    const std::string k = std::to_string(i);
    const NodeId input = graph.add_node("u" + k, 1), next = graph.add_node("x" + k, 2);
    constraints.push_back(graph.add_node("d" + k, 2, NodeKind::saddle));
    graph.add_edge(constraints.back(), next, EdgeRank::full);
    graph.add_edge(constraints.back(), input);
    if (i > 0) graph.add_edge(constraints.back(), state, EdgeRank::full);
    state = next;
  }
  for (const NodeId constraint : constraints) graph.add_edge(constraint, time);
  return graph;
}

TEST(MinimumFill, WorkOfHubsAndChainsGrowsWithTheirSizeNotItsSquare) {
  const auto walked = [](const BlockGraph& graph) { return counted_minimum_fill_ordering(graph).walked; };
  const int n = 4000;
  EXPECT_LE(walked(families::star(4 * n)), 5 * walked(families::star(n)));
  EXPECT_LE(walked(families::chain(4 * n)), 5 * walked(families::chain(n)));
  for (const double place : {0.0, 0.5, 0.999}) {
    const auto graph = [&](int stages) { return control_with_final_time(stages, static_cast<int>(place * stages)); };
    EXPECT_LE(walked(graph(4 * n)), 5 * walked(graph(n))) << place;
  }
}

}  // namespace test_minimum_fill
