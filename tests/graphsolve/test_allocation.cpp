// What the solver takes from the heap: nothing once it is set up, and before that what Symbolic::Counts says.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/robust_solver.hpp"
#include "support/count_allocations.hpp"
#include "support/problem_families.hpp"

namespace test_allocation {

using namespace graphsolve;
using allocation::Counting;
using families::Difficulty;
using families::Family;
using families::Problem;

class SolverAllocation : public testing::Test {
 protected:
  void SetUp() override {
    if (!allocation::counted) GTEST_SKIP() << "this build has an allocator that cannot be counted";
  }
};

/// Everything that promises to allocate nothing, twice, so that nothing depends on what came before.
void expect_no_allocation(const Problem& problem, Factorization& f, const std::string& what) {
  constexpr int columns = 5;
  const int rows = problem.graph.rows();
  std::vector<double> x(rows * columns, 1.0), null(rows);
  std::vector<NodeId> changed{{0}, {problem.graph.size() / 2}};
  std::vector<int> components(f.symbolic().components());
  std::iota(components.begin(), components.end(), 0);
  const std::span<double> one = std::span(x).first(rows);
  f.allow_refactorization();
  f.keep_matrix(true);
  for (int round = 0; round < 2; ++round) {
    families::load(problem.matrix, problem.graph, f.symbolic(), f.values());
    const Counting counting;
    ASSERT_TRUE(f.factorize().ok()) << what;
    f.solve(one);
    f.solve(x, columns);
    f.solve_component(one, 0);
    f.solve_components(one, components);
    f.solve_transposed(one);
    f.solve_transposed(x, columns);
    f.refine(cases::view(problem.right), one);
    EXPECT_EQ(Counting::so_far(), 0) << what << ": factorize, solve, refine";
    for (const Factorization::DroppedRow& dropped : f.dropped_rows()) f.dependency(dropped, null);
    EXPECT_EQ(Counting::so_far(), 0) << what << ": dependency";
    if (round == 1) {
      EXPECT_TRUE(f.refactorize(changed).ok()) << what;
    }
    EXPECT_EQ(Counting::so_far(), 0) << what << ": refactorize";
  }
  families::load(problem.matrix, problem.graph, f.symbolic(), f.values());
  const Counting counting;
  f.factorize(components);
  EXPECT_EQ(Counting::so_far(), 0) << what << ": components side by side";
}

TEST_F(SolverAllocation, NothingIsAllocatedAfterSetup) {
  int dropped = 0;
  for (const Family family : families::all_families())
    for (const Difficulty difficulty : {Difficulty::plain, Difficulty::redundant}) {
      const Problem problem = families::make_problem({.family = family, .n = 30, .difficulty = difficulty});
      const auto symbolic = std::make_shared<const Symbolic>(problem.graph, minimum_fill_ordering(problem.graph));
      for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
        Factorization f(symbolic, kind);
        expect_no_allocation(problem, f, problem.name);
        dropped += static_cast<int>(f.dropped_rows().size());
      }
    }
  EXPECT_GT(dropped, 0) << "the test shows nothing of dependent rows";
}

TEST_F(SolverAllocation, NothingIsAllocatedAfterSetupOfCholesky) {
  Problem problem = families::make_problem({.family = Family::ladder, .n = 30});
  problem.matrix = problem.matrix * problem.matrix;
  for (int i = 0; i < problem.graph.rows(); ++i) problem.matrix.coeffRef(i, i) += 1e-3;
  problem.name = "normal equations of " + problem.name;
  BlockGraph graph;  // of single rows: what the product couples
  for (int i = 0; i < problem.matrix.rows(); ++i) graph.add_node("row " + std::to_string(i), 1);
  for (int j = 0; j < problem.matrix.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(problem.matrix, j); entry; ++entry)
      if (entry.row() < j) graph.add_edge({static_cast<int>(entry.row())}, {j});
  problem.graph = std::move(graph);
  const auto symbolic = std::make_shared<const Symbolic>(problem.graph, minimum_fill_ordering(problem.graph));
  Factorization f(symbolic, FactorizationKind::cholesky);
  expect_no_allocation(problem, f, problem.name);
}

TEST_F(SolverAllocation, ARobustSolverTakesNothingOnItsFirstRungOnceItSolvedForAsManyColumns) {
  constexpr int columns = 3;
  for (const Difficulty difficulty : {Difficulty::plain, Difficulty::redundant})
    for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
      const Problem problem = families::make_problem({.family = Family::ladder, .n = 30, .difficulty = difficulty});
      RobustSolver solver(problem.graph, {.kind = kind});
      families::load(problem.matrix, problem.graph, solver.symbolic(), solver.values());
      const std::size_t rows = problem.graph.rows();
      std::vector<double> b(rows * columns), x(rows * columns);
      for (int c = 0; c < columns; ++c)
        for (std::size_t i = 0; i < rows; ++i) b[c * rows + i] = (c + 1) * problem.right[static_cast<Eigen::Index>(i)];
      const auto solve_twice = [&] {
        for (const double factor : {2.0, 0.5}) {
          solver.values()[0] *= factor;  // it factors again
          const auto report = solver.solve(b, x, columns);
          EXPECT_EQ(report.rung, Rung::factorization) << problem.name;
          EXPECT_EQ(report.outcome.dropped_rows > 0, difficulty == Difficulty::redundant) << problem.name;
          if (report.outcome.dropped_rows > 0) continue;  // the transposed matrix is factored then, once per set of values
          EXPECT_EQ(solver.solve_transposed(b, x, columns).rung, Rung::factorization) << problem.name;
        }
      };
      solve_twice();
      const Counting counting;
      solve_twice();
      EXPECT_EQ(Counting::so_far(), 0) << problem.name;
    }
}

TEST_F(SolverAllocation, PredictedMemoryIsWhatIsTaken) {
  for (const Family family : families::all_families()) {
    if (family == Family::quadruped) continue;  // too small to be measured among the allocator's own
    const BlockGraph graph = families::make_graph({.family = family, .n = 3000});
    const Ordering ordering = minimum_fill_ordering(graph);
    const std::int64_t before = allocation::bytes_in_use();
    const auto symbolic = std::make_shared<const Symbolic>(graph, ordering);
    const Factorization factorization(symbolic);
    const auto taken = static_cast<double>(allocation::bytes_in_use() - before);
    const auto predicted = static_cast<double>(symbolic->counts().memory);
    std::printf("             %-8s %6.0f bytes per node, predicted %6.0f\n", std::string(name(family)).c_str(),
                taken / graph.size(), predicted / graph.size());
    EXPECT_NEAR(predicted, taken, 0.01 * taken) << name(family);
  }
}

/// Heap of one setup, per node of the graph.
struct HeapUse {
  double allocations = 0;
  double asked = 0;  ///< bytes, what was freed again included
  double kept = 0;   ///< bytes, as predicted
};
HeapUse setup_of_chain(int n) {
  const BlockGraph graph = families::chain(n);
  const Counting counting;
  const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph));
  const Factorization factorization(symbolic);
  const double nodes = graph.size();
  return {static_cast<double>(Counting::so_far()) / nodes, static_cast<double>(Counting::bytes_so_far()) / nodes,
          static_cast<double>(symbolic->counts().memory) / nodes};
}

// Sizes are powers of two: a list that doubles its room as it grows has then the same part of it empty.
TEST_F(SolverAllocation, SetupOfAChainOfAMillionNodesTakesAsMuchPerNodeAsAShorterOne) {
  const HeapUse shorter = setup_of_chain(1 << 16), longer = setup_of_chain(1 << 19);
  std::printf("             %d and %d nodes: %.0f and %.0f bytes per node kept, %.0f and %.0f asked for in %.2f and %.2f pieces\n",
              (1 << 17) - 1, (1 << 20) - 1, shorter.kept, longer.kept, shorter.asked, longer.asked, shorter.allocations,
              longer.allocations);
  EXPECT_NEAR(longer.kept, shorter.kept, 0.01 * shorter.kept);
  EXPECT_NEAR(longer.asked, shorter.asked, 0.01 * shorter.asked);
  EXPECT_NEAR(longer.allocations, shorter.allocations, 0.01 * shorter.allocations);
}

}  // namespace test_allocation
