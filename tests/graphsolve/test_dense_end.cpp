// The end of an elimination where fronts are large: single pivots, in groups, that keep half a panel.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <string>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"

namespace test_dense_end {

using namespace graphsolve;
using cases::right_hand_side;
using cases::view;

/// A mesh of nodes of one size, so that its dense end is made of groups.
BlockGraph mesh(int side, int rows) {
  BlockGraph graph;
  for (int i = 0; i < side * side; ++i) graph.add_node("n", rows);
  for (int i = 0; i < side * side; ++i) {
    if (i % side + 1 < side) graph.add_edge({i}, {i + 1});
    if (i + side < side * side) graph.add_edge({i}, {i + side});
  }
  return graph;
}

std::vector<cases::Case> with_dense_ends() {
  std::vector<cases::Case> list;
  for (int rows = 1; rows <= 6; ++rows)
    list.push_back({"mesh of " + std::to_string(rows), mesh(rows == 1 ? 36 : rows < 4 ? 18 : 11, rows)});
  for (int rows = 1; rows <= 3; ++rows) list.push_back({"grid of " + std::to_string(rows), families::grid(9, rows)});
  for (int seed = 1; seed <= 3; ++seed) list.push_back({"random " + std::to_string(seed), families::random_with_loops(60, 60, seed)});
  return list;
}

/// Saddle nodes have negative diagonals, as an LDL^T expects them; regular ones of every seventh node too, against their promise.
Eigen::MatrixXd symmetric_matrix(const BlockGraph& graph, std::uint64_t seed, bool broken_promises) {
  Eigen::MatrixXd a = families::dominant_matrix(graph, seed);
  a = (0.5 * (a + a.transpose())).eval();
  for (int i = 0; i < graph.size(); ++i) {
    if (graph.kind({i}) != NodeKind::saddle && !(broken_promises && i % 7 == 3)) continue;
    const int row = graph.row({i}), d = graph.dimension({i});
    a.block(row, row, d, d) *= -1;
  }
  return a;
}

Eigen::MatrixXd matrix_for(const BlockGraph& graph, FactorizationKind kind, std::uint64_t seed, bool broken_promises) {
  return kind == FactorizationKind::ldu ? families::dominant_matrix(graph, seed) : symmetric_matrix(graph, seed, broken_promises);
}

double error(const Eigen::MatrixXd& a, const Eigen::VectorXd& x, const Eigen::VectorXd& b) {
  return (a * x - b).norm() / (a.norm() * x.norm());
}

constexpr std::array kinds{FactorizationKind::ldu, FactorizationKind::ldlt};

TEST(DenseEnd, SolvesForAllKindsWithAndWithoutPacksAlsoWhereBlocksAreNotDefinite) {
  int seed = 0, largest = 0;
  for (const auto& [name, graph] : with_dense_ends())
    for (const FactorizationKind kind : kinds)
      for (const Packs packs : {Packs::on, Packs::off})
        for (const bool broken : {false, true}) {
          SCOPED_TRACE(name + ", kind " + std::to_string(static_cast<int>(kind)) + (packs == Packs::on ? ", packs" : "") + (broken ? ", broken" : ""));
          const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
          largest = std::max(largest, symbolic->counts().largest_front);
          const Eigen::MatrixXd a = matrix_for(graph, kind, ++seed, broken);
          Factorization f(symbolic, kind), one(symbolic, kind);
          families::load(a, graph, *symbolic, f.values());
          families::load(a, graph, *symbolic, one.values());
          ASSERT_TRUE(f.factorize().ok());
          const Eigen::VectorXd b = right_hand_side(graph.rows());
          Eigen::VectorXd x = b, y = b;
          f.solve(view(x));
          EXPECT_LE(error(a, x, b), 1e-13);
          ASSERT_TRUE(one.factorize_and_solve(view(y)).ok());
          EXPECT_EQ(x, y);
          Eigen::VectorXd transposed = b;
          f.solve_transposed(view(transposed));
          EXPECT_LE(error(a.transpose(), transposed, b), 1e-13);
        }
  EXPECT_GT(largest, 60);
}

TEST(DenseEnd, SeveralColumnsGiveWhatEachAloneDoes) {
  for (const auto& [name, graph] : with_dense_ends())
    for (const FactorizationKind kind : kinds)
      for (const Packs packs : {Packs::on, Packs::off}) {
        SCOPED_TRACE(name);
        const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
        const Eigen::MatrixXd a = matrix_for(graph, kind, 5, false);
        Factorization f(symbolic, kind);
        families::load(a, graph, *symbolic, f.values());
        ASSERT_TRUE(f.factorize().ok());
        constexpr int columns = 11;
        Eigen::VectorXd all = right_hand_side(columns * graph.rows());
        const Eigen::VectorXd before = all;
        f.solve(view(all), columns);
        for (int c = 0; c < columns; ++c) {
          Eigen::VectorXd x = before.segment(c * graph.rows(), graph.rows());
          f.solve(view(x));
          EXPECT_LE(cases::relative(all.segment(c * graph.rows(), graph.rows()), x), 1e-13);
        }
      }
}

TEST(DenseEnd, OfCopiesSideBySideHasTheBitsOfOneAlone) {
  const auto add = [](BlockGraph& to, const BlockGraph& from) {
    const int first = to.size();
    for (int i = 0; i < from.size(); ++i) to.add_node("n", from.dimension({i}), from.kind({i}));
    for (int i = 0; i < from.size(); ++i)
      for (const auto& edge : from.edges({i}))
        if (edge.to.index > i) to.add_edge({first + i}, {first + edge.to.index}, edge.rank);
  };
  for (const auto& [name, graph] : with_dense_ends()) {
    if (connected_components(graph).count > 1) continue;
    for (const FactorizationKind kind : kinds) {
      SCOPED_TRACE(name);
      constexpr int copies = 5;
      BlockGraph all;
      for (int c = 0; c < copies; ++c) add(all, graph);
      const auto one = minimum_fill_ordering(graph);
      std::vector<NodeId> sequence;
      for (const NodeId node : one.sequence)
        for (int c = 0; c < copies; ++c) sequence.push_back({c * graph.size() + node.index});
      const auto alone = std::make_shared<const Symbolic>(graph, one);
      const auto together = std::make_shared<const Symbolic>(all, user_ordering(all, sequence));
      const Eigen::MatrixXd a = matrix_for(graph, kind, 9, true);
      Factorization f(alone, kind), g(together, kind);
      families::load(a, graph, *alone, f.values());
      for (int i = 0; i < graph.size(); ++i)
        for (int j = 0; j < graph.size(); ++j) {
          const auto neighbours = graph.edges({i});
          if (i != j && std::ranges::none_of(neighbours, [&](const auto& e) { return e.to.index == j; })) continue;
          for (int c = 0; c < copies; ++c) {
            const BlockHandle h = together->block({c * graph.size() + i}, {c * graph.size() + j});
            for (int q = 0; q < h.columns; ++q)
              for (int p = 0; p < h.rows; ++p) g.values()[h.place(p, q)] = a(graph.row({i}) + p, graph.row({j}) + q);
          }
        }
      ASSERT_TRUE(f.factorize().ok());
      ASSERT_TRUE(g.factorize().ok());
      const Eigen::VectorXd b = right_hand_side(graph.rows());
      Eigen::VectorXd x = b, y = b.replicate(copies, 1);
      f.solve(view(x));
      g.solve(view(y));
      for (int c = 0; c < copies; ++c) EXPECT_EQ(y.segment(c * graph.rows(), graph.rows()), x) << c;
    }
  }
}

TEST(DenseEnd, FactoredAgainWhereSomeNodesChangedIsThatOfAWholeFactorization) {
  for (const auto& [name, graph] : with_dense_ends())
    for (const FactorizationKind kind : kinds)
      for (const Packs packs : {Packs::on, Packs::off}) {
        SCOPED_TRACE(name);
        const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
        Eigen::MatrixXd a = matrix_for(graph, kind, 4, true);
        Factorization f(symbolic, kind);
        families::load(a, graph, *symbolic, f.values());
        ASSERT_TRUE(f.factorize().ok());  // keeps half panels, which must not be taken for whole ones below
        f.allow_refactorization();
        f.keep_matrix(true);
        families::load(a, graph, *symbolic, f.values());
        ASSERT_TRUE(f.factorize().ok());
        const NodeId changed{graph.size() / 2};
        const int row = graph.row(changed), d = graph.dimension(changed);
        a.block(row, row, d, d) *= 1.5;
        const BlockHandle h = symbolic->block(changed, changed);
        for (int q = 0; q < d; ++q)
          for (int p = 0; p < d; ++p) f.kept_entry(h, p, q) = a(row + p, row + q);
        ASSERT_TRUE(f.refactorize(std::span(&changed, 1)).ok());
        const Eigen::VectorXd b = right_hand_side(graph.rows());
        Eigen::VectorXd x = b;
        f.solve(view(x));
        EXPECT_LE(error(a, x, b), 1e-13);
      }
}

}  // namespace test_dense_end
