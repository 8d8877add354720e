#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "graphsolve/block_detection.hpp"
#include "graphsolve/entry_map.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/derivative_check.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/io/eigen.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/port_batch.hpp"
#include "graphsolve/problem.hpp"
#include "graphsolve/robust_solver.hpp"
#include "two_nodes.hpp"

namespace test_wrong_arguments {

/// Sizes and numbers that do not fit are refused before anything is read or written.

using namespace graphsolve;
using cases::TwoNodes;

TEST(WrongArguments, AFactorizationNamesComponentsAndNodesThatAreNotThere) {
  const TwoNodes two;
  EXPECT_THROW(Factorization(nullptr), std::invalid_argument);
  Factorization f(two.symbolic);
  f.allow_refinement();
  f.keep_matrix(true);
  EXPECT_THROW((void)f.factorize(2), std::invalid_argument);
  EXPECT_THROW((void)f.factorize(-1), std::invalid_argument);
  EXPECT_THROW((void)f.refactorize(std::vector<NodeId>{NodeId{0}}), std::logic_error);
  for (const int node : {0, 1}) {
    const BlockHandle h = two.symbolic->block({node}, {node});
    for (int i = 0; i < h.rows; ++i) f.entry(h, i, i) = 2;
  }
  ASSERT_TRUE(f.factorize().ok());
  std::vector<double> x(3, 1), b(3, 2), few(2, 1);
  EXPECT_THROW(f.solve_component(x, 7), std::invalid_argument);
  EXPECT_THROW((void)f.refine(few, x), std::invalid_argument);
  EXPECT_THROW((void)f.refine(b, few), std::invalid_argument);
  EXPECT_EQ(x, std::vector<double>(3, 1));
}

TEST(WrongArguments, AFactorizationSaysWhatHasToComeBefore) {
  const TwoNodes two;
  const auto load = [&](Factorization& f, double second) {
    for (const int node : {0, 1}) {
      const BlockHandle h = two.symbolic->block({node}, {node});
      for (int i = 0; i < h.rows; ++i) f.entry(h, i, i) = node == 0 ? 2 : second;
    }
  };
  std::vector<double> x(3, 1), b(3, 2);
  const std::vector<int> twice{1, 0, 1}, both{0, 1};
  Factorization f(two.symbolic);
  load(f, 2);
  EXPECT_THROW((void)f.factorize(twice), std::invalid_argument);
  EXPECT_THROW(f.solve(x), std::logic_error) << "a call that was refused has factored nothing";
  EXPECT_THROW((void)f.kept_entry(two.symbolic->block({0}, {0})), std::logic_error);
  f.keep_matrix(true);
  EXPECT_THROW((void)f.factorize(), std::logic_error) << "no room";
  EXPECT_THROW((void)f.factorize(both), std::logic_error);
  f.allow_refactorization();
  ASSERT_TRUE(f.factorize().ok());
  EXPECT_EQ(f.kept_entry(two.symbolic->block({1}, {1})), 2);
  std::copy(b.begin(), b.end(), x.begin());
  f.solve(x);
  EXPECT_EQ(f.refine(b, x).backward_error, 0);
  EXPECT_THROW(f.dependency({NodeId{0}, 0}, x), std::invalid_argument) << "it was not left out";
  f.keep_matrix(false);
  load(f, 4);
  ASSERT_TRUE(f.factorize().ok());
  EXPECT_THROW((void)f.refine(b, x), std::logic_error) << "the copy is of another matrix";
  f.keep_matrix(true);
  EXPECT_THROW((void)f.refactorize(std::vector<NodeId>{NodeId{0}}), std::logic_error);
  load(f, 0);
  ASSERT_FALSE(f.factorize().ok());
  EXPECT_THROW(f.solve(x), std::logic_error) << "there are no factors";
  EXPECT_THROW((void)f.refine(b, x), std::logic_error);
  f.solve_component(x, 0);  // the other component is sound
}

TEST(WrongArguments, WhatIsWrittenBeforeAllIsReadMustLieElsewhere) {
  const TwoNodes two;
  Factorization f(two.symbolic);
  f.allow_refinement();
  f.keep_matrix(true);
  RobustSolver robust(two.graph);
  std::vector<Triplet> entries;
  for (const int node : {0, 1}) {
    const BlockHandle h = two.symbolic->block({node}, {node}), r = robust.symbolic().block({node}, {node});
    for (int i = 0; i < h.rows; ++i) f.entry(h, i, i) = robust.entry(r, i, i) = 2;
  }
  for (int i = 0; i < 3; ++i) entries.push_back({i, i, 2});
  ASSERT_TRUE(f.factorize().ok());
  std::vector<double> four{1, 2, 3, 4};
  const std::span<double> x = std::span(four).first(3), shifted = std::span(four).last(3);
  EXPECT_THROW((void)f.refine(x, x), std::invalid_argument);
  EXPECT_THROW((void)f.refine_transposed(x, shifted), std::invalid_argument);
  const SparseMatrix matrix = from_triplets(3, 3, entries);
  EXPECT_THROW(multiply(matrix, x, shifted), std::invalid_argument);
  const BlockStructure structure = detect_blocks(matrix);
  EXPECT_THROW(structure.to_graph(x, x), std::invalid_argument);
  EXPECT_THROW(structure.to_matrix(shifted, x), std::invalid_argument);
  EXPECT_THROW((void)robust.solve(x, shifted), std::invalid_argument);
  EXPECT_EQ(four, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(robust.solve(x, x).status, Status::solved) << "it reads first";
  EXPECT_EQ(robust.solve_transposed(x, x).status, Status::solved);
  EXPECT_EQ(four, (std::vector<double>{0.25, 0.5, 0.75, 4}));
}

TEST(WrongArguments, WiringNamesTheNodeThatIsNotThere) {
  const TwoNodes two;
  const Wiring wiring(*two.symbolic, two.graph);
  EXPECT_EQ(wiring.row({1}), two.graph.row({1}));
  EXPECT_EQ(wiring.component({1}), two.symbolic->component({1}));
  const auto said = [](auto ask) -> std::string {
    try {
      ask();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing";
  };
  for (const int node : {-1, 2, 7}) {
    const std::string expected = "there is no node " + std::to_string(node);
    EXPECT_EQ(said([&] { (void)wiring.row({node}); }), expected);
    EXPECT_EQ(said([&] { (void)wiring.component({node}); }), expected);
    EXPECT_EQ(said([&] { (void)wiring.block({node}, {0}); }), expected);
  }
}

TEST(WrongArguments, CholeskyDoesNotCallAnIndefiniteMatrixSingular) {
  for (const auto kind : {FactorizationKind::cholesky, FactorizationKind::ldu}) {
    const TwoNodes two;
    Factorization f(two.symbolic, kind);
    for (const int node : {0, 1}) {
      const BlockHandle h = two.symbolic->block({node}, {node});
      for (int i = 0; i < h.rows; ++i) f.entry(h, i, i) = node == 0 ? 2 : kind == FactorizationKind::ldu ? 0 : -2;
    }
    ASSERT_FALSE(f.factorize().ok());
    std::vector<double> x(3, 1);
    try {
      f.solve(x);
      ADD_FAILURE() << "solved";
    } catch (const std::logic_error& error) {
      EXPECT_EQ(std::string(error.what()), std::string("solve: there are no factors of component 1, whose node 1 is ") +
                                               (kind == FactorizationKind::cholesky ? "not positive definite" : "singular"));
    }
  }
}

TEST(WrongArguments, ARobustSolverLooksAtBothSizes) {
  RobustSolver solver(TwoNodes().graph, {});
  std::vector<double> three(3, 1), two(2, 1);
  EXPECT_THROW((void)solver.solve(three, two), std::invalid_argument);
  EXPECT_THROW((void)solver.solve(two, three), std::invalid_argument);
  EXPECT_THROW((void)solver.solve(three, three, 2), std::invalid_argument);
  EXPECT_THROW((void)solver.solve_transposed(two, three), std::invalid_argument);
  EXPECT_THROW((void)solver.solve_transposed(three, three, 2), std::invalid_argument);
  EXPECT_THROW((void)solver.solve({}, {}, 0), std::invalid_argument);
}

/// A block of the factor alone is in no copy of the matrix: what was written there would be factored and not refined.
TEST(WrongArguments, BlocksThatOnlyTheFactorHasAreNotHandedOut) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 7), b = graph.add_node("b", 7), c = graph.add_node("c", 7);
  graph.add_edge(a, b);
  graph.add_edge(a, c);
  const Symbolic symbolic(graph, natural_ordering(graph));
  ASSERT_EQ(symbolic.counts().fill_blocks, 1);
  EXPECT_THROW((void)symbolic.block(b, c), std::invalid_argument);
  EXPECT_THROW((void)symbolic.block(c, b), std::invalid_argument);
  EXPECT_THROW((void)symbolic.block(a, NodeId{3}), std::invalid_argument);
  EXPECT_THROW((void)symbolic.block(NodeId{}, a), std::invalid_argument);
  EXPECT_EQ(symbolic.block(c, a).rows, 7);
}

TEST(WrongArguments, NothingIsSolvedBeforeItIsFactored) {
  const TwoNodes two;
  std::vector<double> x(3, 1.0);
  for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
    Factorization f(two.symbolic, kind);
    f.set_zero();
    for (int i = 0; i < 2; ++i) f.entry(two.symbolic->block({0}, {0}), i, i) = 2;
    f.entry(two.symbolic->block({1}, {1})) = 2;
    EXPECT_THROW(f.solve(x), std::logic_error);
    EXPECT_THROW(f.solve_component(x, 0), std::logic_error);
    EXPECT_THROW(f.solve_transposed(x), std::logic_error);
    EXPECT_EQ(x, std::vector<double>(3, 1.0));
    ASSERT_TRUE(f.factorize(0).ok());
    f.solve_component(x, 0);
    EXPECT_EQ(x[0], 0.5);
    x[0] = x[1] = 1;
  }
}

TEST(WrongArguments, AMatrixGoesToAndFroInItsOwnSizesOnly) {
  const SparseMatrix matrix = from_triplets(3, 3, std::vector<Triplet>{{0, 0, 2}, {1, 1, 2}, {2, 2, 2}, {0, 1, 1}});
  const BlockStructure blocks = detect_blocks(matrix);
  const Symbolic symbolic(blocks.graph, natural_ordering(blocks.graph));
  const EntryMap entries(matrix, blocks, symbolic);
  std::vector<double> three(3, 1), two(2, 1), values(symbolic.values_size()), more(values.size() + 1, 1);
  EXPECT_THROW(blocks.to_graph(two, three), std::invalid_argument);
  EXPECT_THROW(blocks.to_graph(three, two), std::invalid_argument);
  EXPECT_THROW(blocks.to_matrix(two, three), std::invalid_argument);
  EXPECT_THROW(blocks.to_matrix(three, two), std::invalid_argument);
  EXPECT_THROW(entries.write(three, values), std::invalid_argument);
  EXPECT_THROW(entries.write(matrix.value, more), std::invalid_argument);
  EXPECT_EQ(more, std::vector<double>(more.size(), 1));
  EXPECT_THROW(multiply(matrix, two, three), std::invalid_argument);
  EXPECT_THROW(multiply(matrix, three, two), std::invalid_argument);
  EXPECT_THROW((void)backward_error(matrix, two, three), std::invalid_argument);
  EXPECT_THROW((void)backward_error(matrix, three, two), std::invalid_argument);
  SparseMatrix crooked = matrix;
  crooked.row.back() = 7;
  EXPECT_THROW((void)io::to_eigen(crooked), std::invalid_argument);
  EXPECT_THROW(EntryMap(crooked, blocks, symbolic), std::invalid_argument);
  EXPECT_THROW((void)transpose(crooked), std::invalid_argument);
  EXPECT_THROW((void)symmetry(crooked), std::invalid_argument);
  EXPECT_THROW((void)transpose(SparseMatrix{3, 3, {0, 9, 9, 9}, {0}, {1.0}}), std::invalid_argument);
  EXPECT_THROW((void)transpose(SparseMatrix{-1, 3, {0, 0, 0, 0}, {}, {}}), std::invalid_argument);
  EXPECT_THROW((void)transpose(SparseMatrix{3, -1, {}, {}, {}}), std::invalid_argument);
}

TEST(WrongArguments, AnEntryMapTakesThePlanOfItsOwnGraph) {
  const auto diagonal = [](int n) {
    std::vector<Triplet> entries;
    for (int i = 0; i < n; ++i) entries.push_back({i, i, 2});
    return from_triplets(n, n, entries);
  };
  const SparseMatrix matrix = diagonal(3);
  BlockStructure blocks = detect_blocks(matrix);
  const TwoNodes two;  // three rows as well, but in two blocks
  EXPECT_THROW(EntryMap(matrix, blocks, *two.symbolic), std::invalid_argument);
  for (const int n : {2, 4}) {
    const BlockStructure others = detect_blocks(diagonal(n));
    EXPECT_THROW(EntryMap(matrix, blocks, Symbolic(others.graph, natural_ordering(others.graph))), std::invalid_argument);
  }
  BlockGraph turned;  // as many blocks and rows, otherwise divided
  (void)turned.add_node("a", 1);
  (void)turned.add_node("b", 2);
  BlockStructure ours = blocks;
  ours.graph = two.graph;
  EXPECT_THROW(EntryMap(matrix, ours, Symbolic(turned, natural_ordering(turned))), std::invalid_argument);
  EXPECT_NO_THROW(EntryMap(matrix, ours, *two.symbolic));
  ours.row_of.back() = 3;
  EXPECT_THROW(EntryMap(matrix, ours, *two.symbolic), std::invalid_argument);
  ours.row_of.pop_back();
  EXPECT_THROW(EntryMap(matrix, ours, *two.symbolic), std::invalid_argument);
}

}  // namespace test_wrong_arguments
