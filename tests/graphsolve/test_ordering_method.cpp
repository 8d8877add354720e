#include "graphsolve/ordering_method.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "graphsolve/cheapest_ordering.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "support/graph_families.hpp"

namespace test_ordering_method {

using namespace graphsolve;

std::vector<OrderingMethod> methods_here() {
  std::vector<OrderingMethod> result;
  for (const OrderingMethod method : ordering_methods())
    if (available(method)) result.push_back(method);
  return result;
}

bool is_permutation_of_nodes(const BlockGraph& graph, const Ordering& ordering) {
  std::vector<int> index, all(graph.size());
  for (const NodeId node : ordering.sequence) index.push_back(node.index);
  std::sort(index.begin(), index.end());
  std::iota(all.begin(), all.end(), 0);
  return index == all;
}

/// Does every node of the order come when it may?
bool obeys_the_rule(const BlockGraph& graph, const Ordering& ordering) {
  Eligibility rule(graph);
  std::vector<NodeId> freed;
  for (const NodeId node : ordering.sequence) {
    if (!rule.eligible(node)) return false;
    rule.eliminate(node, freed);
  }
  return true;
}

std::vector<BlockGraph> all_kinds_of_graphs(int seed) {
  std::vector<BlockGraph> graphs{families::chain(7 + seed % 5), families::random_tree(30, seed),
                                 families::anchored_chain(5), families::loop(3 + seed % 9), families::ladder(12),
                                 families::grid(4, 1 + seed % 3),
                                 families::random_with_loops(20, 10 + seed % 10, seed)};
  // Several components, one of them a single node; nodes without edges only; one node; none.
  BlockGraph parts = families::loop(5);
  parts.add_node("alone", 2);
  const NodeId a = parts.add_node("a", 3), b = parts.add_node("b", 1);
  parts.add_edge(a, b);
  graphs.push_back(parts);
  graphs.emplace_back();
  BlockGraph loose;
  for (int i = 0; i < 4; ++i) loose.add_node("n", 1 + i);
  graphs.push_back(loose);
  return graphs;
}

TEST(OrderingMethod, EveryMethodGivesAPermutationThatObeysTheRule) {
  int orders = 0, repairs = 0;
  for (int seed = 1; seed <= 40; ++seed)
    for (const BlockGraph& graph : all_kinds_of_graphs(seed))
      for (const OrderingMethod method : methods_here()) {
        const Ordering ordering = make_ordering(graph, method);
        ASSERT_TRUE(is_permutation_of_nodes(graph, ordering)) << name(method);
        ASSERT_TRUE(obeys_the_rule(graph, ordering)) << name(method) << " seed " << seed;
        EXPECT_EQ(ordering.forced, 0) << name(method);
        EXPECT_TRUE(ordering.method == method || method == OrderingMethod::best) << name(method);
        repairs += ordering.repairs;
        ++orders;
      }
  std::printf("             %d orders, %d repairs\n", orders, repairs);
  EXPECT_GT(repairs, 0);
}

TEST(OrderingMethod, EqualGraphsGetEqualOrders) {
  for (int seed = 1; seed <= 5; ++seed)
    for (const OrderingMethod method : methods_here())
      EXPECT_EQ(make_ordering(families::random_with_loops(150, 80, seed), method).sequence,
                make_ordering(families::random_with_loops(150, 80, seed), method).sequence)
          << name(method);
}

TEST(OrderingMethod, NamesAreReadBackWithHyphensOrUnderscores) {
  EXPECT_EQ(ordering_methods().size(), 12u);
  for (const OrderingMethod method : ordering_methods()) {
    EXPECT_EQ(parse_ordering_method(name(method)), method);
    std::string underscored(name(method));
    std::replace(underscored.begin(), underscored.end(), '-', '_');
    EXPECT_EQ(parse_ordering_method(underscored), method);
  }
  EXPECT_EQ(name(OrderingMethod::reverse_cuthill_mckee), "reverse-cuthill-mckee");
  EXPECT_EQ(parse_ordering_method("user"), std::nullopt);
  EXPECT_EQ(parse_ordering_method("AMD"), std::nullopt);
  EXPECT_EQ(parse_ordering_method(""), std::nullopt);
}

TEST(OrderingMethod, WhatIsNotInThisBuildIsRefusedByNameAndPackage) {
  for (const OrderingMethod method : ordering_methods()) {
    if (available(method)) continue;
    try {
      static_cast<void>(make_ordering(families::chain(2), method));
      FAIL() << name(method);
    } catch (const std::invalid_argument& e) {
      EXPECT_NE(std::string(e.what()).find("'" + std::string(name(method)) + "' is not available"), std::string::npos);
    }
  }
  EXPECT_THROW(static_cast<void>(make_ordering(families::chain(2), OrderingMethod::user)), std::invalid_argument);
}

TEST(OrderingMethod, BestIsNeverWorseThanTheDefaultAndSaysWhichItTook) {
  for (int seed = 1; seed <= 20; ++seed)
    for (const BlockGraph& graph : all_kinds_of_graphs(seed)) {
      const Ordering best = make_ordering(graph, OrderingMethod::best);
      const auto operations = [&](const Ordering& o) { return Symbolic(graph, o).counts().operations; };
      EXPECT_LE(operations(best), operations(minimum_fill_ordering(graph)));
      EXPECT_NE(best.method, OrderingMethod::best);
      EXPECT_EQ(make_ordering(graph, best.method).sequence, best.sequence);
    }
}

/// The separators of a grid of constraints are constraints, none of which the rule has to defer. Small grids (24) are even.
TEST(OrderingMethod, NestedDissectionOfAMeshOfConstraintsNeedsFewerOperationsThanMinimumFill) {
  if (!available(OrderingMethod::nested_dissection) || !available(OrderingMethod::camd)) GTEST_SKIP() << "needs METIS and CAMD";
  for (const int side : {32, 48, 64}) {
    const BlockGraph graph = families::grid(side, 3);
    const Ordering dissected = make_ordering(graph, OrderingMethod::nested_dissection);
    EXPECT_EQ(dissected.repairs, 0);
    const auto operations = [&](const Ordering& o) { return Symbolic(graph, o, Packs::off).counts().operations; };
    EXPECT_LT(static_cast<double>(operations(dissected)), 0.97 * static_cast<double>(operations(minimum_fill_ordering(graph))));
  }
}

TEST(CheapestInPacks, IsTheOneOfFewestOperationsOfThoseAskedFor) {
  const auto cost = [](const BlockGraph& graph, const Ordering& ordering) {
    return Symbolic(graph, ordering).counts().symmetric_pack_operations;
  };
  std::vector<int> chosen(ordering_methods().size() + 1, 0);
  for (int seed = 1; seed <= 20; ++seed)
    for (const BlockGraph& graph : {families::chain(5 * seed), families::loop(10 * seed), families::random_tree(4 * seed, seed),
                                    families::ladder(8 * seed), families::control(3 * seed, seed)}) {
      const Ordering cheapest = cheapest_in_packs(graph, FactorizationKind::ldlt);
      ASSERT_TRUE(is_permutation_of_nodes(graph, cheapest));
      const std::int64_t least = cost(graph, cheapest);
      for (const OrderingMethod method : methods_for_packs)
        if (available(method) && make_ordering(graph, method).forced == cheapest.forced) {
          EXPECT_LE(least, cost(graph, make_ordering(graph, method)));
        }
      ++chosen[static_cast<std::size_t>(cheapest.method)];
    }
  EXPECT_GT(chosen[static_cast<std::size_t>(OrderingMethod::wide)], 10);
  EXPECT_GT(chosen[static_cast<std::size_t>(OrderingMethod::minimum_fill)], 10);  // what `best` is where nothing fills
}

/// Rows of states fill the registers by themselves: three times the operations for the sake of packs do not pay.
TEST(CheapestInPacks, OfALongHorizonWithLargeStatesMakesNoFill) {
  const BlockGraph graph = families::control(100, 1);
  for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::ldlt})
    EXPECT_EQ(Symbolic(graph, cheapest_in_packs(graph, kind)).counts().fill_blocks, 0);
}

TEST(CheapestInPacks, RefusesMethodsThatAreAllMissing) {
  EXPECT_THROW((void)cheapest_in_packs(families::chain(5), FactorizationKind::ldu, {}), std::invalid_argument);
}

}  // namespace test_ordering_method
