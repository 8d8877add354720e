#pragma once

#include <Eigen/SparseCore>

namespace graphsolve {

/// Size of a maximum matching of rows and columns along the entries (augmenting paths breadth first).
int structural_rank(const Eigen::SparseMatrix<double>& a);

/// Can every column be matched? Looks no further than to the first that cannot.
bool has_full_column_rank(const Eigen::SparseMatrix<double>& a);

}  // namespace graphsolve
