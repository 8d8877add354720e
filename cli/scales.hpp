#pragma once

#include <vector>

#include "graphsolve/sparse_matrix.hpp"

/// Units of the rows and columns of a matrix, guessed from its entries.
namespace cli {

/// Rows and columns times these have largest entries near 1, so that units do not matter.
struct Scales {
  std::vector<double> row, column;
};

/// middle_passes: so many bring the middle of each row and column near 1 first, that of the logarithms. Where units of rows
/// and columns lie far apart, that finds them, and the largest entries alone do not.
Scales scales_of(const graphsolve::SparseMatrix& a, int middle_passes);

/// Whatever the units, a singular matrix stays it: it is only where both scalings say so.
template <class Test>
bool in_all_scales(const graphsolve::SparseMatrix& matrix, const Test& is_singular) {
  return is_singular(scales_of(matrix, 0)) && is_singular(scales_of(matrix, 30));
}

}  // namespace cli
