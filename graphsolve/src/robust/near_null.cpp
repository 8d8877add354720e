#include "robust/near_null.hpp"

#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>

namespace graphsolve {

Eigen::VectorXd uneven_vector(Eigen::Index rows) {
  return Eigen::VectorXd::NullaryExpr(rows, [](Eigen::Index i) { return 1 + 0.5 * std::sin(2.3 * static_cast<double>(i)); });
}

namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Inverse iteration with A'A; empty where the factors are not those of a regular matrix.
Eigen::VectorXd iterate(const Matrix& a) {
  Eigen::SparseLU<Matrix> lu;
  lu.compute(a);
  if (lu.info() != Eigen::Success) return {};
  Eigen::VectorXd best, v = uneven_vector(a.rows());
  for (int sweep = 0; sweep < 6; ++sweep) {
    const Eigen::VectorXd w = lu.transpose().solve(v.normalized()).normalized();
    v = lu.solve(w);
    if (!v.allFinite() || v.norm() == 0) break;
    best = v.normalized();
    if (!best.allFinite()) return {};
  }
  return best;
}

}  // namespace

/// Moved off a singular point by a shift of rounding size.
NearNull near_null(const Matrix& a) {
  NearNull result;
  for (int j = 0; j < a.cols(); ++j) result.column = std::max(result.column, a.col(j).norm());
  Matrix identity(a.rows(), a.cols());
  identity.setIdentity();
  const double size = result.column > 0 ? result.column : 1;
  for (const double shift : {0.0, 1e-15, 1e-13, 1e-11}) {
    result.shift = shift * size;
    result.vector = iterate(a + result.shift * identity);
    if (result.vector.size() > 0) break;
  }
  if (result.vector.size() > 0) result.shortened = (a * result.vector).norm();
  return result;
}

}  // namespace graphsolve
