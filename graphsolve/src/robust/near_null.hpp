#pragma once

#include <Eigen/SparseCore>

namespace graphsolve {

/// The vector that a matrix shortens most, by the matrix itself: costs a general sparse LU.
struct NearNull {
  Eigen::VectorXd vector;  ///< of length 1; empty where none was found
  double shortened = 0;    ///< |A v|: from above close to the smallest singular value
  double shift = 0;        ///< of the diagonal, without which the LU met a pivot of zero: v can be no better than that
  double column = 0;       ///< length of the longest column: from below close to the largest one
};
NearNull near_null(const Eigen::SparseMatrix<double>& a);

/// What inverse iterations start from: of every row something, and no pattern that a matrix has.
Eigen::VectorXd uneven_vector(Eigen::Index rows);

}  // namespace graphsolve
