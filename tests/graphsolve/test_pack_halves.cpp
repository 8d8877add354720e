#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <memory>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/simd/lane_blocks.hpp"
#include "support/dense.hpp"

namespace test_pack_halves {

using namespace graphsolve;
using cases::right_hand_side;
using cases::view;

/// A saddle system whose regular blocks of six hold two variables of three that do not know each other, but for
/// `coupling` between the first of both.
Eigen::MatrixXd halves_apart(const BlockGraph& graph, double coupling) {
  Eigen::MatrixXd matrix = families::saddle_matrix(graph, 3);
  for (int i = 0; i < graph.size(); ++i) {
    if (graph.kind({i}) != NodeKind::regular || graph.dimension({i}) != 6) continue;
    const int row = graph.row({i});
    matrix.block<3, 3>(row, row + 3).setZero();
    matrix.block<3, 3>(row + 3, row).setZero();
    matrix(row, row + 3) = matrix(row + 3, row) = coupling;
  }
  return matrix;
}

struct Result {
  Factorization::Outcome outcome;
  Eigen::VectorXd x;
};

Result solve(const BlockGraph& graph, const Eigen::MatrixXd& matrix) {
  Factorization f(std::make_shared<const Symbolic>(graph, wide_ordering(graph)));
  families::load(matrix, graph, f.symbolic(), f.values());
  Result result{f.factorize(), right_hand_side(graph.rows())};
  if (result.outcome.ok()) f.solve(view(result.x));
  return result;
}

/// Calls f for every instruction set that this machine has.
template <class F>
void with_each_instruction_set(F&& f) {
  const simd::InstructionSet before = simd::instruction_set();
  for (const auto set : simd::instruction_sets()) {
    simd::use_instruction_set(set);
    SCOPED_TRACE(std::string(name(set)));
    f();
  }
  simd::use_instruction_set(before);
}

TEST(PackHalves, AreSolvedWithTheBitsOfTheWholeBlock) {
  with_each_instruction_set([] {
    for (const BlockGraph& graph : {families::chain(50), families::balanced_tree(60), families::quadruped(), families::loop(30)}) {
      const Eigen::MatrixXd matrix = halves_apart(graph, 0);
      const Result apart = solve(graph, matrix), together = solve(graph, halves_apart(graph, 1e-290));
      ASSERT_TRUE(apart.outcome.ok());
      EXPECT_EQ(apart.x, together.x);
      const Eigen::VectorXd exact = dense::solve(matrix, right_hand_side(graph.rows()));
      EXPECT_LE((apart.x - exact).norm(), 1e-9 * exact.norm());
    }
  });
}

TEST(PackHalves, OneLaneThatIsCoupledIsSolvedWithIt) {
  const BlockGraph graph = families::chain(50);
  Eigen::MatrixXd matrix = halves_apart(graph, 0);
  const int row = graph.row({17});
  matrix(row + 1, row + 5) = 0.5;
  const Eigen::VectorXd exact = dense::solve(matrix, right_hand_side(graph.rows()));
  with_each_instruction_set([&] {
    const Result result = solve(graph, matrix);
    ASSERT_TRUE(result.outcome.ok());
    EXPECT_LE((result.x - exact).norm(), 1e-9 * exact.norm());
  });
}

TEST(PackHalves, AHalfThatNeedsExchangesGetsThem) {
  const BlockGraph graph = families::chain(50);
  Eigen::MatrixXd matrix = halves_apart(graph, 0);
  const int row = graph.row({17}) + 3;
  matrix(row, row) = matrix(row + 1, row + 1) = 0;
  matrix(row, row + 1) = matrix(row + 1, row) = 2;
  const Eigen::VectorXd exact = dense::solve(matrix, right_hand_side(graph.rows()));
  with_each_instruction_set([&] {
    const Result result = solve(graph, matrix);
    ASSERT_TRUE(result.outcome.ok());
    EXPECT_LE((result.x - exact).norm(), 1e-9 * exact.norm());
  });
}

TEST(PackHalves, WhatIsNoNumberBetweenThemIsNotOverlooked) {
  const BlockGraph graph = families::chain(50);
  for (const auto& [r, c] : {std::pair(0, 3), std::pair(5, 2), std::pair(2, 5), std::pair(3, 0)}) {
    Eigen::MatrixXd matrix = halves_apart(graph, 0);
    const int row = graph.row({17});
    matrix(row + r, row + c) = std::numeric_limits<double>::quiet_NaN();
    with_each_instruction_set([&] { EXPECT_FALSE(solve(graph, matrix).outcome.ok()); });
  }
}

}  // namespace test_pack_halves
