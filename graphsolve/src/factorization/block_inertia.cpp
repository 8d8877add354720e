#include "factorization/block_inertia.hpp"

#include <cmath>
#include <utility>

namespace graphsolve {

namespace {

/// Exchanges rows and columns p and q of the symmetric block.
void exchange(double* a, int d, int p, int q) {
  if (p == q) return;
  for (int j = 0; j < d; ++j) std::swap(a[j * d + p], a[j * d + q]);
  for (int i = 0; i < d; ++i) std::swap(a[p * d + i], a[q * d + i]);
}

struct Largest {
  int diagonal = 0, row = 0, column = 0;
  double on = -1, off = -1;
};

Largest find_largest(const double* a, int d, int p) {
  Largest found;
  for (int j = p; j < d; ++j) {
    if (std::abs(a[j * d + j]) > found.on) {
      found.on = std::abs(a[j * d + j]);
      found.diagonal = j;
    }
    for (int i = j + 1; i < d; ++i)
      if (std::abs(a[j * d + i]) > found.off) {
        found.off = std::abs(a[j * d + i]);
        found.row = i;
        found.column = j;
      }
  }
  return found;
}

void eliminate_one(double* a, int d, int p) {
  for (int j = p + 1; j < d; ++j) {
    const double factor = a[j * d + p] / a[p * d + p];
    for (int i = p + 1; i < d; ++i) a[j * d + i] -= a[p * d + i] * factor;
  }
}

void eliminate_two(double* a, int d, int p) {
  const double u = a[p * d + p], v = a[p * d + p + 1], w = a[(p + 1) * d + p + 1];
  const double determinant = u * w - v * v;  // negative: that is when a 2x2 pivot is chosen
  for (int j = p + 2; j < d; ++j) {
    const double x = a[j * d + p], y = a[j * d + p + 1];
    const double f = (w * x - v * y) / determinant, g = (u * y - v * x) / determinant;
    for (int i = p + 2; i < d; ++i) a[j * d + i] -= a[p * d + i] * f + a[(p + 1) * d + i] * g;
  }
}

}  // namespace

Inertia block_inertia(double* a, int d, const double* scale, int rank) {
  const double alpha = (1 + std::sqrt(17.0)) / 8;
  for (int j = 0; j < d; ++j)
    for (int i = 0; i < d; ++i) a[j * d + i] /= std::sqrt(scale[i]) * std::sqrt(scale[j]);
  Inertia inertia;
  int p = 0;
  while (p < rank) {
    const Largest largest = find_largest(a, d, p);
    if (!(largest.on > 0) && !(largest.off > 0)) break;
    if (largest.on >= alpha * largest.off) {
      exchange(a, d, p, largest.diagonal);
      ++(a[p * d + p] > 0 ? inertia.positive : inertia.negative);
      eliminate_one(a, d, p);
      p += 1;
    } else {
      exchange(a, d, p, largest.column);  // column < row: the second exchange leaves the first alone
      exchange(a, d, p + 1, largest.row);
      ++inertia.positive;
      ++inertia.negative;
      eliminate_two(a, d, p);
      p += 2;
    }
  }
  inertia.zero = d - p;
  return inertia;
}

}  // namespace graphsolve
