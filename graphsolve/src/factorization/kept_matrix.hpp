#pragma once

#include <Eigen/SparseCore>
#include <cmath>
#include <span>

#include "graphsolve/symbolic.hpp"

namespace graphsolve {

/// Calls f(row block, column block, handle) for every block of the matrix that is not fill.
template <class F>
void each_matrix_block(const Symbolic& s, F&& f) {
  for (int k = 0; k < s.pivots(); ++k) {
    const NodeId a = s.node(k);
    f(a, a, s.block(a, a));
    const auto coupled = s.coupled(k);
    for (int e = 0; e < static_cast<int>(coupled.size()); ++e) {
      if (s.is_fill(k, e)) continue;
      const NodeId b = s.node(coupled[e]);
      f(a, b, s.block(a, b));
      f(b, a, s.block(b, a));
    }
  }
}

/// The matrix in the user's numbering, from an array laid out like Factorization::values(). Zeros are left out.
inline Eigen::SparseMatrix<double> sparse_matrix(const Symbolic& s, std::span<const double> values) {
  std::vector<Eigen::Triplet<double>> entries;
  each_matrix_block(s, [&](NodeId a, NodeId b, const BlockHandle& h) {
    const int row = s.row(s.position(a)), column = s.row(s.position(b));
    for (int j = 0; j < h.columns; ++j)
      for (int i = 0; i < h.rows; ++i)
        if (const double value = values[h.place(i, j)]; value != 0) entries.emplace_back(row + i, column + j, value);
  });
  Eigen::SparseMatrix<double> a(s.rows(), s.rows());
  a.setFromTriplets(entries.begin(), entries.end());
  return a;
}

}  // namespace graphsolve
