#pragma once

#include <Eigen/SparseCore>

namespace graphsolve {

/// Size of a maximum matching of rows and columns along the entries (augmenting paths breadth first).
int structural_rank(const Eigen::SparseMatrix<double>& a);

}  // namespace graphsolve
