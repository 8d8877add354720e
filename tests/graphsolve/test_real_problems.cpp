#include "support/real_problems.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "graphsolve/entry_map.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/io/draw.hpp"
#include "graphsolve/io/matrix_market.hpp"
#include "graphsolve/robust_solver.hpp"
#include "graphsolve/supernodes.hpp"

namespace test_real_problems {

using namespace graphsolve;
using families::Problem;

/// What a factorization with refinement makes of a problem, with and without merged nodes.
struct Solved {
  bool ok = false;
  double error = 0;  ///< componentwise backward error, measured here
  double said = 0;   ///< the same as the solver reports it
};
Solved solve(const Problem& problem, FactorizationKind kind, bool merge) {
  const Ordering ordering = minimum_fill_ordering(problem.graph);
  Supernodes nodes;
  if (merge) nodes = merge_supernodes(problem.graph, ordering);
  std::vector<int> row_of = nodes.row_of;
  if (!merge)
    for (int i = 0; i < problem.graph.rows(); ++i) row_of.push_back(i);
  const BlockGraph& graph = merge ? nodes.graph : problem.graph;
  Factorization f(std::make_shared<const Symbolic>(graph, merge ? nodes.ordering : ordering), kind);
  Eigen::PermutationMatrix<Eigen::Dynamic> permutation(graph.rows());
  std::copy(row_of.begin(), row_of.end(), permutation.indices().data());
  Eigen::SparseMatrix<double> a;
  a = problem.matrix.twistedBy(permutation);
  Eigen::VectorXd b = permutation * problem.right, x = b;
  families::load(a, graph, f.symbolic(), f.values());
  f.allow_refinement();
  f.keep_matrix(true);
  const std::span<double> xs{x.data(), static_cast<std::size_t>(x.size())};
  const std::span<const double> bs{b.data(), static_cast<std::size_t>(b.size())};
  if (!f.factorize().ok()) return {};
  f.solve(xs);
  const double said = f.refine(bs, xs, 10).backward_error;
  return {true, families::backward_error(a, xs, bs), said};
}

bool symmetric(const Problem& problem) {
  return (problem.matrix - Eigen::SparseMatrix<double>(problem.matrix.transpose())).norm() == 0;
}

/// No order of scalars from the pattern alone is safe for these.
const std::set<std::string> indefinite{"hangGlider_2", "tumorAntiAngiogenesis_2", "impcol_a"};

void check(const std::string& name, const Solved& solved) {
  if (!indefinite.contains(name)) {
    EXPECT_TRUE(solved.ok) << name;
    EXPECT_LE(solved.error, 1e-10) << name;
  } else if (solved.ok) {
    EXPECT_LE(solved.error, 1e-14 + 2 * solved.said) << name;  // a bad solution is never called a good one
  }
}

TEST(RealProblems, MatricesAreSolvedToRoundingAndWhatCannotBeSolvedInThisOrderIsSaid) {
  if (!families::data_directory()) GTEST_SKIP() << "no data";
  ASSERT_GE(families::real_matrices().size(), 20u);
  for (const std::string& name : families::real_matrices()) {
    const Problem problem = families::real_matrix(name);
    for (const bool merge : {false, true}) {
      check(name, solve(problem, FactorizationKind::ldu, merge));
      if (symmetric(problem)) check(name, solve(problem, FactorizationKind::ldlt, merge));
    }
  }
}

TEST(RealProblems, TheFallbackSolvesEveryMatrixAndIsReportedWhereItWasNeeded) {
  if (!families::data_directory()) GTEST_SKIP() << "no data";
  for (const std::string& name : families::real_matrices()) {
    const Problem problem = families::real_matrix(name);
    RobustSolver solver(problem.graph);
    families::load(problem.matrix, problem.graph, solver.symbolic(), solver.values());
    Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.right.size());
    const auto report = solver.solve({problem.right.data(), static_cast<std::size_t>(x.size())},
                                     {x.data(), static_cast<std::size_t>(x.size())});
    ASSERT_EQ(report.status, Status::solved) << name << ": " << report.why;
    EXPECT_LE((problem.matrix * x - problem.right).norm(), 1e-10 * problem.right.norm()) << name;
    EXPECT_EQ(report.rung == Rung::factorization, report.why.empty()) << name << ": " << report.why;
    EXPECT_TRUE(!indefinite.contains(name) || report.rung != Rung::factorization) << name;
  }
}

TEST(RealProblems, NormalMatricesOfPoseGraphsAreSolvedToRoundingByEveryFactorization) {
  if (!families::data_directory()) GTEST_SKIP() << "no data";
  ASSERT_GE(families::pose_graphs().size(), 4u);
  for (const std::string& name : families::pose_graphs()) {
    const Problem problem = families::pose_graph(name);
    ASSERT_TRUE(symmetric(problem)) << name;
    for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt, FactorizationKind::cholesky}) {
      const Solved solved = solve(problem, kind, false);
      EXPECT_TRUE(solved.ok) << name;
      EXPECT_LE(solved.error, 1e-15) << name;
    }
  }
}

/// Optimality systems of control problems whose final time is free: every constraint has it.
TEST(RealProblems, AFinalTimeGoesLastInsteadOfCouplingAllConstraints) {
  if (!families::data_directory()) GTEST_SKIP() << "no data";
  for (const std::string name : {"hangGlider_2", "tumorAntiAngiogenesis_2"}) {
    const SparseMatrix matrix = io::read_matrix_market(families::data_directory().value() + "/matrices/" + name + ".mtx").matrix;
    const BlockStructure blocks = detect_blocks(matrix);
    int shared = 0;
    for (int i = 0; i < blocks.graph.size(); ++i) shared += blocks.graph.kind({i}) == NodeKind::shared;
    EXPECT_EQ(shared, 1) << name;
    const auto symbolic = std::make_shared<const Symbolic>(blocks.graph, minimum_fill_ordering(blocks.graph));
    EXPECT_LE(io::fill_ratio(*symbolic), 3) << name;
    Factorization f(symbolic, FactorizationKind::ldlt);
    EntryMap(matrix, blocks, *symbolic).write(matrix.value, f.values());
    f.allow_refinement();
    f.keep_matrix(true);
    const Factorization::Outcome outcome = f.factorize();
    ASSERT_TRUE(outcome.ok()) << name;
    EXPECT_EQ(outcome.boosts + outcome.dropped_rows, 0) << name;
    std::vector<double> b(matrix.rows, 1.0), x = b;
    f.solve(x);
    EXPECT_LE(f.refine(b, x, 10).backward_error, 1e-14) << name;
  }
}

TEST(RealProblems, MergedNodesPromiseOneAndAHalfTimesTheSpeedOnMeshes) {
  if (!families::data_directory()) GTEST_SKIP() << "no data";
  for (const std::string name : {"dwt_878", "dwt_992", "jagmesh7"}) {
    const Problem problem = families::real_matrix(name);
    const Ordering ordering = minimum_fill_ordering(problem.graph);
    const Supernodes merged = merge_supernodes(problem.graph, ordering);
    EXPECT_LE(1.5 * predicted_time(merged.graph, merged.ordering), predicted_time(problem.graph, ordering)) << name;
  }
}

}  // namespace test_real_problems
