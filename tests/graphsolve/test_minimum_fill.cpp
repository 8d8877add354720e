#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <set>
#include <vector>

#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
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

/// CPU time of this thread: waiting for a busy core does not count.
double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Best of three, so that others in the caches disturb less.
double seconds(const BlockGraph& graph) {
  double best = 1e9;
  for (int run = 0; run < 3; ++run) {
    const double begin = thread_time();
    EXPECT_EQ(minimum_fill_ordering(graph).forced, 0);
    best = std::min(best, thread_time() - begin);
  }
  return best;
}

TEST(MinimumFill, TimeOfHubsAndChainsGrowsWithTheirSizeNotItsSquare) {
  // 16 times the size: quadratic work would take 256 times as long. Caches and a busy machine may cost a few times.
  EXPECT_LT(seconds(families::star(64000)), 100 * seconds(families::star(4000)));
  EXPECT_LT(seconds(families::chain(64000)), 100 * seconds(families::chain(4000)));
}

}  // namespace test_minimum_fill
