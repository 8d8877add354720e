#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/ordering.hpp"

/// What has no factor is not solved for, and what is no number has none.
namespace test_factor_states {

using namespace graphsolve;

const std::vector<FactorizationKind> kinds{FactorizationKind::ldu, FactorizationKind::ldlt, FactorizationKind::cholesky};

/// Nodes of one unknown that nothing couples.
struct Apart {
  BlockGraph graph;
  std::shared_ptr<const Symbolic> symbolic;
  explicit Apart(int nodes, Packs packs = Packs::off) {
    for (int i = 0; i < nodes; ++i) (void)graph.add_node("x" + std::to_string(i), 1);
    symbolic = std::make_shared<const Symbolic>(graph, natural_ordering(graph), packs);
  }
  void set(Factorization& f, int node, double value) const { f.entry(symbolic->block({node}, {node})) = value; }
};

TEST(FactorStates, AComponentThatWasNeverFactoredIsNotSolvedFor) {
  for (const FactorizationKind kind : kinds) {
    const Apart two(2);
    Factorization f(two.symbolic, kind);
    two.set(f, 0, 2), two.set(f, 1, 4);
    ASSERT_TRUE(f.factorize(0).ok());
    std::vector<double> x{1, 1};
    EXPECT_THROW(f.solve(x), std::logic_error);
    EXPECT_THROW(f.solve_component(x, 1), std::logic_error);
    f.solve_component(x, 0);
    EXPECT_EQ(x, (std::vector<double>{0.5, 1}));
    ASSERT_TRUE(f.factorize(1).ok());
    f.solve(x);
    EXPECT_EQ(x, (std::vector<double>{0.25, 0.25}));
    f.set_zero();
    EXPECT_THROW(f.solve(x), std::logic_error) << "its numbers are gone";
  }
}

/// A component that fails holds nobody else back, as in factorize().
TEST(FactorStates, ARefactorizationThatFailsFinishesTheOtherComponents) {
  for (const FactorizationKind kind : kinds) {
    const Apart three(3);
    Factorization f(three.symbolic, kind);
    f.allow_refactorization();
    f.keep_matrix(true);
    for (int i = 0; i < 3; ++i) three.set(f, i, 2);
    ASSERT_TRUE(f.factorize().ok());
    f.kept_entry(three.symbolic->block({0}, {0})) = std::nan("");
    f.kept_entry(three.symbolic->block({1}, {1})) = 8;
    const auto outcome = f.refactorize(std::vector<NodeId>{{0}, {1}});
    EXPECT_EQ(outcome.first_bad_pivot, three.symbolic->position({0}));
    std::vector<double> x{1, 1, 1};
    EXPECT_THROW(f.solve(x), std::logic_error);
    EXPECT_THROW(f.solve_component(x, 0), std::logic_error);
    f.solve_components(x, std::vector<int>{1, 2});
    EXPECT_EQ(x, (std::vector<double>{1, 0.125, 0.5}));
    f.kept_entry(three.symbolic->block({0}, {0})) = 4;
    ASSERT_TRUE(f.refactorize(std::vector<NodeId>{{0}}).ok());
    f.solve(x);
    EXPECT_EQ(x, (std::vector<double>{0.25, 0.125 / 8, 0.25}));
  }
}

/// The copy of one component says nothing of another.
TEST(FactorStates, WhatWasNotKeptIsNotRefined) {
  const Apart two(2);
  Factorization f(two.symbolic);
  f.allow_refactorization();
  two.set(f, 0, 2), two.set(f, 1, 4);
  f.keep_matrix(false);
  ASSERT_TRUE(f.factorize(0).ok());
  f.keep_matrix(true);
  ASSERT_TRUE(f.factorize(1).ok());
  const std::vector<double> b{1, 1};
  std::vector<double> x{0.5, 0.25};
  EXPECT_THROW((void)f.refine(b, x), std::logic_error);
  EXPECT_EQ(f.refine(b, x, std::vector<int>{1}, 2).backward_error, 0);
  EXPECT_THROW((void)f.refactorize(std::vector<NodeId>{{1}}), std::logic_error);
}

/// A shift that changed is one of the whole matrix.
TEST(FactorStates, AnotherShiftIsAppliedToAllThatIsFactoredAgain) {
  BlockGraph graph;
  for (const char* name : {"a", "b"}) {
    const NodeId x = graph.add_node(name, 1), row = graph.add_node(std::string(name) + " held", 1, NodeKind::saddle);
    graph.add_edge(x, row, EdgeRank::full);
  }
  const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), Packs::off);
  const auto factor = [&](Factorization& f) {
    f.allow_refactorization();
    f.keep_matrix(true);
    for (const int i : {0, 2}) {
      f.entry(symbolic->block({i}, {i})) = 1;
      f.entry(symbolic->block({i}, {i + 1})) = f.entry(symbolic->block({i + 1}, {i})) = 1;
    }
    return f.factorize().ok();
  };
  Factorization changed(symbolic, FactorizationKind::ldlt), fresh(symbolic, FactorizationKind::ldlt);
  ASSERT_TRUE(factor(changed));
  changed.set_saddle_shift(1e-2), fresh.set_saddle_shift(1e-2);
  ASSERT_TRUE(changed.refactorize(std::vector<NodeId>{{0}}).ok());
  ASSERT_TRUE(factor(fresh));
  std::vector<double> x{1, 2, 3, 4}, y = x;
  changed.solve(x), fresh.solve(y);
  EXPECT_EQ(x, y);
}

/// Two rows hold x twice, the second by so little another row that its pivot is `rest` after the first.
Factorization held_twice(double rest) {
  BlockGraph graph;
  const NodeId x = graph.add_node("x", 2), once = graph.add_node("once", 1, NodeKind::saddle),
               twice = graph.add_node("twice", 1, NodeKind::saddle);
  graph.add_edge(x, once, EdgeRank::full), graph.add_edge(x, twice, EdgeRank::full);
  const auto symbolic = std::make_shared<const Symbolic>(graph, natural_ordering(graph), Packs::off);
  Factorization f(symbolic, FactorizationKind::ldu);
  for (int i = 0; i < 2; ++i) f.entry(symbolic->block(x, x), i, i) = 1;
  for (const NodeId row : {once, twice}) f.entry(symbolic->block(row, x), 0, 0) = f.entry(symbolic->block(x, row), 0, 0) = 1;
  f.entry(symbolic->block(twice, x), 0, 1) = f.entry(symbolic->block(x, twice), 1, 0) = std::sqrt(rest);
  return f;
}

/// A multiplier that nearly is none of its own would be whatever is left of the residual, over the shift.
TEST(FactorStates, RowsThatNearlyDependAreLeftOutInsteadOfShifted) {
  for (const double rest : {0.0, 1e-10, 1e-6}) {
    Factorization shifted = held_twice(rest), left_out = held_twice(rest);
    shifted.set_saddle_shift(1e-12);
    left_out.set_saddle_shift(1e-12, 1e-8);
    EXPECT_EQ(shifted.factorize().dropped_rows, 0) << rest;
    EXPECT_EQ(left_out.factorize().dropped_rows, rest < 1e-8 ? 1 : 0) << rest;
    std::vector<double> x{0, 0, 1, 1 + 1e-7}, y = x;
    shifted.solve(x), left_out.solve(y);
    EXPECT_NEAR(y[0], 1, 1e-6) << rest;
    if (rest > 0) continue;
    EXPECT_GT(std::abs(x[3]), 1e4);
    EXPECT_EQ(y[3], 0);
    EXPECT_NEAR(y[2], -1, 1e-12);
  }
}

/// Eight of each, so that they go in packs where there are any.
struct Saddles {
  static constexpr int copies = 8;
  BlockGraph graph;
  std::shared_ptr<const Symbolic> symbolic;
  explicit Saddles(Packs packs) {
    for (int i = 0; i < copies; ++i) {
      const NodeId x = graph.add_node("x", 2), row = graph.add_node("row", 2, NodeKind::saddle);
      graph.add_edge(x, row);
    }
    symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
  }
  void fill(Factorization& f) const {
    for (int i = 0; i < copies; ++i)
      for (int k = 0; k < 2; ++k) {
        f.entry(symbolic->block({2 * i}, {2 * i}), k, k) = 1;
        f.entry(symbolic->block({2 * i}, {2 * i + 1}), k, k) = f.kind() == FactorizationKind::ldu ? -1 : 1;
        f.entry(symbolic->block({2 * i + 1}, {2 * i}), k, k) = 1;
      }
  }
};

/// A row of zeros ends the search for pivots, and must not hide what stands in the others.
TEST(FactorStates, NotANumberIsNotLeftOutAsADependentRow) {
  const double nan = std::nan("");
  for (const Packs packs : {Packs::off, Packs::on})
    for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::ldlt})
      for (const bool keep : {false, true}) {
        const Saddles all(packs);
        const auto expect_bad = [&](const char* where, auto&& spoil) {
          Factorization f(all.symbolic, kind);
          f.allow_refinement();
          f.keep_matrix(keep);
          all.fill(f);
          spoil(f, 3);  // of eight
          const auto outcome = f.factorize();
          EXPECT_FALSE(outcome.ok()) << where << ": " << outcome.dropped_rows << " rows left out";
          std::vector<double> x(4 * Saddles::copies, 1.0);
          EXPECT_THROW(f.solve(x), std::logic_error) << where;
        };
        const auto empty_rows = [&](Factorization& f, int i) {
          for (int k = 0; k < 2; ++k)
            f.entry(all.symbolic->block({2 * i}, {2 * i + 1}), k, k) = f.entry(all.symbolic->block({2 * i + 1}, {2 * i}), k, k) = 0;
        };
        expect_bad("in the block itself", [&](Factorization& f, int i) {
          empty_rows(f, i);
          const BlockHandle block = all.symbolic->block({2 * i + 1}, {2 * i + 1});
          f.entry(block, 0, 1) = f.entry(block, 1, 0) = nan;
        });
        expect_bad("in a coupling", [&](Factorization& f, int i) {
          empty_rows(f, i);
          f.entry(all.symbolic->block({2 * i + 1}, {2 * i}), 1, 0) = f.entry(all.symbolic->block({2 * i}, {2 * i + 1}), 0, 1) = nan;
        });
      }
}

/// One over 1e-310 is no number.
TEST(FactorStates, APivotWithoutAReciprocalIsNone) {
  for (const Packs packs : {Packs::off, Packs::on})
    for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::cholesky}) {
      const Apart eight(8, packs);
      for (const double least : {1e-310, 1e-300}) {
        Factorization f(eight.symbolic, kind);
        for (int i = 0; i < 8; ++i) eight.set(f, i, i == 5 ? least : 1.0);
        EXPECT_EQ(f.factorize().ok(), least > 1e-307);
      }
    }
}

TEST(FactorStates, WhatWasMovedFromReachesNoNumbers) {
  const Apart one(1);
  Factorization f(one.symbolic);
  Factorization g = std::move(f);
  EXPECT_TRUE(f.values().empty());  // NOLINT: that is what is asked
  EXPECT_EQ(g.values().size(), 1u);
  f = std::move(g);
  EXPECT_TRUE(g.values().empty());  // NOLINT
  one.set(f, 0, 2);
  EXPECT_TRUE(f.factorize().ok());
}

}  // namespace test_factor_states
