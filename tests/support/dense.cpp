#include "support/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace dense {

Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.fullPivLu().solve(b); }
Eigen::VectorXd solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return a.fullPivLu().solve(b); }

Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& a) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(a).singularValues();
}

Eigen::MatrixXd unit_lower(const Eigen::MatrixXd& a) {
  return Eigen::FullPivLU<Eigen::MatrixXd>(a).matrixLU().triangularView<Eigen::UnitLower>();
}

Eigen::Index rank(const Eigen::MatrixXd& a, double threshold) {
  return Eigen::FullPivLU<Eigen::MatrixXd>(a).setThreshold(threshold).rank();
}

}  // namespace dense
