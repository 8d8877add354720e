#pragma once

#include <Eigen/SparseCore>

namespace graphsolve {

/// Units of the rows and columns of a matrix, guessed from its entries: powers of two, so that nothing is rounded. Rows and
/// columns times these have largest entries near 1.
struct Scales {
  Eigen::VectorXd row, column;

  [[nodiscard]] Eigen::SparseMatrix<double> applied_to(const Eigen::SparseMatrix<double>& a) const {
    return row.asDiagonal() * a * column.asDiagonal();
  }
};

/// Ruiz 2001, "A scaling algorithm to equilibrate both rows and columns norms in matrices". middle_passes: so many before it
/// bring the middle of each row and column near 1, that of the logarithms. Where units of rows and columns lie far apart,
/// that finds them, and the largest entries alone do not.
Scales scales_of(const Eigen::SparseMatrix<double>& a, int middle_passes = 0);

}  // namespace graphsolve
