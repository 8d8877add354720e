#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "graphsolve/sparse_matrix.hpp"

/// Sparse matrices of any bits, and whether two of them have the same.
namespace cases {

using namespace graphsolve;

inline void expect_same_bits(const SparseMatrix& a, const SparseMatrix& b) {
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.begin, b.begin);
  EXPECT_EQ(a.row, b.row);
  ASSERT_EQ(a.value.size(), b.value.size());
  for (std::size_t k = 0; k < a.value.size(); ++k)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(a.value[k]), std::bit_cast<std::uint64_t>(b.value[k])) << a.value[k];
}

/// Any bits that are a finite number: denormals, negative zero, the largest.
inline double any_double(std::mt19937_64& random) {
  while (true)
    if (const double value = std::bit_cast<double>(random()); std::isfinite(value)) return value;
}

inline SparseMatrix random_matrix(int rows, int columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Triplet> triplets;
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i)
      if (random() % 3 == 0) triplets.push_back({i, j, any_double(random)});
  return from_triplets(rows, columns, triplets);
}

inline SparseMatrix mirrored(int n, double sign, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Triplet> triplets;
  for (int j = 0; j < n; ++j) {
    for (int i = sign > 0 ? j : j + 1; i < n; ++i) {
      if (random() % 3 != 0) continue;
      const double value = any_double(random);
      triplets.push_back({i, j, value});
      if (i != j) triplets.push_back({j, i, sign * value});
    }
  }
  return from_triplets(n, n, triplets);
}

}  // namespace cases
