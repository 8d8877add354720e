#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "graphsolve/bound.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/port_batch.hpp"
#include "graphsolve/problem.hpp"
#include "graphsolve/robust_solver.hpp"

/// Sizes and numbers that do not fit are refused before anything is read or written.
namespace {

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

TEST(WrongArguments, ARobustSolverLooksAtBothSizes) {
  RobustSolver solver(TwoNodes().graph, {});
  std::vector<double> three(3, 1), two(2, 1);
  EXPECT_THROW((void)solver.solve(three, two), std::invalid_argument);
  EXPECT_THROW((void)solver.solve(two, three), std::invalid_argument);
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

}  // namespace
