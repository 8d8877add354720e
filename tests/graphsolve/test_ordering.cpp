#include "graphsolve/ordering.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <random>
#include <stdexcept>

#include "graphsolve/symbolic.hpp"
#include "support/graph_families.hpp"

namespace {

using namespace graphsolve;

/// Smallest singular value over norm of all pivot blocks, eliminating a dense matrix block by block.
double worst_pivot(const BlockGraph& graph, std::span<const NodeId> sequence, Eigen::MatrixXd a) {
  double worst = 1;
  std::vector<char> done(graph.rows(), 0);
  for (const NodeId node : sequence) {
    const int row = graph.row(node), d = graph.dimension(node);
    const Eigen::MatrixXd pivot = a.block(row, row, d, d);
    const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(pivot).singularValues();
    worst = std::min(worst, values[0] > 0 ? values[d - 1] / values[0] : 0.0);
    for (int i = row; i < row + d; ++i) done[i] = 1;
    if (worst < 1e-14) return worst;
    const Eigen::MatrixXd update = a.middleCols(row, d) * pivot.partialPivLu().solve(a.middleRows(row, d));
    for (int j = 0; j < graph.rows(); ++j)
      for (int i = 0; i < graph.rows(); ++i)
        if (!done[i] && !done[j]) a(i, j) -= update(i, j);
  }
  return worst;
}

std::vector<NodeId> shuffled(const BlockGraph& graph, std::uint64_t seed) {
  std::vector<NodeId> nodes(graph.size());
  for (int i = 0; i < graph.size(); ++i) nodes[i] = {i};
  std::shuffle(nodes.begin(), nodes.end(), std::mt19937_64(seed));
  return nodes;
}

bool is_permutation_of_nodes(const BlockGraph& graph, const Ordering& ordering) {
  std::vector<int> index;
  for (const NodeId node : ordering.sequence) index.push_back(node.index);
  std::sort(index.begin(), index.end());
  std::vector<int> all(graph.size());
  std::iota(all.begin(), all.end(), 0);
  return index == all;
}

TEST(Eligibility, SaddleIsFreedByAPrivateHostOrByAllItsRegularNeighbours) {
  BlockGraph graph;  // a - s - b, b - t
  const NodeId a = graph.add_node("a", 6), b = graph.add_node("b", 6);
  const NodeId s = graph.add_node("s", 3, NodeKind::saddle), t = graph.add_node("t", 3, NodeKind::saddle);
  graph.add_edge(s, a, EdgeRank::full_row);
  graph.add_edge(s, b, EdgeRank::full_row);
  graph.add_edge(t, b, EdgeRank::full_row);
  std::vector<NodeId> freed;
  Eligibility private_host(graph);
  EXPECT_TRUE(private_host.eligible(a));
  EXPECT_FALSE(private_host.eligible(s));
  private_host.eliminate(a, freed);
  EXPECT_EQ(freed, std::vector{s});

  Eligibility shared_host(graph);
  freed.clear();
  shared_host.eliminate(b, freed);  // s and t both wait at b: it can carry only one of them for sure
  EXPECT_EQ(freed, std::vector{t});  // t has no other regular neighbour
  EXPECT_FALSE(shared_host.eligible(s));
}

TEST(Eligibility, WithoutFullRowRankAHostFreesNothing) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 2), b = graph.add_node("b", 6), s = graph.add_node("s", 3, NodeKind::saddle);
  graph.add_edge(s, a);
  graph.add_edge(s, b, EdgeRank::full_row);
  std::vector<NodeId> freed;
  Eligibility rule(graph);
  rule.eliminate(a, freed);
  EXPECT_TRUE(freed.empty());
  rule.eliminate(b, freed);
  EXPECT_EQ(freed, std::vector{s});
}

TEST(Ordering, NoOrderUnderTheRuleMeetsASingularPivotOn1200RandomSaddleSystems) {
  int runs = 0, repairs = 0;
  double worst = 1;
  for (int seed = 1; seed <= 100; ++seed)
    for (const BlockGraph& graph : {families::random_tree(9, seed), families::anchored_chain(3 + seed % 5),
                                    families::loop(4 + seed % 6)}) {
      const Eigen::MatrixXd a = families::saddle_matrix(graph, seed);
      for (const Ordering& ordering : {natural_ordering(graph), depth_first_ordering(graph), minimum_fill_ordering(graph),
                                       user_ordering(graph, shuffled(graph, seed))}) {
        ASSERT_TRUE(is_permutation_of_nodes(graph, ordering));
        ASSERT_EQ(ordering.forced, 0);
        worst = std::min(worst, worst_pivot(graph, ordering.sequence, a));
        repairs += ordering.repairs;
        ++runs;
      }
    }
  std::printf("             %d runs, %d repairs, worst pivot %.1e\n", runs, repairs, worst);
  EXPECT_GE(runs, 1200);
  EXPECT_GT(repairs, 0);
  EXPECT_GT(worst, 1e-10);
}

TEST(Ordering, DepthFirstWithoutTheRuleMeetsAZeroPivotOnALoop) {
  const BlockGraph graph = families::loop(6);
  // From a regular node the search ends at the link that closes the loop; as paper order it is eliminated first.
  std::vector<NodeId> plain;
  for (int i = 0; i < 6; ++i) {
    plain.push_back({i});
    plain.push_back({6 + i});
  }
  std::reverse(plain.begin(), plain.end());
  EXPECT_LT(worst_pivot(graph, plain, families::saddle_matrix(graph, 1)), 1e-12);
  const Ordering repaired = user_ordering(graph, plain);
  EXPECT_GT(repaired.repairs, 0);
  EXPECT_GT(worst_pivot(graph, repaired.sequence, families::saddle_matrix(graph, 1)), 1e-10);
}

TEST(MinimumFill, FillOfTheFamiliesIsWithinTheBars) {
  const struct {
    const char* name;
    BlockGraph graph;
    double bar;
  } cases[] = {{"chain", families::chain(1000), 1.0},     {"tree", families::balanced_tree(1000), 1.0},
               {"quadruped", families::quadruped(), 1.0}, {"loop", families::loop(1000), 1.30},
               {"ladder", families::ladder(1000), 1.45},  {"grid", families::grid(32), 3.5}};
  for (const auto& c : cases) {
    const Symbolic s(c.graph, minimum_fill_ordering(c.graph));
    std::printf("             %-10s fill %.2f\n", c.name, families::fill_factor(s));
    EXPECT_LE(families::fill_factor(s), c.bar + 1e-12) << c.name;
  }
}

TEST(MinimumFill, HubsAndLongChainsTakeNoMoreThanSeconds) {
  // Quadratic work would take minutes: the bound is loose because machines are.
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(minimum_fill_ordering(families::star(50000)).forced, 0);
  EXPECT_EQ(minimum_fill_ordering(families::chain(200000)).forced, 0);
  EXPECT_EQ(depth_first_ordering(families::chain(200000)).forced, 0);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 20);
}

TEST(Ordering, UserSequenceThatIsNoPermutationIsRefused) {
  const BlockGraph graph = families::chain(2);
  const std::vector<NodeId> twice{{0}, {0}, {1}}, shorter{{0}, {1}}, foreign{{0}, {1}, {7}};
  EXPECT_THROW(static_cast<void>(user_ordering(graph, twice)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(user_ordering(graph, shorter)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(user_ordering(graph, foreign)), std::invalid_argument);
}

}  // namespace
