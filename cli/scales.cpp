#include "scales.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cli {

using graphsolve::SparseMatrix;

namespace {

/// Sizes of the entries of a row or column: the largest and the smallest but zeros.
struct Range {
  double largest = 0, smallest = std::numeric_limits<double>::infinity();
  void add(double size) {
    if (size == 0) return;
    largest = std::max(largest, size);
    smallest = std::min(smallest, size);
  }
};

}  // namespace

Scales scales_of(const SparseMatrix& a, int middle_passes) {
  Scales s{std::vector<double>(a.rows, 1.0), std::vector<double>(a.rows, 1.0)};
  for (int pass = 0; pass < middle_passes + 5; ++pass) {
    const bool middle = pass < middle_passes;
    const auto size = [&](const Range& range) {
      return std::sqrt(middle ? std::sqrt(range.largest) * std::sqrt(range.smallest) : range.largest);
    };
    std::vector<Range> in_row(a.rows), in_column(a.rows);
    for (int j = 0; j < a.columns; ++j)
      for (std::int64_t k = a.begin[j]; k < a.begin[j + 1]; ++k) {
        const double entry = s.row[a.row[k]] * std::abs(a.value[k]) * s.column[j];
        in_row[a.row[k]].add(entry);
        in_column[j].add(entry);
      }
    for (int i = 0; i < a.rows; ++i) {
      if (in_row[i].largest > 0) s.row[i] /= size(in_row[i]);
      if (in_column[i].largest > 0) s.column[i] /= size(in_column[i]);
    }
  }
  return s;
}

}  // namespace cli
