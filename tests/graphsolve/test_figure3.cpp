#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "graphsolve/symbolic.hpp"

namespace test_figure3 {

/// Fig. 3 of the paper: one leg of a quadruped with an explicit contact. Nodes 1-3 trunk, upper and lower leg,
/// 4 and 5 the joints, 6 friction, 7 and 8 its limits, 9 contact. The figure's orders are taken as drawn.

using namespace graphsolve;
using Pair = std::pair<int, int>;

/// Fill blocks, as pairs of the figure's numbers in the order of elimination.
std::set<Pair> fill_of(const std::vector<int>& order, const std::vector<Pair>& edges) {
  BlockGraph graph;
  std::vector<NodeId> node(10);
  for (int label = 1; label <= 9; ++label) node[label] = graph.add_node(std::to_string(label), label <= 3 ? 6 : 3);
  for (const auto& [a, b] : edges) graph.add_edge(node[a], node[b]);
  Ordering ordering;
  for (const int label : order) ordering.sequence.push_back(node[label]);
  // Numbers that the figure does not have stand alone; they go last.
  for (int label = 1; label <= 9; ++label)
    if (graph.edges(node[label]).empty()) ordering.sequence.push_back(node[label]);
  const Symbolic symbolic(graph, ordering);
  std::set<Pair> fill;
  for (int k = 0; k < symbolic.pivots(); ++k) {
    const auto coupled = symbolic.coupled(k);
    for (int e = 0; e < static_cast<int>(coupled.size()); ++e)
      if (symbolic.is_fill(k, e)) fill.insert({symbolic.node(k).index + 1, symbolic.node(coupled[e]).index + 1});
  }
  EXPECT_EQ(symbolic.counts().fill_blocks, static_cast<std::int64_t>(fill.size()));
  return fill;
}

TEST(Figure3, MaximalCoordinatesLegHasOneFillBlock) {
  const auto fill =
      fill_of({9, 8, 7, 6, 3, 5, 2, 4, 1}, {{9, 8}, {9, 3}, {8, 6}, {7, 6}, {6, 3}, {3, 5}, {5, 2}, {2, 4}, {4, 1}});
  EXPECT_EQ(fill, (std::set<Pair>{{8, 3}}));
}

TEST(Figure3, MinimalCoordinatesLegHasOneFillBlockPerBody) {
  const auto fill =
      fill_of({9, 8, 7, 6, 3, 2, 1},
              {{9, 8}, {9, 3}, {9, 2}, {9, 1}, {8, 6}, {7, 6}, {6, 3}, {6, 2}, {6, 1}, {3, 2}, {3, 1}, {2, 1}});
  EXPECT_EQ(fill, (std::set<Pair>{{8, 3}, {8, 2}, {8, 1}}));
}

}  // namespace test_figure3
