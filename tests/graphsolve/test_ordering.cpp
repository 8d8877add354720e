#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "support/dense.hpp"
#include "support/graph_families.hpp"

namespace test_ordering {

using namespace graphsolve;

/// Smallest singular value over norm of all pivot blocks, eliminating a dense matrix block by block.
double worst_pivot(const BlockGraph& graph, std::span<const NodeId> sequence, Eigen::MatrixXd a) {
  double worst = 1;
  std::vector<char> done(graph.rows(), 0);
  for (const NodeId node : sequence) {
    const int row = graph.row(node), d = graph.dimension(node);
    const Eigen::MatrixXd pivot = a.block(row, row, d, d);
    const Eigen::VectorXd values = dense::singular_values(pivot);
    worst = std::min(worst, values[0] > 0 ? values[d - 1] / values[0] : 0.0);
    for (int i = row; i < row + d; ++i) done[i] = 1;
    if (worst < 1e-14) return worst;
    const Eigen::MatrixXd update = a.middleCols(row, d) * dense::solve(pivot, Eigen::MatrixXd(a.middleRows(row, d)));
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

TEST(Ordering, NoOrderUnderTheRuleMeetsASingularPivotOn1200RandomSaddleSystems) {
  int runs = 0, repairs = 0;
  double worst = 1;
  for (int seed = 1; seed <= 100; ++seed)
    for (const BlockGraph& graph :
         {families::random_tree(9, seed), families::anchored_chain(3 + seed % 5), families::loop(4 + seed % 6)}) {
      const Eigen::MatrixXd a = families::saddle_matrix(graph, seed);
      for (const Ordering& ordering : {natural_ordering(graph), depth_first_ordering(graph),
                                       minimum_fill_ordering(graph), user_ordering(graph, shuffled(graph, seed))}) {
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

/// A parameter that all constraints of a graph share.
BlockGraph with_shared_parameter(BlockGraph graph, int dimension) {
  const int n = graph.size();
  const NodeId parameter = graph.add_node("parameter", dimension, NodeKind::shared);
  for (int i = 0; i < n; ++i)
    if (graph.kind({i}) == NodeKind::saddle) graph.add_edge({i}, parameter, i % 2 == 0 ? EdgeRank::full_row : EdgeRank::unknown);
  return graph;
}

TEST(Ordering, NoOrderMeetsASingularPivotWhereConstraintsShareAParameter) {
  double worst = 1;
  for (int seed = 1; seed <= 100; ++seed)
    for (const BlockGraph& bare :
         {families::random_tree(9, seed), families::anchored_chain(3 + seed % 5), families::loop(4 + seed % 6)}) {
      const BlockGraph graph = with_shared_parameter(bare, 1 + seed % 4);
      const Eigen::MatrixXd a = families::saddle_matrix(graph, seed);
      for (const Ordering& ordering : {natural_ordering(graph), depth_first_ordering(graph), minimum_fill_ordering(graph),
                                       wide_ordering(graph), user_ordering(graph, shuffled(graph, seed))}) {
        ASSERT_TRUE(is_permutation_of_nodes(graph, ordering));
        ASSERT_EQ(ordering.forced, 0);
        worst = std::min(worst, worst_pivot(graph, ordering.sequence, a));
      }
    }
  std::printf("             worst pivot %.1e\n", worst);
  EXPECT_GT(worst, 1e-10);
}

/// A connected network of n nodes; the first `held` of them in a shuffled order have a constraint of their own.
struct Network {
  BlockGraph graph;
  Eigen::MatrixXd matrix;  ///< [H -J^T; J 0]
};

/// Coupling of two nodes, semidefinite: H has it at both nodes, and minus it between them.
template <class Stiffness>
Network network(int n, int dimension, int held, int seed, EdgeRank rank, Stiffness&& stiffness) {
  std::mt19937_64 random(seed);
  std::vector<int> of(n);
  std::iota(of.begin(), of.end(), 0);
  std::shuffle(of.begin(), of.end(), random);
  Network result;
  for (int i = 0; i < n; ++i) result.graph.add_node("n" + std::to_string(i), dimension);
  for (int i = 0; i < held; ++i) {
    const NodeId constraint = result.graph.add_node("c" + std::to_string(i), dimension, NodeKind::saddle);
    result.graph.add_edge(constraint, {of[i]}, rank);
  }
  Eigen::MatrixXd& a = result.matrix = Eigen::MatrixXd::Zero(result.graph.rows(), result.graph.rows());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      const Eigen::MatrixXd k = stiffness(i, j, random);
      if (k.size() == 0) continue;
      result.graph.add_edge({i}, {j});
      const auto add = [&](int r, int c, double sign) { a.block(r * dimension, c * dimension, dimension, dimension) += sign * k; };
      add(i, i, 1), add(j, j, 1), add(i, j, -1), add(j, i, -1);
    }
  for (int i = 0; i < held; ++i) {
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd own = 2 * Eigen::MatrixXd::Identity(dimension, dimension) +
                                0.3 * Eigen::MatrixXd::NullaryExpr(dimension, dimension, [&] { return normal(random); });
    a.block((n + i) * dimension, of[i] * dimension, dimension, dimension) = own;
    a.block(of[i] * dimension, (n + i) * dimension, dimension, dimension) = -own.transpose();
  }
  return result;
}

std::vector<Ordering> all_orderings(const BlockGraph& graph) {
  std::vector<Ordering> result;
  for (const OrderingMethod method : ordering_methods())
    if (available(method)) result.push_back(make_ordering(graph, method));
  return result;
}

/// Componentwise, after factorization, solve and refinement; infinity where the factorization fails.
double refined_error(const BlockGraph& graph, const Ordering& ordering, const Eigen::MatrixXd& matrix) {
  const auto symbolic = std::make_shared<const Symbolic>(graph, ordering);
  Factorization f(symbolic);
  f.allow_refinement();
  f.keep_matrix(true);
  families::load(matrix, graph, *symbolic, f.values());
  if (!f.factorize().ok()) return std::numeric_limits<double>::infinity();
  const std::vector<double> b(graph.rows(), 1.0);
  std::vector<double> x = b;
  f.solve(x);
  (void)f.refine(b, x);
  const Eigen::Map<const Eigen::VectorXd> right(b.data(), graph.rows()), solution(x.data(), graph.rows());
  return ((matrix * solution - right).array().abs() /
          (matrix.cwiseAbs() * solution.cwiseAbs() + right.cwiseAbs()).array()).maxCoeff();
}

/// Trees and rings with chords; no order may leave the held node for the end, and the user's may.
TEST(Ordering, NetworksThatOnlyOneConstraintHoldsAreSolved) {
  double worst = 1;
  int singular = 0;
  for (int seed = 1; seed <= 100; ++seed) {
    const int n = 2 + seed % 9, d = 1 + seed % 3;
    const Network net = network(n, d, 1, seed, seed % 2 == 0 ? EdgeRank::full : EdgeRank::unknown,
                                [&](int i, int j, auto& random) -> Eigen::MatrixXd {
      std::normal_distribution<double> normal;
      if (j != i - 1 && random() % 5 != 0) return {};
      const Eigen::MatrixXd k = Eigen::MatrixXd::NullaryExpr(d, d, [&] { return normal(random); });
      return k * k.transpose() + Eigen::MatrixXd::Identity(d, d);
    });
    for (const Ordering& ordering : all_orderings(net.graph)) {
      ASSERT_TRUE(is_permutation_of_nodes(net.graph, ordering));
      worst = std::min(worst, worst_pivot(net.graph, ordering.sequence, net.matrix));
    }
    EXPECT_LE(refined_error(net.graph, minimum_fill_ordering(net.graph), net.matrix), 1e-15) << "seed " << seed;
    singular += worst_pivot(net.graph, user_ordering(net.graph, shuffled(net.graph, seed)).sequence, net.matrix) < 1e-12;
  }
  std::printf("             worst pivot %.1e; %d of 100 shuffled orders are singular\n", worst, singular);
  EXPECT_GT(worst, 1e-6);
  EXPECT_GT(singular, 10);
}

/// Bars between points in the plane: what two held points fix is more than one node has.
TEST(Ordering, FrameworksThatTwoHeldPointsFixAreSolved) {
  double worst = 1;
  for (int seed = 1; seed <= 60; ++seed) {
    const int n = 3 + seed % 8;
    std::mt19937_64 random(1000 + seed);
    std::uniform_real_distribution<double> within(0.0, 1.0);
    Eigen::MatrixXd point(2, n);
    for (int i = 0; i < n; ++i) point.col(i) << i % 3 + 0.5 * within(random), i / 3 + 0.5 * within(random);
    const Network net = network(n, 2, 2, seed, EdgeRank::full, [&](int i, int j, auto&) -> Eigen::MatrixXd {
      if (i - j > 4) return {};  // a band of triangles: rigid
      const Eigen::Vector2d along = (point.col(i) - point.col(j)).normalized();
      return along * along.transpose();
    });
    for (const Ordering& ordering : all_orderings(net.graph))
      worst = std::min(worst, worst_pivot(net.graph, ordering.sequence, net.matrix));
  }
  std::printf("             worst pivot %.1e\n", worst);
  EXPECT_GT(worst, 1e-7);
}

TEST(Ordering, AParameterThatAllConstraintsShareCostsNoMoreThanItsColumn) {
  const BlockGraph chain = families::chain(100), graph = with_shared_parameter(chain, 1);
  const Symbolic without(chain, minimum_fill_ordering(chain)), with(graph, minimum_fill_ordering(graph));
  EXPECT_GE(with.position({graph.size() - 1}), with.pivots() - 4);  // at the end all see each other
  EXPECT_LE(with.counts().operations, 2 * without.counts().operations);
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

TEST(Ordering, CostlessStatesMeetNoSingularPivotUnlessTheOrderSaysThatItWasForced) {
  int safe = 0;
  double worst = 1;
  for (int seed = 1; seed <= 200; ++seed) {
    const BlockGraph graph = families::control(2 + seed % 6, seed);
    const Eigen::MatrixXd a = families::saddle_matrix(graph, seed);
    for (const Ordering& ordering : {natural_ordering(graph), depth_first_ordering(graph), minimum_fill_ordering(graph),
                                     user_ordering(graph, shuffled(graph, seed))}) {
      ASSERT_TRUE(is_permutation_of_nodes(graph, ordering));
      if (ordering.forced > 0) continue;
      ++safe;
      worst = std::min(worst, worst_pivot(graph, ordering.sequence, a));
    }
  }
  std::printf("             %d runs not forced, worst pivot %.1e\n", safe, worst);
  EXPECT_GT(safe, 400);
  EXPECT_GT(worst, 1e-12);
}

TEST(Ordering, NodesThatWaitForEachOtherAreForcedAndCounted) {
  BlockGraph graph;  // [0 -J^T; J 0]: neither block can be a pivot by itself
  const NodeId x = graph.add_node("x", 2, NodeKind::semidefinite), s = graph.add_node("s", 2, NodeKind::saddle);
  graph.add_edge(s, x, EdgeRank::full);
  for (const Ordering& ordering :
       {natural_ordering(graph), depth_first_ordering(graph), minimum_fill_ordering(graph)}) {
    EXPECT_TRUE(is_permutation_of_nodes(graph, ordering));
    EXPECT_EQ(ordering.forced, 1);
  }
}

TEST(Ordering, NaturalOrderOfRegularNodesIsTheOrderInWhichTheyWereAdded) {
  BlockGraph graph;
  for (int i = 0; i < 5; ++i) graph.add_node("n", 2);
  for (int i = 0; i < 4; ++i) graph.add_edge({i}, {i + 1});
  const Ordering ordering = natural_ordering(graph);
  EXPECT_EQ(ordering.sequence, (std::vector<NodeId>{{0}, {1}, {2}, {3}, {4}}));
  EXPECT_EQ(ordering.repairs, 0);
}

TEST(Ordering, DeferredNodesAreCountedAndComeAsSoonAsTheyMay) {
  const BlockGraph graph = families::chain(3);  // nodes 0 1 2, links 3 (0-1) and 4 (1-2)
  const std::vector<NodeId> wish{{3}, {4}, {0}, {1}, {2}};
  const Ordering ordering = user_ordering(graph, wish);
  EXPECT_EQ(ordering.sequence, (std::vector<NodeId>{{0}, {3}, {1}, {4}, {2}}));
  EXPECT_EQ(ordering.repairs, 2);
}

TEST(Ordering, DepthFirstPutsTheRootLastAndNeedsNoRepairOnATree) {
  const BlockGraph graph = families::random_tree(50, 3);
  for (const int root : {0, 7, 31}) {
    const Ordering ordering = depth_first_ordering(graph, {root});
    EXPECT_EQ(ordering.sequence.back(), NodeId{root});
    EXPECT_EQ(ordering.repairs, 0);
    EXPECT_EQ(Symbolic(graph, ordering).counts().fill_blocks, 0);
  }
}

TEST(Ordering, RootThatIsNotInTheGraphIsRefused) {
  EXPECT_THROW(static_cast<void>(depth_first_ordering(families::chain(2), {7})), std::invalid_argument);
}

TEST(Ordering, UserSequenceThatIsNoPermutationIsRefused) {
  const BlockGraph graph = families::chain(2);
  const std::vector<NodeId> twice{{0}, {0}, {1}}, shorter{{0}, {1}}, foreign{{0}, {1}, {7}};
  EXPECT_THROW(static_cast<void>(user_ordering(graph, twice)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(user_ordering(graph, shorter)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(user_ordering(graph, foreign)), std::invalid_argument);
}

}  // namespace test_ordering
