#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "graphsolve/symbolic.hpp"

/// Dense kernels on column-major blocks without padding, compiled for several instruction sets
/// (simd/block_kernels.cpp). What becomes of a column in bits does not depend on how many columns there are.
namespace graphsolve::kernels {

/// C (m x n) -= A (m x k) B (k x n); the columns of C and B lie `ldc` and `ldb` apart.
using Product = void (*)(double* c, std::ptrdiff_t ldc, const double* a, const double* b, std::ptrdiff_t ldb, int m,
                         int k, int n);
/// Lower triangle of C (m x m) -= A (m x k) B (k x m); what is above the diagonal of C is spoilt.
using LowerProduct = void (*)(double* c, const double* a, const double* b, int m, int k);
/// Prepares W (d x S blocks) for products with many L: the rows [begin, begin + d) of one that is `depth` deep, in
/// spread_size numbers.
using Spread = void (*)(const double* w, double* to, int d, int blocks, int begin, int depth);
/// Blocks of S x S at values + target[j], j in [begin, end), lose L (S x depth) times block j of the W that was spread.
using RowOfBlocks = void (*)(double* values, const std::int64_t* target, const double* l, const double* spread_w, int depth,
                             int begin, int end);
/// LU with row exchanges in place: L unit below the diagonal, reciprocals of the pivots on it. `rows[p]` is the row
/// that took place p. Returns the smallest pivot magnitude; below thresholds::least_pivot, or NaN, means not usable.
using Factor = double (*)(double* a, int* rows, int d);
/// LDL^T of a definite block without exchanges, from its lower triangle, into the form that Factor leaves: L unit
/// below the diagonal, reciprocals of the pivots on it, D L^T above. True when all pivots have the given sign (1 or
/// -1) and are larger than `tiny` times their reference; else the block is as it was (blocks without code of their own:
/// spoilt). Definite blocks need no exchanges: their elements do not grow.
using FactorDefinite = bool (*)(double* a, const double* reference, double sign, double tiny, int d);
/// The panel below a block that FactorDefinite has factored, blocks P of `rows` each, one after the other: lower := P L^-T D^-1,
/// upper (d x rows) := L^-1 P^T. Their product is P A^-1 P^T.
using Halve = void (*)(const double* a, double* lower, double* upper, int rows, int d, int blocks);
/// The same for blocks of S x S, of which L^-1 P^T goes spread (Spread, below) into rows [begin, begin + S) of one that is `depth` deep,
/// and P L^-T D^-1 also to l, from block to block `next` apart.
using HalveAndSpread = void (*)(const double* a, double* lower, double* l, std::ptrdiff_t next, double* spread_w, int blocks,
                                int begin, int depth);
/// X (d x n) := A^-1 X with the result of Factor or FactorDefinite; columns of X lie `stride` apart. Of the latter also the
/// halves: first L^-1 X, second L^-T D^-1 X.
using Solve = void (*)(const double* a, const int* rows, double* x, int d, int n, std::ptrdiff_t stride);

/// Of a solve: S rows each of x at ~places[coupled[j]] lose block j of L (S x d, one block after the other) times y (d).
using Forward = void (*)(double* x, const int* places, std::span<const int> coupled, const double* lower, const double* y,
                         int d);
/// y (d) loses W (d x S blocks) times the S rows of x at ~places[coupled[j]].
using Backward = void (*)(double* y, const int* places, std::span<const int> coupled, const double* upper, const double* x,
                          int d);
/// With what Halve leaves of S x S blocks: y (S) := L^-T (D^-1 y - (P L^-T D^-1)^T x), x as above.
using BackwardHalf = void (*)(const double* a, double* y, const int* places, std::span<const int> coupled, const double* lower,
                              const double* x);

/// Such a block j, at c, alone: d columns of L after d columns. `reference` (S) keeps the amounts of largest size, signed,
/// that were added to the entries of its diagonal.
using WatchedBlock = void (*)(double* c, double* reference, const double* l, const double* spread_w, int depth, int d, int j);
/// Blocks of S x S at c, one after the other, lose those of S x `depth` at l, `next` apart, times W (depth x S); depth is at
/// most at_once.
using ColumnOfBlocks = void (*)(double* c, const double* l, std::ptrdiff_t next, const double* w, int depth, int blocks);
/// Blocks of S x S, one after the other, transposed.
using Transpose = void (*)(const double* from, double* to, int blocks);
/// Numbers that a row of four blocks of a spread W takes: each begins with a cache line.
constexpr int spread_row(int s) { return (4 * s * s + 7) / 8 * 8; }
/// Numbers of a W of `depth` rows and S `blocks` columns when spread: four blocks lie together.
constexpr int spread_size(int depth, int blocks, int s) { return (blocks + 3) / 4 * depth * spread_row(s); }

inline constexpr int max_rows = 8;   ///< products have code of their own for up to so many rows
inline constexpr int max_fixed = 6;  ///< the others for blocks of up to so many,
inline constexpr int also_fixed = 12;  ///< and, but for lower products, for this many
inline constexpr int kinds_of_dimension = max_fixed + 2;
inline constexpr int max_spread = 4;  ///< S of rows of blocks
inline constexpr int at_once = 12;    ///< columns of L that they keep in registers
inline constexpr int max_equal = 6;   ///< S of solves

/// By size; place 0 is for any other.
struct Table {
  std::array<Product, max_rows + 1> products;
  Product also_product;
  std::array<LowerProduct, max_rows + 1> lower_products;
  std::array<Spread, max_spread> spreads;  ///< place S - 1
  std::array<HalveAndSpread, max_spread> halve_and_spreads;
  std::array<RowOfBlocks, max_spread> rows_of_blocks;
  std::array<WatchedBlock, max_spread> watched_blocks;
  std::array<ColumnOfBlocks, max_spread> columns_of_blocks;
  std::array<Transpose, max_spread> transposes;
  std::array<Forward, max_equal> forwards;
  std::array<Backward, max_equal> backwards;
  std::array<BackwardHalf, max_spread> backward_halves;
  std::array<Factor, kinds_of_dimension> factors;  ///< of these the last is for also_fixed
  std::array<FactorDefinite, kinds_of_dimension> definite_factors;
  std::array<Halve, kinds_of_dimension> halves;
  std::array<Solve, kinds_of_dimension> solves, first_solves, second_solves;

  [[nodiscard]] Product product(int m) const { return m == also_fixed ? also_product : products[m <= max_rows ? m : 0]; }
  [[nodiscard]] LowerProduct lower_product(int m) const { return lower_products[m <= max_rows ? m : 0]; }
  [[nodiscard]] static int kind(int d) { return d == also_fixed ? max_fixed + 1 : d <= max_fixed ? d : 0; }
  [[nodiscard]] Factor factor(int d) const { return factors[kind(d)]; }
  [[nodiscard]] FactorDefinite factor_definite(int d) const { return definite_factors[kind(d)]; }
  [[nodiscard]] Halve halve(int d) const { return halves[kind(d)]; }
  [[nodiscard]] Solve solve(int d) const { return solves[kind(d)]; }
  [[nodiscard]] Solve first_solve(int d) const { return first_solves[kind(d)]; }
  [[nodiscard]] Solve second_solve(int d) const { return second_solves[kind(d)]; }
};

/// For the instruction set in use (simd::instruction_set). Lives as long as the process.
const Table& table();

/// x := A^-T x with the result of Factor.
inline void solve_block_transposed(const double* a, const int* rows, double* x, int d) {
  for (int p = 0; p < d; ++p) {
    for (int i = 0; i < p; ++i) x[p] -= a[p * d + i] * x[i];
    x[p] *= a[p * d + p];
  }
  for (int p = d - 1; p >= 0; --p)
    for (int i = p + 1; i < d; ++i) x[p] -= a[p * d + i] * x[i];
  for (int p = d - 1; p >= 0; --p)
    if (rows[p] != p) std::swap(x[p], x[rows[p]]);
}

/// y (k) -= A^T x,  A (m x k)
inline void subtract_transposed_times_vector(double* __restrict y, const double* __restrict a,
                                             const double* __restrict x, int m, int k) {
  for (int p = 0; p < k; ++p) {
    double sum = 0;
    for (int i = 0; i < m; ++i) sum += a[p * m + i] * x[i];
    y[p] -= sum;
  }
}

}  // namespace graphsolve::kernels
