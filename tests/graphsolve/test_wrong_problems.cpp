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
#include "two_nodes.hpp"

namespace test_wrong_problems {

/// Problems, ports and interior points: what does not fit is refused before anything is read or written.

using namespace graphsolve;
using cases::TwoNodes;

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

TEST(WrongArguments, APortIsCheckedAtAPointOfAllRows) {
  const TwoNodes two;
  Bound bound({1}, 0, Bound::Side::lower, 0.5);
  for (const std::size_t rows : {0u, 1u, 2u, 4u})
    EXPECT_THROW((void)check_port(bound, *two.symbolic, std::vector<double>(rows, 1.0)), std::invalid_argument) << rows;
}

}  // namespace test_wrong_problems
