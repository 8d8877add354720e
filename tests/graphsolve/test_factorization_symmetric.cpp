#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"
#include "support/dense.hpp"

namespace test_factorization_symmetric {

// LDL^T and Cholesky on the plan of the LDU, against dense Eigen.

using namespace graphsolve;
using cases::relative;
using cases::right_hand_side;
using cases::view;

/// [H J^T; J -C] from [H -J^T; J C]: what saddle rows say changes its sign in their own columns.
Eigen::MatrixXd symmetric_saddle(const BlockGraph& graph, std::uint64_t seed) {
  Eigen::MatrixXd a = families::saddle_matrix(graph, seed);
  for (int k = 0; k < graph.size(); ++k)
    if (graph.kind({k}) == NodeKind::saddle) a.middleCols(graph.row({k}), graph.dimension({k})) *= -1;
  return a;
}

Eigen::MatrixXd symmetric_dominant(const BlockGraph& graph, std::uint64_t seed) {
  const Eigen::MatrixXd a = families::dominant_matrix(graph, seed);
  return 0.5 * (a + a.transpose());
}

/// Random symmetric values in every block, diagonal blocks of mixed signs and no small eigenvalue.
Eigen::MatrixXd symmetric_indefinite(const BlockGraph& graph, std::uint64_t seed) {
  Eigen::MatrixXd a = 0.1 * symmetric_dominant(graph, seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < graph.size(); ++k) {
    const int d = graph.dimension({k}), row = graph.row({k});
    const Eigen::MatrixXd g = Eigen::MatrixXd::NullaryExpr(d, d, [&] { return normal(random); });
    const Eigen::MatrixXd q = dense::unit_lower(g);
    Eigen::VectorXd signs = Eigen::VectorXd::NullaryExpr(d, [&](Eigen::Index i) { return (i + k) % 2 == 0 ? 8.0 : -8.0; });
    a.block(row, row, d, d) = q * signs.asDiagonal() * q.transpose();
    a.block(row, row, d, d).diagonal().array() *= 1e-3;  // no pivot to be had from the diagonal alone
  }
  return 0.5 * (a + a.transpose());
}

Inertia dense_inertia(const Eigen::MatrixXd& a, double zero = 1e-9) {
  const Eigen::VectorXd values = dense::eigenvalues(a);
  Inertia inertia;
  for (const double value : values)
    ++(std::abs(value) <= zero ? inertia.zero : value > 0 ? inertia.positive : inertia.negative);
  return inertia;
}

/// Only what the symmetric kinds say they read: the other triangle holds numbers that must not matter.
void load_lower_triangle(const Eigen::MatrixXd& a, const BlockGraph& graph, Factorization& f) {
  const Symbolic& s = f.symbolic();
  std::vector<int> place(a.rows());  // of each row in the elimination
  for (int k = 0, next = 0; k < s.pivots(); ++k)
    for (int i = 0; i < s.dimension(k); ++i) place[s.row(k) + i] = next++;
  Eigen::MatrixXd half = a;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j)
      if (place[j] > place[i] && a(i, j) != 0) half(i, j) = 1e3;
  families::load(half, graph, s, f.values());
}

TEST(SymmetricFactorization, LdltSolvesAndCountsSignsLikeDenseEigenOnEveryFamily) {
  for (const auto& [name, graph] : cases::all())
    for (const bool saddle : {true, false}) {
      const Eigen::MatrixXd a = saddle ? symmetric_saddle(graph, 7) : symmetric_indefinite(graph, 7);
      for (const Ordering& ordering : {natural_ordering(graph), minimum_fill_ordering(graph)}) {
        Factorization f(std::make_shared<const Symbolic>(graph, ordering), FactorizationKind::ldlt);
        load_lower_triangle(a, graph, f);
        const auto outcome = f.factorize();
        ASSERT_TRUE(outcome.ok()) << name;
        EXPECT_EQ(outcome.boosts, 0) << name;
        EXPECT_EQ(outcome.dropped_rows, 0) << name;
        EXPECT_EQ(outcome.inertia, dense_inertia(a)) << name << (saddle ? " saddle" : " indefinite");
        Eigen::VectorXd x = right_hand_side(a.rows()), y = x;
        const Eigen::VectorXd expected = dense::solve(a, x);
        f.solve(view(x));
        f.solve_transposed(view(y));
        EXPECT_LE(relative(x, expected), 1e-8) << name;
        EXPECT_EQ(x, y) << name;
      }
    }
}

TEST(SymmetricFactorization, CholeskySolvesDefiniteMatricesWhateverTheKindsOfTheirNodes) {
  for (const auto& [name, graph] : cases::all()) {
    const Eigen::MatrixXd a = symmetric_dominant(graph, 3);
    Factorization f(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)), FactorizationKind::cholesky);
    load_lower_triangle(a, graph, f);
    const auto outcome = f.factorize();
    ASSERT_TRUE(outcome.ok()) << name;
    EXPECT_EQ(outcome.inertia, (Inertia{graph.rows(), 0, 0})) << name;
    Eigen::VectorXd x = right_hand_side(a.rows());
    const Eigen::VectorXd expected = dense::solve(a, x);
    f.solve(view(x));
    EXPECT_LE(relative(x, expected), 1e-12) << name;
  }
}

TEST(SymmetricFactorization, CholeskyNamesTheBlockThatIsNotPositiveDefinite) {
  const BlockGraph graph = families::chain(5);
  Eigen::MatrixXd a = symmetric_dominant(graph, 3);
  a(graph.row({2}) + 4, graph.row({2}) + 4) = -1;
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)), FactorizationKind::cholesky);
  families::load(a, graph, f.symbolic(), f.values());
  const auto outcome = f.factorize();
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(f.symbolic().node(outcome.first_bad_pivot), NodeId{2});

  a(graph.row({2}) + 4, graph.row({2}) + 4) = std::numeric_limits<double>::quiet_NaN();
  families::load(a, graph, f.symbolic(), f.values());
  EXPECT_EQ(f.symbolic().node(f.factorize().first_bad_pivot), NodeId{2});
}

TEST(SymmetricFactorization, OperationsCountedAreOperationsPredicted) {
  for (const auto& [name, graph] : cases::all()) {
    const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph));
    for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt, FactorizationKind::cholesky}) {
      const Eigen::MatrixXd a =
          kind == FactorizationKind::ldlt ? symmetric_saddle(graph, 5) : symmetric_dominant(graph, 5);
      Factorization f(symbolic, kind);
      families::load(a, graph, *symbolic, f.values());
      const auto outcome = f.factorize();
      ASSERT_TRUE(outcome.ok()) << name;
      const auto& counts = symbolic->counts();
      EXPECT_EQ(outcome.operations, kind == FactorizationKind::ldu ? counts.operations : counts.symmetric_operations);
    }
  }
}

TEST(SymmetricFactorization, DependentRowsAreLeftOutAndCountAsZeroInTheInertia) {
  BlockGraph graph;
  const NodeId a = graph.add_node("a", 3), b = graph.add_node("b", 3);
  for (int k = 0; k < 4; ++k) {
    const NodeId link = graph.add_node("link " + std::to_string(k), 1, NodeKind::saddle);
    graph.add_edge(link, a, EdgeRank::full_row);
    graph.add_edge(link, b, EdgeRank::full_row);
  }
  Eigen::MatrixXd f = Eigen::MatrixXd::Zero(10, 10), j(4, 6);
  f.topLeftCorner(6, 6).setIdentity();
  j << 1, 2, 0, -1, 0, 1, 0, 1, 1, 2, -1, 0, 1, 3, 1, 1, -1, 1, 0, 0, 1, 0, 1, 2;  // third row: sum of the first two
  f.bottomLeftCorner(4, 6) = j;
  f.topRightCorner(6, 4) = j.transpose();
  Factorization factor(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)), FactorizationKind::ldlt);
  load_lower_triangle(f, graph, factor);
  const auto outcome = factor.factorize();
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.dropped_rows, 1);
  EXPECT_EQ(outcome.boosts, 0);
  EXPECT_EQ(outcome.inertia, (Inertia{6, 3, 1}));
  EXPECT_EQ(outcome.inertia, dense_inertia(f));
  Eigen::VectorXd y(10);
  factor.dependency(factor.dropped_rows()[0], view(y));
  EXPECT_LE((y.transpose() * f).cwiseAbs().maxCoeff(), 1e-12 * y.cwiseAbs().maxCoeff());
  Eigen::VectorXd x = f * right_hand_side(10);
  const Eigen::VectorXd rhs = x;
  factor.solve(view(x));
  EXPECT_LE((f * x - rhs).norm(), 1e-12 * rhs.norm());
}

TEST(SymmetricFactorization, PivotsOfNoSizeAreBoostedCountedAndRefinedAway) {
  // A regular node whose block has rank 1 and no neighbour that helps: singular, but the right-hand side is in range.
  BlockGraph graph;
  const NodeId good = graph.add_node("good", 2), flat = graph.add_node("flat", 2);
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(4, 4);
  a.bottomRightCorner(2, 2) << 1, 2, 2, 4;
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)), FactorizationKind::ldlt);
  f.allow_refinement();
  f.keep_matrix(true);
  families::load(a, graph, f.symbolic(), f.values());
  const auto outcome = f.factorize();
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.boosts, 1);
  EXPECT_EQ(outcome.inertia, (Inertia{3, 0, 1}));
  Eigen::VectorXd b(4), x(4);
  b << 1, 2, 3, 6;
  x = b;
  f.solve(view(x));
  const auto refined = f.refine({b.data(), 4}, view(x));
  EXPECT_LE(refined.backward_error, 1e-15);
  EXPECT_LE((a * x - b).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NE(good, flat);
}

TEST(SymmetricFactorization, ConstraintsEliminatedBeforeTheirVariablesAreSolvedByBoostsAndRefinement) {
  const BlockGraph graph = families::chain(4);
  const Eigen::MatrixXd a = symmetric_saddle(graph, 9);
  Ordering ordering;  // against the eligibility rule: all constraints first, their blocks exactly zero
  for (const bool saddle : {true, false})
    for (int k = 0; k < graph.size(); ++k)
      if ((graph.kind({k}) == NodeKind::saddle) == saddle) ordering.sequence.push_back({k});
  Factorization f(std::make_shared<const Symbolic>(graph, ordering), FactorizationKind::ldlt);
  f.allow_refinement();
  f.keep_matrix(true);
  families::load(a, graph, f.symbolic(), f.values());
  const auto outcome = f.factorize();
  ASSERT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.boosts, 9);
  EXPECT_GT(outcome.growth, 1e5);
  const Inertia truth = dense_inertia(a);  // no zeros: those counted are signs that are not known, the others bounds
  EXPECT_EQ(outcome.inertia, (Inertia{truth.positive, truth.negative - 9, 9}));
  const Eigen::VectorXd b = right_hand_side(a.rows());
  Eigen::VectorXd x = b;
  f.solve(view(x));
  EXPECT_LE(f.refine(view(b), view(x), 10).backward_error, 1e-15);
  EXPECT_LE(relative(x, dense::solve(a, b)), 1e-9);
}

TEST(SymmetricFactorization, GrowthIsOneWhereNothingGrowsAndMeasuredOnlyWithTheMatrix) {
  const BlockGraph graph = families::grid(4);
  const Eigen::MatrixXd a = symmetric_dominant(graph, 2);
  Factorization f(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)), FactorizationKind::cholesky);
  families::load(a, graph, f.symbolic(), f.values());
  EXPECT_EQ(f.factorize().growth, 0);
  f.allow_refinement();
  f.keep_matrix(true);
  families::load(a, graph, f.symbolic(), f.values());
  const double growth = f.factorize().growth;
  EXPECT_GT(growth, 0.5);
  EXPECT_LE(growth, 1);
}

TEST(Factorization, ManyRightHandSidesGiveTheBitsOfOneAtATime) {
  for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt})
    for (const auto& [name, graph] : cases::all()) {
      const Eigen::MatrixXd a =
          kind == FactorizationKind::ldu ? families::saddle_matrix(graph, 7) : symmetric_saddle(graph, 7);
      Factorization f(std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph)), kind);
      families::load(a, graph, f.symbolic(), f.values());
      ASSERT_TRUE(f.factorize().ok()) << name;
      for (const int columns : {0, 1, 2, 3, 5, 8, 19}) {
        Eigen::MatrixXd x(a.rows(), columns), y;
        for (int c = 0; c < columns; ++c) x.col(c) = right_hand_side(a.rows()).array() * (c + 1) + 0.1 * c;
        y = x;
        const Eigen::MatrixXd b = x;
        const auto size = static_cast<std::size_t>(x.size());
        f.solve({x.data(), size}, columns);
        f.solve_transposed({y.data(), size}, columns);
        for (int c = 0; c < columns; ++c) {
          Eigen::VectorXd one = b.col(c), transposed = b.col(c);
          f.solve(view(one));
          f.solve_transposed(view(transposed));
          EXPECT_EQ(one, x.col(c)) << name << " column " << c << " of " << columns;
          EXPECT_EQ(transposed, y.col(c)) << name << " column " << c << " of " << columns;
        }
      }
    }
}

TEST(Factorization, RightHandSidesOfAWrongSizeAreRefusedWithBothSizes) {
  const BlockGraph graph = families::chain(2);
  Factorization f(std::make_shared<const Symbolic>(graph, natural_ordering(graph)));
  std::vector<double> x(31);
  try {
    f.solve(x, 2);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "right-hand side has 31 numbers, expected 15 rows x 2 columns");
  }
}

}  // namespace test_factorization_symmetric
