#include "graphsolve/sparse_matrix.hpp"

#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <cmath>
#include <random>

#include "graphsolve/io/eigen.hpp"
#include "matrix_cases.hpp"

namespace test_sparse_matrix {

// Sparse matrices to and from Eigen, their products, errors and symmetry.

using namespace graphsolve;
using namespace graphsolve::io;
using cases::expect_same_bits;
using cases::mirrored;
using cases::random_matrix;

TEST(EigenConversion, BothWaysKeepEveryBitAndExplicitZeros) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SparseMatrix matrix = random_matrix(7, 12, seed);
    expect_same_bits(from_eigen(to_eigen(matrix)), matrix);
    expect_same_bits(from_eigen(to_eigen<std::int64_t, Eigen::RowMajor>(matrix)), matrix);
  }
  Eigen::SparseMatrix<float> small(2, 2);
  small.insert(1, 0) = 0.5f;  // not compressed
  small.insert(0, 0) = 0;
  const SparseMatrix back = from_eigen(small);
  EXPECT_EQ(back.entries(), 2);
  EXPECT_EQ(back.value, (std::vector<double>{0, 0.5}));
  EXPECT_EQ(from_eigen(2.0 * to_eigen(back)).value[1], 1);
}

TEST(EigenConversion, AnIndexTypeThatCannotCountRowsColumnsOrEntriesIsRefused) {
  const std::vector<Triplet> one{{0, 0, 1.0}}, low{{39999, 0, 1.0}}, right{{0, 39999, 1.0}};
  EXPECT_THROW((void)to_eigen<short>(from_triplets(40000, 1, low)), std::invalid_argument);
  EXPECT_THROW((void)to_eigen<short>(from_triplets(1, 40000, right)), std::invalid_argument);
  EXPECT_THROW((void)to_eigen<short>(from_triplets(40000, 1, one)), std::invalid_argument);
  EXPECT_EQ(to_eigen<int>(from_triplets(40000, 1, low)).coeff(39999, 0), 1.0);
  EXPECT_EQ(to_eigen<short>(from_triplets(32767, 1, one)).coeff(0, 0), 1.0);
}

TEST(SparseMatrixTools, ProductsAndBackwardErrorsAreThoseOfDenseMatrices) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd dense = Eigen::MatrixXd::NullaryExpr(9, 9, [&] { return random() % 2 ? normal(random) : 0.0; });
  const SparseMatrix matrix = from_eigen(Eigen::SparseMatrix<double>(dense.sparseView()));
  const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(9, [&] { return normal(random); });
  Eigen::VectorXd y(9), b = dense * x;
  multiply(matrix, {x.data(), 9}, {y.data(), 9});
  EXPECT_LT((y - b).norm(), 1e-14);
  EXPECT_LT(backward_error(matrix, {b.data(), 9}, {x.data(), 9}).componentwise, 1e-15);
  b[3] += 1e-3;
  const BackwardError error = backward_error(matrix, {b.data(), 9}, {x.data(), 9});
  const Eigen::VectorXd denominator = dense.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs();
  EXPECT_NEAR(error.componentwise, 1e-3 / denominator[3], 1e-12);
  EXPECT_NEAR(error.normwise,
              1e-3 / (dense.cwiseAbs().rowwise().sum().maxCoeff() * x.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff()),
              1e-12);
  Eigen::VectorXd bad = x;
  bad[2] = std::nan("");
  EXPECT_TRUE(std::isnan(backward_error(matrix, {b.data(), 9}, {bad.data(), 9}).componentwise));
}

TEST(SparseMatrixTools, SymmetryIsJudgedByPatternAndByBits) {
  const std::vector<Triplet> lopsided{{0, 1, 1}, {1, 1, 2}, {2, 0, 1}, {0, 2, 1}};
  const SymmetryReport report = symmetry(from_triplets(3, 3, lopsided));
  EXPECT_EQ(report.unmatched, 1);
  EXPECT_FALSE(report.symmetric);
  EXPECT_TRUE(symmetry(mirrored(8, 1, 1)).symmetric);
  EXPECT_EQ(symmetry(mirrored(8, -1, 1)).unmatched, 0);
  EXPECT_THROW((void)from_triplets(2, 2, std::vector<Triplet>{{2, 0, 1}}), std::invalid_argument);
}

}  // namespace test_sparse_matrix
