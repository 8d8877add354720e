#include "robust/scales.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace graphsolve {

namespace {

constexpr int equilibrations = 5;  ///< each halves the digits by which rows and columns differ

/// Sizes of the entries of a row or column: the largest, and the smallest but zeros.
struct Range {
  double largest = 0, smallest = std::numeric_limits<double>::infinity();

  void add(double size) {
    if (size == 0) return;
    largest = std::max(largest, size);
    smallest = std::min(smallest, size);
  }
  /// To the power -1/2, as a power of two; 1 where there is nothing to go by.
  [[nodiscard]] double half_way_to_one(bool middle) const {
    if (!(largest > 0) || !std::isfinite(largest)) return 1;
    if (!middle) return std::ldexp(1.0, -std::ilogb(largest) / 2);
    return std::ldexp(1.0, -(std::ilogb(largest) + std::ilogb(smallest)) / 4);
  }
};

}  // namespace

Scales scales_of(const Eigen::SparseMatrix<double>& a, int middle_passes) {
  Scales s{Eigen::VectorXd::Ones(a.rows()), Eigen::VectorXd::Ones(a.cols())};
  for (int pass = 0; pass < middle_passes + equilibrations; ++pass) {
    std::vector<Range> in_row(a.rows()), in_column(a.cols());
    for (int j = 0; j < a.outerSize(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry) {
        const double size = std::abs(s.row[entry.row()] * entry.value() * s.column[j]);
        in_row[entry.row()].add(size);
        in_column[j].add(size);
      }
    const bool middle = pass < middle_passes;
    for (Eigen::Index i = 0; i < a.rows(); ++i) s.row[i] *= in_row[i].half_way_to_one(middle);
    for (Eigen::Index j = 0; j < a.cols(); ++j) s.column[j] *= in_column[j].half_way_to_one(middle);
  }
  return s;
}

}  // namespace graphsolve
