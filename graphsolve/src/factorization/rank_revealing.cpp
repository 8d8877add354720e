#include "factorization/rank_revealing.hpp"

#include <cmath>
#include <utility>

namespace graphsolve {

int factor_rank_revealing(double* a, int d, const double* reference, double threshold, int* rows, int* columns,
                          double* scratch) {
  double *row_scale = scratch, *column_scale = scratch + d;
  for (int i = 0; i < d; ++i) row_scale[i] = column_scale[i] = reference[i] > 0 ? 1 / std::sqrt(reference[i]) : 1;
  for (int p = 0; p < d; ++p) rows[p] = columns[p] = p;
  int p = 0;
  for (; p < d; ++p) {
    int best_row = p, best_column = p;
    double largest = 0;
    for (int j = p; j < d; ++j)
      for (int i = p; i < d; ++i) {
        const double candidate = std::abs(a[j * d + i]) * row_scale[i] * column_scale[j];
        if (candidate > largest) {
          largest = candidate;
          best_row = i;
          best_column = j;
        }
      }
    if (!(largest > threshold)) break;
    rows[p] = best_row;
    columns[p] = best_column;
    for (int j = 0; j < d; ++j) std::swap(a[j * d + p], a[j * d + best_row]);
    for (int i = 0; i < d; ++i) std::swap(a[p * d + i], a[best_column * d + i]);
    std::swap(row_scale[p], row_scale[best_row]);
    std::swap(column_scale[p], column_scale[best_column]);
    const double reciprocal = 1 / a[p * d + p];
    a[p * d + p] = reciprocal;
    for (int i = p + 1; i < d; ++i) a[p * d + i] *= reciprocal;
    for (int j = p + 1; j < d; ++j)
      for (int i = p + 1; i < d; ++i) a[j * d + i] -= a[p * d + i] * a[j * d + p];
  }
  for (int i = p; i < d; ++i) a[i * d + i] = 0;
  return p;
}

void solve_rank_deficient(const double* a, int d, int rank, const int* rows, const int* columns, double* x, int n) {
  for (int c = 0; c < n; ++c, x += d) {
    for (int p = 0; p < d; ++p) std::swap(x[p], x[rows[p]]);
    for (int p = 0; p < rank; ++p)
      for (int i = p + 1; i < rank; ++i) x[i] -= a[p * d + i] * x[p];
    for (int i = rank; i < d; ++i) x[i] = 0;
    for (int p = rank - 1; p >= 0; --p) {
      x[p] *= a[p * d + p];
      for (int i = 0; i < p; ++i) x[i] -= a[p * d + i] * x[p];
    }
    for (int p = d - 1; p >= 0; --p) std::swap(x[p], x[columns[p]]);
  }
}

void solve_rank_deficient_transposed(const double* a, int d, int rank, const int* rows, const int* columns, double* x) {
  for (int p = 0; p < d; ++p) std::swap(x[p], x[columns[p]]);
  for (int p = 0; p < rank; ++p) {
    for (int i = 0; i < p; ++i) x[p] -= a[p * d + i] * x[i];
    x[p] *= a[p * d + p];
  }
  for (int i = rank; i < d; ++i) x[i] = 0;
  for (int p = rank - 1; p >= 0; --p)
    for (int i = p + 1; i < rank; ++i) x[p] -= a[p * d + i] * x[i];
  for (int p = d - 1; p >= 0; --p) std::swap(x[p], x[rows[p]]);
}

}  // namespace graphsolve
