#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "factorization_cases.hpp"
#include "graphsolve/diagnosis.hpp"
#include "graphsolve/robust_solver.hpp"
#include "support/graph_families.hpp"
#include "support/problem_families.hpp"

namespace test_singularity {

using namespace graphsolve;
using cases::view;

struct System {
  BlockGraph graph;
  Eigen::MatrixXd matrix;  ///< of small whole numbers: dense elimination with full pivoting tells its rank
};

/// Regular nodes of one to three rows, then saddle nodes without a block of their own; of two constraints one is often twice
/// the other.
System saddle_system(std::mt19937& random) {
  const auto from = [&](int least, int most) { return std::uniform_int_distribution(least, most)(random); };
  System system;
  const int nodes = from(3, 8), constraints = from(1, nodes / 2);
  std::vector<NodeId> regular, saddle;
  for (int k = 0; k < nodes; ++k) regular.push_back(system.graph.add_node("x" + std::to_string(k), from(1, 3)));
  for (int k = 0; k < constraints; ++k) saddle.push_back(system.graph.add_node("c" + std::to_string(k), 1, NodeKind::saddle));
  for (const NodeId x : regular)
    for (const NodeId c : saddle) system.graph.add_edge(c, x);
  const int n = system.graph.rows(), free = n - constraints;
  system.matrix = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < free; ++i) system.matrix(i, i) = from(1, 9);
  for (int c = free; c < n; ++c)
    for (int i = 0; i < free; ++i) system.matrix(c, i) = system.matrix(i, c) = from(-2, 2);
  if (constraints > 1 && from(0, 1) == 1) {
    system.matrix.row(n - 1).head(free) = 2 * system.matrix.row(free).head(free);
    system.matrix.col(n - 1).head(free) = 2 * system.matrix.col(free).head(free);
  }
  return system;
}

/// A full matrix of one to three rows per node; of two rows one is often another times three.
System full_system(std::mt19937& random) {
  const auto from = [&](int least, int most) { return std::uniform_int_distribution(least, most)(random); };
  System system;
  const int nodes = from(2, 8);
  for (int k = 0; k < nodes; ++k) {
    system.graph.add_node("x" + std::to_string(k), from(1, 3));
    for (int other = 0; other < k; ++other) system.graph.add_edge({other}, {k});
  }
  const int n = system.graph.rows();
  system.matrix = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return from(-4, 4); });
  if (from(0, 1) == 1) system.matrix.row(n - 1) = 3 * system.matrix.row(0);
  return system;
}

bool called_singular(const BlockGraph& graph, const Eigen::MatrixXd& a, FactorizationKind kind, OrderingMethod ordering) {
  RobustSolver solver(graph, {.kind = kind, .ordering = ordering});
  families::load(a, graph, solver.symbolic(), solver.values());
  const Factorization::Outcome outcome = solver.factorize();
  return is_singular(solver.factorization(), outcome);
}

using Make = System (*)(std::mt19937&);

/// Both kinds of mistake, in units that lie up to 2^200 apart, from orders that boost pivots or end early too.
void expect_no_mistake(Make make, const std::vector<FactorizationKind>& kinds, bool symmetric) {
  std::mt19937 random(7);
  int singular = 0, regular = 0;
  for (int round = 0; round < 300; ++round) {
    const System system = make(random);
    const int n = system.graph.rows(), far = std::array{0, 30, 100}[round % 3];
    const bool truth = Eigen::FullPivLU<Eigen::MatrixXd>(system.matrix).rank() < n;
    ++(truth ? singular : regular);
    const auto units = [&] {
      return Eigen::VectorXd::NullaryExpr(n, [&] { return std::ldexp(1.0, std::uniform_int_distribution(-far, far)(random)); }).eval();
    };
    const Eigen::VectorXd rows = units(), columns = symmetric ? rows : units();
    const Eigen::MatrixXd a = rows.asDiagonal() * system.matrix * columns.asDiagonal();
    for (const FactorizationKind kind : kinds)
      for (const OrderingMethod ordering : {OrderingMethod::minimum_fill, OrderingMethod::natural})
        EXPECT_EQ(called_singular(system.graph, a, kind, ordering), truth)
            << system.matrix << "\nround " << round << ", " << n << " rows, units to 2^" << far << ", kind " << static_cast<int>(kind) << ", "
            << name(ordering);
  }
  EXPECT_GT(singular, 50);
  EXPECT_GT(regular, 50);
}

TEST(Singularity, OfSaddleSystemsIsToldWhateverTheUnits) {
  expect_no_mistake(saddle_system, {FactorizationKind::ldlt, FactorizationKind::ldu}, true);
}

TEST(Singularity, OfUnsymmetricSystemsIsToldWhateverTheUnits) {
  expect_no_mistake(full_system, {FactorizationKind::ldu}, false);
}

TEST(Singularity, RegularFamiliesAreNotSingularAndRedundantRowsAre) {
  using families::Difficulty;
  for (const auto family : families::all_families())
    for (const auto difficulty : {Difficulty::plain, Difficulty::exact_saddle, Difficulty::redundant}) {
      const families::Problem problem = families::make_problem({.family = family, .n = 60, .difficulty = difficulty});
      for (const auto kind : {FactorizationKind::ldlt, FactorizationKind::ldu})
        EXPECT_EQ(called_singular(problem.graph, Eigen::MatrixXd(problem.matrix), kind, OrderingMethod::minimum_fill),
                  difficulty == Difficulty::redundant)
            << problem.name << ", kind " << static_cast<int>(kind);
    }
}

// Factors of another matrix: the saddle rows of one are shifted, and pivots of the other lose all digits to growth.
TEST(Singularity, IsJudgedByTheMatrixWhereTheFactorsAreOfAnother) {
  BlockGraph graph;
  const NodeId x = graph.add_node("x", 1), y = graph.add_node("y", 1);
  graph.add_edge(x, y);
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)), FactorizationKind::ldu);
  f.allow_refinement();
  f.keep_matrix(true);
  const auto verdict = [&](double corner) {
    f.set_zero();
    f.entry(f.symbolic().block(x, x)) = 1e-20;
    f.entry(f.symbolic().block(x, y)) = f.entry(f.symbolic().block(y, x)) = 1;
    f.entry(f.symbolic().block(y, y)) = corner;
    return is_singular(f, f.factorize());
  };
  EXPECT_FALSE(verdict(1));     // ((0, 1), (1, 1)) but for rounding; its second pivot is 1 - 1e20
  EXPECT_TRUE(verdict(1e20));   // the second row is 1e20 times the first
}

enum class Ends { held, free };

/// Springs in a row, of unequal stiffness where they are free: their sums are rounded then, and the matrix is singular but
/// for that.
bool row_of_springs_is_called_singular(int n, Ends ends, FactorizationKind kind) {
  BlockGraph graph;
  for (int i = 0; i < n; ++i) {
    graph.add_node("x" + std::to_string(i), 1);
    if (i > 0) graph.add_edge({i - 1}, {i});
  }
  RobustSolver solver(graph, {.kind = kind, .ordering = OrderingMethod::natural});
  const Symbolic& s = solver.symbolic();
  const auto add = [&](int i, int j, double value) { solver.entry(s.block({i}, {j})) += value; };
  for (int i = 0; i + 1 < n; ++i) {
    const double stiffness = ends == Ends::held ? 1 : 1 + 0.7 * std::sin(3.0 * i);
    for (const int k : {i, i + 1}) add(k, k, stiffness);
    add(i, i + 1, -stiffness);
    add(i + 1, i, -stiffness);
  }
  if (ends == Ends::held)
    for (const int i : {0, n - 1}) add(i, i, 1);
  return is_singular(solver.factorization(), solver.factorize());
}

// The smallest singular value of the former falls with n squared: 300000 rows leave 1e-10 of a vector, 1e5 times rounding.
TEST(Singularity, IsNoMatterOfTheNumberOfRows) {
  for (const int n : {100, 10000, 300000})
    EXPECT_FALSE(row_of_springs_is_called_singular(n, Ends::held, FactorizationKind::cholesky)) << n;
  for (const int n : {100, 1000, 10000})
    for (const auto kind : {FactorizationKind::ldlt, FactorizationKind::ldu})
      EXPECT_TRUE(row_of_springs_is_called_singular(n, Ends::free, kind)) << n;
}

TEST(Singularity, IsNotAskedOfWhatIsNoNumberOrWasNotKept) {
  BlockGraph graph;
  const NodeId x = graph.add_node("x", 2);
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)), FactorizationKind::ldlt);
  f.entry(f.symbolic().block(x, x)) = f.entry(f.symbolic().block(x, x), 1, 1) = 1;
  const auto outcome = f.factorize();
  EXPECT_THROW((void)is_singular(f, outcome), std::invalid_argument);
  f.allow_refinement();
  f.keep_matrix(true);
  f.set_zero();
  f.entry(f.symbolic().block(x, x)) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_singular(f, f.factorize()));
}

}  // namespace test_singularity
