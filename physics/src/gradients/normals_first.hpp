#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <span>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "simd/gradient_kernels.hpp"
#include "terms/sensitivity.hpp"

namespace physics {

/// What presses is kept before what sticks. In the matrix of a step normals and facets are springs of one stiffness:
/// where both hold one motion (a bar on a hinge with its tip on the floor) they would share a
/// disturbance by least squares, while in truth friction gives way. So the normals that yield are made rigid afterwards:
/// with S the inverse of the matrix, C, J, R their force per rate, rate by velocity and rate by pose, and z = S^T a the
/// adjoint,
///   z' = z - Y alpha,   Y = S^T J^T,   (C^T Y) alpha = C^T z;   by the pose R^T alpha goes in place of R^T C^T z.
/// This is the limit of infinite stiffness, by the formula of Woodbury.
class NormalsFirst {
 public:
  /// Rows of adjoints, a column per unknown; and what they make of the inputs, a column per number.
  using Pass = Eigen::Matrix<double, pass_columns, Eigen::Dynamic>;

  /// Looks for normals that yield, by what the adjoint `probe` (by row; lost) makes of them: two solves. Allocates
  /// only when there are some, a column of unknowns each. scratch: by row.
  void find(const graphsolve::Factorization& matrix, const Sensitivity& sensitivity, std::span<double> probe,
            std::span<double> scratch);

  [[nodiscard]] bool empty() const { return yielding_.empty(); }
  /// adjoint := z';  state (12 per body) -= R^T alpha
  void apply(const Sensitivity& sensitivity, std::span<double> adjoint, std::span<double> state) const;
  /// adjoints := z'. The alpha of each row are kept for subtract_poses.
  void apply(const Sensitivity& sensitivity, Pass& adjoints);
  /// by_state (12 columns per body) -= alpha R
  void subtract_poses(const Sensitivity& sensitivity, Pass& by_state) const;

 private:
  using Press = Sensitivity::Press;
  void make_rigid(const graphsolve::Factorization& matrix, const Sensitivity& sensitivity, std::size_t rows);

  std::vector<int> yielding_;  ///< of Sensitivity::pressing
  Eigen::MatrixXd response_;   ///< Y
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> shares_;  ///< C^T Y
  Eigen::MatrixXd alpha_;      ///< a column per row of the pass
};

}  // namespace physics
