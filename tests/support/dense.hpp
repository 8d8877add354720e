#pragma once

#include <Eigen/Core>

/// Dense answers by Eigen, to compare with. Compiled once: files that decompose for themselves compile seconds longer.
namespace dense {

/// A^-1 B, LU with complete pivoting.
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::VectorXd solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// The shortest x with least |A x - b|.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
/// Of a symmetric matrix, whose lower triangle is read; ascending.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a);
/// Descending.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);
/// L of an LU with complete pivoting: no entry is larger than 1.
Eigen::MatrixXd unit_lower(const Eigen::MatrixXd& a);
/// Pivots of an LU with complete pivoting above this part of the largest.
Eigen::Index rank(const Eigen::MatrixXd& a, double threshold);

}  // namespace dense
