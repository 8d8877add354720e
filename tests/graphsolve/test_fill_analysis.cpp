#include "graphsolve/fill_analysis.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "support/graph_families.hpp"

namespace test_fill_analysis {

using namespace graphsolve;

/// Nodes of 1 to 4 rows, some of them saddle nodes, edges anywhere.
BlockGraph random_graph(int seed) {
  std::mt19937_64 random(seed);
  const auto pick = [&](int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); };
  BlockGraph graph;
  const int n = pick(2, 16);
  for (int i = 0; i < n; ++i)
    graph.add_node("n" + std::to_string(i), pick(1, 4), pick(0, 3) == 0 ? NodeKind::saddle : NodeKind::regular);
  const int edges = pick(n / 2, 2 * n);
  for (int k = 0; k < edges; ++k) {
    const int a = pick(0, n - 1), b = pick(0, n - 1);
    if (a != b) graph.add_edge({a}, {b});
  }
  return graph;
}

OrderingMethod method_of(int seed) {
  std::vector<OrderingMethod> here;
  for (const OrderingMethod method : ordering_methods())
    if (available(method)) here.push_back(method);
  return here[seed % here.size()];
}

/// Scalar elimination of the matrix's pattern with every operation counted: what a factorization of full blocks does.
struct Counted {
  std::int64_t operations = 0, scalars = 0;
  int tree_height = 0, largest_front = 0;
};

Counted count(const BlockGraph& graph, const Ordering& ordering) {
  const int n = graph.size();
  Eigen::MatrixXi coupled = Eigen::MatrixXi::Identity(n, n);
  for (int a = 0; a < n; ++a)
    for (const auto& edge : graph.edges({a})) coupled(a, edge.to.index) = 1;
  // Rows in order of elimination; a block is full as soon as one of its scalars is.
  std::vector<int> node_of;
  std::vector<char> gone(n, 0);
  Counted result;
  std::vector<int> height(n, 1);
  for (const NodeId pivot : ordering.sequence) {
    gone[pivot.index] = 1;
    std::vector<int> later;
    for (int i = 0; i < n; ++i)
      if (!gone[i] && coupled(i, pivot.index)) later.push_back(i);
    int rows = 0;
    for (const int i : later) rows += graph.dimension({i});
    const int d = graph.dimension(pivot);
    for (int q = 0; q < d; ++q) {
      const int below = d - q - 1;  // within the block
      result.operations += 1 + below + below * below;  // reciprocal, multipliers, updates
      // The panel: multipliers of the rows below are scaled by the pivot, columns right of it are not; both are updated
      // within the block's remaining rows.
      result.operations += rows + 2 * below * rows + rows * rows;
    }
    result.scalars += d * d + 2 * d * rows;
    result.largest_front = std::max(result.largest_front, d + rows);
    for (const int i : later)
      for (const int j : later) coupled(i, j) = 1;
    int parent = -1;  // the first of them to go
    for (const NodeId next : ordering.sequence)
      if (parent < 0 && std::find(later.begin(), later.end(), next.index) != later.end()) parent = next.index;
    if (parent >= 0) height[parent] = std::max(height[parent], height[pivot.index] + 1);
  }
  result.tree_height = *std::max_element(height.begin(), height.end());
  return result;
}

TEST(FillAnalysis, WhatIsPredictedIsWhatIsCountedOn1000RandomGraphs) {
  for (int seed = 1; seed <= 1000; ++seed) {
    const BlockGraph graph = random_graph(seed);
    const Ordering ordering = make_ordering(graph, method_of(seed));
    const auto symbolic = std::make_shared<const Symbolic>(graph, ordering);
    const Counted counted = count(graph, ordering);
    ASSERT_EQ(symbolic->counts().operations, counted.operations) << "seed " << seed;
    ASSERT_EQ(symbolic->counts().stored_scalars, counted.scalars) << "seed " << seed;
    ASSERT_EQ(symbolic->counts().tree_height, counted.tree_height) << "seed " << seed;
    ASSERT_EQ(symbolic->counts().largest_front, counted.largest_front) << "seed " << seed;
    Factorization factorization(symbolic);
    families::load(families::dominant_matrix(graph, seed), graph, *symbolic, factorization.values());
    ASSERT_EQ(factorization.factorize().operations, counted.operations) << "seed " << seed;
    ASSERT_EQ(Symbolic(graph, ordering, Packs::off).values_size(), counted.scalars) << "seed " << seed;
  }
}

#define NEEDS_BOOST() \
  if (!fill_analysis_available()) GTEST_SKIP() << "this build is without Boost.Graph"

TEST(FillAnalysis, AttributionSumsToTheFillOn1000RandomGraphs) {
  NEEDS_BOOST();
  std::int64_t by_cycles = 0, by_order = 0;
  for (int seed = 1; seed <= 1000; ++seed) {
    const BlockGraph graph = random_graph(seed);
    const Symbolic symbolic(graph, make_ordering(graph, method_of(seed)));
    const FillAnalysis analysis = analyze_fill(graph, symbolic);
    const Symbolic::Counts& counts = symbolic.counts();
    FillPrice blocks, causes, fronts;
    std::int64_t unfilled = 0;
    std::set<std::pair<NodeId, NodeId>> seen;
    for (const FillBlock& b : analysis.blocks) {
      blocks.blocks += b.price.blocks;
      blocks.scalars += b.price.scalars;
      blocks.operations += b.price.operations;
      EXPECT_TRUE(seen.insert({b.first, b.later}).second);
      const auto& nodes = analysis.causes.at(b.cause).nodes;
      if (nodes.empty()) continue;
      EXPECT_TRUE(std::binary_search(nodes.begin(), nodes.end(), b.first));
      EXPECT_TRUE(std::binary_search(nodes.begin(), nodes.end(), b.later));
    }
    for (const FillCause& c : analysis.causes) {
      causes.blocks += c.price.blocks;
      causes.scalars += c.price.scalars;
      causes.operations += c.price.operations;
      (c.cycles > 0 ? by_cycles : by_order) += c.price.blocks;
    }
    std::set<NodeId> in_front;
    for (const FillFront& f : analysis.fronts) {
      fronts.blocks += f.price.blocks;
      fronts.scalars += f.price.scalars;
      fronts.operations += f.price.operations;
      int rows = 0, last = -1;
      for (const NodeId node : f.nodes) {
        EXPECT_TRUE(in_front.insert(node).second);
        const int k = symbolic.position(node);
        EXPECT_TRUE(last < 0 || symbolic.parent(last) == k) << "seed " << seed;
        rows += symbolic.dimension(last = k);
      }
      EXPECT_EQ(f.rows, rows + symbolic.pivot(last).coupled_rows);
    }
    for (const FillBlock& b : analysis.blocks) EXPECT_TRUE(in_front.contains(b.first));
    // Without fill: every pivot with what the graph alone couples to it.
    for (int k = 0; k < symbolic.pivots(); ++k) {
      BlockGraph front;
      const NodeId pivot = front.add_node("pivot", symbolic.dimension(k));
      for (std::size_t i = 0; i < symbolic.coupled(k).size(); ++i)
        if (!symbolic.is_fill(k, static_cast<int>(i)))
          front.add_edge(pivot, front.add_node("coupled", symbolic.dimension(symbolic.coupled(k)[i])));
      const std::int64_t d = symbolic.dimension(k), rows = front.rows() - d;
      BlockGraph alone;
      alone.add_node("alone", symbolic.dimension(k));
      unfilled += Symbolic(alone, natural_ordering(alone)).counts().operations + d * d * rows + d * rows * rows;
    }
    ASSERT_EQ(blocks, analysis.total) << "seed " << seed;
    ASSERT_EQ(causes, analysis.total) << "seed " << seed;
    ASSERT_EQ(fronts, analysis.total) << "seed " << seed;
    ASSERT_EQ(analysis.total.blocks, counts.fill_blocks) << "seed " << seed;
    ASSERT_EQ(analysis.total.scalars, counts.stored_scalars - counts.matrix_scalars) << "seed " << seed;
    ASSERT_EQ(analysis.operations_unfilled, unfilled) << "seed " << seed;
  }
  std::printf("             %ld fill blocks by cycles, %ld by the order\n", static_cast<long>(by_cycles),
              static_cast<long>(by_order));
  EXPECT_GT(by_cycles, 0);
  EXPECT_GT(by_order, 0);
}

TEST(FillAnalysis, ATreeInItsNaturalOrderFillsByItsOrderAlone) {
  NEEDS_BOOST();
  BlockGraph star;
  const NodeId hub = star.add_node("hub", 2);
  for (int i = 0; i < 4; ++i) star.add_edge(hub, star.add_node("leaf", 1));
  const FillAnalysis analysis = analyze_fill(star, Symbolic(star, natural_ordering(star)));
  ASSERT_EQ(analysis.causes.size(), 1u);
  EXPECT_EQ(analysis.causes[0].cycles, 0);
  EXPECT_EQ(analysis.causes[0].price.blocks, 6);
  EXPECT_EQ(analysis.edge, std::nullopt);
  EXPECT_TRUE(analyze_fill(star, Symbolic(star, minimum_fill_ordering(star))).causes.empty());
}

/// One biconnected component, which tells nothing: the middle line, eliminated last, is the separator that pays.
TEST(FillAnalysis, OfAMeshTheSeparatorIsNamed) {
  NEEDS_BOOST();
  constexpr int n = 9;
  BlockGraph mesh;
  for (int i = 0; i < n * n; ++i) mesh.add_node("row " + std::to_string(i / n) + " column " + std::to_string(i % n), 1);
  for (int i = 0; i < n * n; ++i) {
    if (i % n + 1 < n) mesh.add_edge({i}, {i + 1});
    if (i + n < n * n) mesh.add_edge({i}, {i + n});
  }
  std::vector<NodeId> sequence;
  for (const bool middle : {false, true})
    for (int i = 0; i < n * n; ++i)
      if ((i % n == n / 2) == middle) sequence.push_back({i});
  const FillAnalysis analysis = analyze_fill(mesh, Symbolic(mesh, user_ordering(mesh, sequence)));
  ASSERT_EQ(analysis.causes.size(), 1u);
  ASSERT_GT(analysis.fronts.size(), 1u);
  const auto separator = std::ranges::find(analysis.fronts, sequence.back(), [](const FillFront& f) { return f.nodes.back(); });
  ASSERT_NE(separator, analysis.fronts.end());
  ASSERT_GE(separator->nodes.size(), std::size_t{n});
  EXPECT_TRUE(std::equal(sequence.end() - n, sequence.end(), separator->nodes.end() - n)) << "the whole line";
  EXPECT_EQ(separator->rows, static_cast<int>(separator->nodes.size())) << "nothing stays after it";
  EXPECT_GE(separator->price.blocks, n * (n - 1) / 2 - (n - 1)) << "all pairs but neighbours";
}

TEST(FillAnalysis, TwoLoopsThatShareANodeAreTwoCauses) {
  NEEDS_BOOST();
  BlockGraph graph;  // a square of 6-row nodes and a pentagon of 2-row nodes at node 0
  for (int i = 0; i < 4; ++i) graph.add_node("square", 6);
  for (int i = 0; i < 4; ++i) graph.add_node("pentagon", 2);
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {4, 5}, {5, 6}, {6, 7}, {7, 0}})
    graph.add_edge({a}, {b});
  const FillAnalysis analysis = analyze_fill(graph, Symbolic(graph, minimum_fill_ordering(graph)));
  ASSERT_EQ(analysis.causes.size(), 2u);
  EXPECT_EQ(analysis.causes[0].nodes, (std::vector<NodeId>{{0}, {1}, {2}, {3}}));
  EXPECT_EQ(analysis.causes[1].nodes, (std::vector<NodeId>{{0}, {4}, {5}, {6}, {7}}));
  EXPECT_EQ(analysis.causes[0].price.blocks, 1);
  EXPECT_EQ(analysis.causes[1].price.blocks, 2);
  for (const FillCause& cause : analysis.causes) EXPECT_EQ(cause.cycles, 1);
  ASSERT_TRUE(analysis.edge.has_value());
  EXPECT_TRUE(analysis.edge->exact());
  EXPECT_LT(std::max(analysis.edge->a.index, analysis.edge->b.index), 4);  // an edge of the dearer loop
}

/// Price of ordering the whole graph without one edge.
std::int64_t operations_without(const BlockGraph& graph, NodeId a, NodeId b) {
  BlockGraph rest;
  for (int i = 0; i < graph.size(); ++i) rest.add_node("n", graph.dimension({i}), graph.kind({i}));
  for (int i = 0; i < graph.size(); ++i)
    for (const auto& edge : graph.edges({i}))
      if (i < edge.to.index && !(i == std::min(a, b).index && edge.to == std::max(a, b)))
        rest.add_edge({i}, edge.to, edge.rank);
  return Symbolic(rest, minimum_fill_ordering(rest)).counts().operations;
}

TEST(FillAnalysis, TheEdgeThatSavesMostIsTheBestOfAllTried) {
  NEEDS_BOOST();
  for (const BlockGraph& graph : {families::loop(8), families::ladder(10), families::grid(3, 2)}) {
    const FillAnalysis analysis = analyze_fill(graph, Symbolic(graph, minimum_fill_ordering(graph)));
    ASSERT_TRUE(analysis.edge.has_value());
    EXPECT_TRUE(analysis.edge->exact());
    const std::int64_t with = operations_without(graph, {}, {});
    std::int64_t most = 0;
    for (int i = 0; i < graph.size(); ++i)
      for (const auto& edge : graph.edges({i})) most = std::max(most, with - operations_without(graph, {i}, edge.to));
    EXPECT_EQ(with - operations_without(graph, analysis.edge->a, analysis.edge->b), analysis.edge->operations);
    EXPECT_EQ(analysis.edge->operations, most);  // these graphs are one component, so nothing else changes
  }
}

TEST(FillAnalysis, WorkForTheEdgeIsBoundedAndSaysHowManyWereTried) {
  NEEDS_BOOST();
  const BlockGraph graph = families::grid(30, 1);
  const FillAnalysis analysis = analyze_fill(graph, Symbolic(graph, minimum_fill_ordering(graph)));
  ASSERT_EQ(analysis.causes.size(), 1u);
  EXPECT_EQ(analysis.causes[0].cycles, 29 * 29);
  ASSERT_TRUE(analysis.edge.has_value());
  EXPECT_FALSE(analysis.edge->exact());
  EXPECT_LE(analysis.edge->tried * static_cast<long>(graph.size()), 100000);
}

TEST(FillAnalysis, AnotherGraphsEliminationIsRefused) {
  const BlockGraph graph = families::chain(3);
  EXPECT_THROW(static_cast<void>(analyze_fill(families::chain(4), Symbolic(graph, natural_ordering(graph)))),
               std::invalid_argument);
}

}  // namespace test_fill_analysis
