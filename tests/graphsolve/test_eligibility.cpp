#include <gtest/gtest.h>

#include <vector>

#include "graphsolve/ordering.hpp"

namespace test_eligibility {

using namespace graphsolve;

/// A graph, its rule, and what the last elimination freed.
struct Elimination {
  explicit Elimination(const BlockGraph& graph) : rule(graph) {}
  std::vector<NodeId> operator()(NodeId node) {
    std::vector<NodeId> freed;
    rule.eliminate(node, freed);
    return freed;
  }
  Eligibility rule;
};

using Nodes = std::vector<NodeId>;

/// a - s - b - t, rows of s independent on a and on b, rows of t on b.
struct TwoConstraints {
  BlockGraph graph;
  NodeId a = graph.add_node("a", 6), b = graph.add_node("b", 6);
  NodeId s = graph.add_node("s", 3, NodeKind::saddle), t = graph.add_node("t", 3, NodeKind::saddle);
  TwoConstraints() {
    graph.add_edge(s, a, EdgeRank::full_row);
    graph.add_edge(s, b, EdgeRank::full_row);
    graph.add_edge(t, b, EdgeRank::full_row);
  }
};

TEST(Eligibility, RegularNodesAreFreeFromTheStartAndSaddleNodesAreNot) {
  const TwoConstraints g;
  const Eligibility rule(g.graph);
  EXPECT_TRUE(rule.eligible(g.a));
  EXPECT_TRUE(rule.eligible(g.b));
  EXPECT_FALSE(rule.eligible(g.s));
  EXPECT_FALSE(rule.eligible(g.t));
}

TEST(Eligibility, HostWithOneWaitingSaddleFreesIt) {
  const TwoConstraints g;
  Elimination eliminate(g.graph);
  EXPECT_EQ(eliminate(g.a), Nodes{g.s});
  EXPECT_TRUE(eliminate.rule.eligible(g.s));
}

TEST(Eligibility, HostWithTwoWaitingSaddlesFreesOnlyWhatHasNoOtherNeighbour) {
  const TwoConstraints g;
  Elimination eliminate(g.graph);
  EXPECT_EQ(eliminate(g.b), Nodes{g.t});
  EXPECT_FALSE(eliminate.rule.eligible(g.s));
  // Eliminating t afterwards does not help s: it counts who waited when b went.
  EXPECT_TRUE(eliminate(g.t).empty());
  EXPECT_FALSE(eliminate.rule.eligible(g.s));
  EXPECT_EQ(eliminate(g.a), Nodes{g.s});
}

TEST(Eligibility, HostWhoseOtherSaddlesWentBeforeFreesTheLast) {
  TwoConstraints g;
  const NodeId c = g.graph.add_node("c", 6), d = g.graph.add_node("d", 6);
  g.graph.add_edge(g.s, d);
  g.graph.add_edge(g.t, c, EdgeRank::full_row);
  Elimination eliminate(g.graph);
  EXPECT_EQ(eliminate(c), Nodes{g.t});
  EXPECT_TRUE(eliminate(g.t).empty());
  EXPECT_EQ(eliminate(g.b), Nodes{g.s});  // a and d still stand
}

TEST(Eligibility, WithoutFullRowRankAHostFreesNothing) {
  for (const EdgeRank rank : {EdgeRank::unknown, EdgeRank::full_column}) {
    BlockGraph graph;
    const NodeId a = graph.add_node("a", 2), b = graph.add_node("b", 6), s = graph.add_node("s", 3, NodeKind::saddle);
    graph.add_edge(s, a, rank);
    graph.add_edge(s, b, EdgeRank::full_row);
    Elimination eliminate(graph);
    EXPECT_TRUE(eliminate(a).empty());
    EXPECT_EQ(eliminate(b), Nodes{s});
  }
}

TEST(Eligibility, NobodyWaitsForASharedNodeAndItFreesNobody) {
  TwoConstraints g;
  const NodeId time = g.graph.add_node("time", 6, NodeKind::shared);
  g.graph.add_edge(g.s, time, EdgeRank::full_row);
  g.graph.add_edge(g.t, time, EdgeRank::full_row);
  Elimination eliminate(g.graph);
  EXPECT_TRUE(eliminate.rule.eligible(time));
  EXPECT_EQ(eliminate(g.b), Nodes{g.t});  // as without it
  EXPECT_TRUE(eliminate(g.t).empty());
  EXPECT_TRUE(eliminate(time).empty());  // s is the only one left there: that is no reason
  EXPECT_EQ(eliminate(g.a), Nodes{g.s});
}

TEST(Eligibility, NodeIsFreedOnceEvenWhenTwoReasonsMeet) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 6), s = graph.add_node("s", 3, NodeKind::saddle);
  graph.add_edge(s, a, EdgeRank::full_row);  // the only neighbour and a private host
  Elimination eliminate(graph);
  EXPECT_EQ(eliminate(a), Nodes{s});
}

TEST(Eligibility, SaddleNodeWithoutNeighboursIsFreeAtOnce) {
  BlockGraph graph;
  const NodeId s = graph.add_node("s", 3, NodeKind::saddle);
  EXPECT_TRUE(Eligibility(graph).eligible(s));
}

TEST(Eligibility, SemidefiniteNodeWaitsForItsSaddleNodesOnly) {
  BlockGraph graph;
  const NodeId alone = graph.add_node("alone", 2, NodeKind::semidefinite);
  const NodeId beside = graph.add_node("beside", 2, NodeKind::semidefinite), r = graph.add_node("r", 2);
  graph.add_edge(beside, r);
  const NodeId x = graph.add_node("x", 2, NodeKind::semidefinite), s = graph.add_node("s", 2, NodeKind::saddle);
  graph.add_edge(s, x);
  graph.add_edge(s, r, EdgeRank::full);
  Elimination eliminate(graph);
  EXPECT_TRUE(eliminate.rule.eligible(alone));
  EXPECT_TRUE(eliminate.rule.eligible(beside));
  EXPECT_FALSE(eliminate.rule.eligible(x));
  EXPECT_EQ(eliminate(r), Nodes{s});
  EXPECT_EQ(eliminate(s), Nodes{x});
}

TEST(Eligibility, SaddleNodeWithOneSemidefiniteNeighbourFreesItAcrossFullColumnRank) {
  for (const EdgeRank rank : {EdgeRank::full_column, EdgeRank::full_row, EdgeRank::full, EdgeRank::unknown}) {
    BlockGraph graph;
    const NodeId r = graph.add_node("r", 2), x = graph.add_node("x", 2, NodeKind::semidefinite);
    const NodeId s = graph.add_node("s", 2, NodeKind::saddle), t = graph.add_node("t", 2, NodeKind::saddle);
    graph.add_edge(s, r, EdgeRank::full);
    graph.add_edge(s, x, rank);
    graph.add_edge(t, x);  // x has another saddle neighbour to wait for
    Elimination eliminate(graph);
    EXPECT_EQ(eliminate(r), Nodes{s});
    const bool carries = rank == EdgeRank::full_column || rank == EdgeRank::full;
    EXPECT_EQ(eliminate(s), carries ? Nodes{x} : Nodes{});
  }
}

TEST(Eligibility, SaddleNodeWithTwoSemidefiniteNeighboursFreesNeither) {
  BlockGraph graph;
  const NodeId r = graph.add_node("r", 2), s = graph.add_node("s", 2, NodeKind::saddle);
  graph.add_edge(s, r, EdgeRank::full);
  for (const char* name : {"x", "y"}) {
    const NodeId x = graph.add_node(name, 2, NodeKind::semidefinite);
    const NodeId other = graph.add_node("other", 2, NodeKind::saddle);
    graph.add_edge(s, x, EdgeRank::full);
    graph.add_edge(other, x);
  }
  Elimination eliminate(graph);
  EXPECT_EQ(eliminate(r), Nodes{s});
  EXPECT_TRUE(eliminate(s).empty());
}

TEST(Eligibility, SaddleNodeWaitsForItsSemidefiniteNeighboursToo) {
  // A control of 1 cannot carry dynamics of 2 rows: without the state the pivot would have rank 1.
  BlockGraph graph;
  const NodeId u = graph.add_node("u", 1), x = graph.add_node("x", 2, NodeKind::semidefinite);
  const NodeId s = graph.add_node("s", 2, NodeKind::saddle);
  graph.add_edge(s, u, EdgeRank::full_column);
  graph.add_edge(s, x, EdgeRank::full);
  Elimination eliminate(graph);
  EXPECT_TRUE(eliminate(u).empty());
  EXPECT_FALSE(eliminate.rule.eligible(s));
  EXPECT_FALSE(eliminate.rule.eligible(x));
}

}  // namespace test_eligibility
