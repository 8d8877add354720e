#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
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

namespace test_wrong_arguments {

/// Sizes and numbers that do not fit are refused before anything is read or written.

using namespace graphsolve;

struct TwoNodes {
  BlockGraph graph;
  std::shared_ptr<const Symbolic> symbolic;
  TwoNodes() {
    (void)graph.add_node("a", 2);
    (void)graph.add_node("b", 1);
    symbolic = std::make_shared<const Symbolic>(graph, natural_ordering(graph));
  }
};

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

TEST(WrongArguments, AnInteriorPointNamesBatchesPortsAndComponentsThatAreNotThere) {
  TwoNodes two;
  Problem problem(two.graph);
  PortLawBatch<Bound, Nonnegative> bounds;
  bounds.add(Bound({0}, 0, Bound::Side::lower, 0.0), Nonnegative());
  problem.add(bounds);
  InteriorPoint solver(problem, two.symbolic);
  EXPECT_THROW(solver.activate(1, std::vector<int>{0}), std::invalid_argument);
  EXPECT_THROW(solver.activate(0, std::vector<int>{9}), std::invalid_argument);
  EXPECT_THROW(solver.select(std::vector<int>{2}), std::invalid_argument);
  for (const double scale : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(problem.set_row_scale({1}, std::vector<double>{scale}), std::invalid_argument);
}

TEST(WrongArguments, ABoundNeedsAComponentOfItsNode) {
  TwoNodes two;
  Problem problem(two.graph);
  PortLawBatch<Bound, Nonnegative> bounds;
  bounds.add(Bound({1}, 1, Bound::Side::lower, 0.0), Nonnegative());
  problem.add(bounds);
  EXPECT_THROW(InteriorPoint(problem, two.symbolic), std::invalid_argument);
}

TEST(WrongArguments, ABoundWithoutALimitIsToldFromOneThatCannotBeKept) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const auto& [side, limit] : {std::pair{Bound::Side::lower, infinity}, {Bound::Side::upper, -infinity},
                                    {Bound::Side::lower, std::nan("")}, {Bound::Side::upper, std::nan("")}})
    EXPECT_THROW(Bound({0}, 0, side, limit), std::invalid_argument);
  EXPECT_NO_THROW(Bound({0}, 0, Bound::Side::lower, -infinity));
  EXPECT_NO_THROW(Bound({0}, 0, Bound::Side::upper, infinity));
}

TEST(WrongArguments, AScaleOfALawIsANumberAboveZero) {
  for (const double scale : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW((void)Nonnegative(scale), std::invalid_argument);
  for (const double ratio : {0.0, -1.0, std::nan("")}) EXPECT_THROW((void)Nonnegative(1, ratio), std::invalid_argument);
}

/// x minimises |x|^2, with bounds x_0 >= 1 on the first batch and none at first on the second.
struct TwoBatches {
  TwoNodes two;
  Problem problem{two.graph};
  QuadraticCost cost;
  PortLawBatch<Bound, Nonnegative> first, second;
  TwoBatches() {
    cost.add_diagonal({0}, std::vector<double>{1, 1});
    cost.add_diagonal({1}, std::vector<double>{1});
    problem.add(cost);
    first.add(Bound({0}, 0, Bound::Side::lower, 1.0), Nonnegative());
    first.add(Bound({1}, 0, Bound::Side::lower, 1.0), Nonnegative());
    problem.add(first);
  }
};

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

TEST(WrongArguments, AnInteriorPointKnowsThatItsProblemHasGrown) {
  TwoBatches a;
  InteriorPoint solver(a.problem, a.two.symbolic);
  std::vector<double> x(3, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  a.second.add(Bound({0}, 1, Bound::Side::lower, 2.0), Nonnegative());
  a.problem.add(a.second);
  EXPECT_THROW((void)solver.solve(x), std::logic_error);
  EXPECT_THROW((void)solver.factorize_terms(x), std::logic_error);
  Factorization target(a.two.symbolic);
  EXPECT_THROW((void)solver.linearize(x, 0, 1e10, target), std::logic_error);
  InteriorPoint afterwards(a.problem, a.two.symbolic);
  ASSERT_EQ(afterwards.solve(x), Status::solved);
  EXPECT_NEAR(x[1], 2, 1e-7);
  a.second.add(Bound({1}, 0, Bound::Side::lower, 3.0), Nonnegative());  // to a batch that it knows
  EXPECT_THROW((void)afterwards.solve(x), std::logic_error);
}

/// Terms keep the places of one elimination: those of another would be written to.
TEST(WrongArguments, AnInteriorPointKnowsThatItsTermsWereWiredForAnother) {
  TwoBatches a;
  InteriorPoint solver(a.problem, a.two.symbolic);
  std::vector<double> x(3, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  InteriorPoint other(a.problem, a.two.symbolic);
  EXPECT_THROW((void)solver.solve(x), std::logic_error);
  ASSERT_EQ(other.solve(x), Status::solved);
  EXPECT_THROW((void)check_terms(a.problem, std::vector<double>(2, 0.0)), std::invalid_argument);
  ASSERT_EQ(other.solve(x), Status::solved);
  (void)check_terms(a.problem, x);
  EXPECT_THROW((void)other.solve(x), std::logic_error);
}

TEST(WrongArguments, AnInteriorPointKnowsThatOneOfItsTermsWentToAnotherProblem) {
  TwoBatches a;
  InteriorPoint solver(a.problem, a.two.symbolic);
  std::vector<double> x(3, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  Problem larger([&] {
    BlockGraph graph = a.two.graph;
    (void)graph.add_node("c", 4);
    return graph;
  }());
  larger.add(a.first);
  const InteriorPoint other(larger, std::make_shared<const Symbolic>(larger.graph(), minimum_fill_ordering(larger.graph())));
  EXPECT_THROW((void)solver.solve(x), std::logic_error);
}

TEST(WrongArguments, AnInteriorPointThatCannotBeMadeLeavesTheOneBeforeAlone) {
  TwoBatches a;
  InteriorPoint solver(a.problem, a.two.symbolic);
  EXPECT_THROW(InteriorPoint(a.problem, a.two.symbolic, {.tolerance = -1}), std::invalid_argument);
  BlockGraph turned;
  (void)turned.add_node("a", 1);
  (void)turned.add_node("b", 2);
  EXPECT_THROW(InteriorPoint(a.problem, std::make_shared<const Symbolic>(turned, natural_ordering(turned))),
               std::invalid_argument);
  std::vector<double> x(3, 0.0);
  EXPECT_EQ(solver.solve(x), Status::solved);
}

TEST(WrongArguments, AnInteriorPointLooksAtTheSizesOfWhatItIsGiven) {
  TwoBatches a;
  BlockGraph other;
  (void)other.add_node("alone", 3);
  EXPECT_THROW(InteriorPoint(a.problem, std::make_shared<const Symbolic>(other, natural_ordering(other))),
               std::invalid_argument);
  for (const InteriorPointSettings& wrong : {InteriorPointSettings{.tolerance = 0}, {.tolerance = std::nan("")},
                                             {.largest_product = -1}, {.max_iterations = 0}})
    EXPECT_THROW(InteriorPoint(a.problem, a.two.symbolic, wrong), std::invalid_argument);
  InteriorPoint solver(a.problem, a.two.symbolic);
  std::vector<double> few(2, 0.0), x(3, 0.0);
  Factorization target(a.two.symbolic), foreign(TwoNodes().symbolic);
  EXPECT_THROW((void)solver.factorize_terms(few), std::invalid_argument);
  EXPECT_THROW((void)solver.linearize(few, 0, 1e10, target), std::invalid_argument);
  EXPECT_THROW((void)solver.linearize(x, 0, 1e10, foreign), std::invalid_argument);
  Factorization symmetric(a.two.symbolic, FactorizationKind::ldlt);
  EXPECT_THROW((void)solver.linearize(x, 0, 1e10, symmetric), std::invalid_argument);
  EXPECT_THROW(solver.set_row_scale({0}, std::vector<double>{1}), std::invalid_argument);
  EXPECT_THROW(solver.set_row_scale({1}, std::vector<double>{1, 1}), std::invalid_argument);
  EXPECT_THROW(solver.set_row_scale({2}, std::vector<double>{1}), std::invalid_argument);
  EXPECT_THROW(solver.set_row_scale({1}, std::vector<double>{0}), std::invalid_argument);
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

TEST(WrongArguments, PortsAndComponentsAreNotNamedTwice) {
  TwoBatches a;
  InteriorPoint solver(a.problem, a.two.symbolic);
  std::vector<double> x(3, 0.0);
  for (const std::vector<int>& twice : {std::vector{1, 1}, {1, 0, 1}, {0, 1, 0, 1}}) {
    EXPECT_THROW(solver.activate(0, twice), std::invalid_argument);
    EXPECT_THROW(solver.select(twice), std::invalid_argument);
  }
  ASSERT_EQ(solver.solve(x), Status::solved);  // what was refused changed nothing
  EXPECT_NEAR(x[0] + x[2], 2, 1e-7);
  solver.activate(0, std::vector{1, 0});
  solver.select(std::vector{1, 0});
  x.assign(3, 0.0);
  ASSERT_EQ(solver.solve(x), Status::solved);
  EXPECT_NEAR(x[0] + x[2], 2, 1e-7);
}

TEST(WrongArguments, AProblemTakesNothingAtNodesThatAreNotThere) {
  TwoNodes two;
  Problem problem(two.graph);
  for (const int node : {-1, 2}) {
    PortLawBatch<Bound, Nonnegative> bounds;
    bounds.add(Bound({node}, 0, Bound::Side::lower, 0.0), Nonnegative());
    EXPECT_THROW(problem.add(bounds), std::invalid_argument);
    EXPECT_THROW(problem.set_row_scale({node}, std::vector<double>{1}), std::invalid_argument);
  }
  QuadraticCost nowhere;
  nowhere.add({}, {});
  EXPECT_THROW(problem.add(nowhere), std::invalid_argument);
  EXPECT_TRUE(problem.terms().empty());
  EXPECT_TRUE(problem.ports().empty());
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

TEST(WrongArguments, APortIsCheckedAtAPointOfAllRows) {
  const TwoNodes two;
  Bound bound({1}, 0, Bound::Side::lower, 0.5);
  for (const std::size_t rows : {0u, 1u, 2u, 4u})
    EXPECT_THROW((void)check_port(bound, *two.symbolic, std::vector<double>(rows, 1.0)), std::invalid_argument) << rows;
}

}  // namespace test_wrong_arguments
