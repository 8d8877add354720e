#pragma once

#include <cstdint>
#include <limits>

/// Multiplications and divisions of the dense kernels, for what is predicted and for what is counted.
namespace graphsolve {

/// LU of a d x d block, reciprocals of the pivots included.
constexpr std::int64_t lu_operations(std::int64_t d) {
  return d + d * (d - 1) / 2 + (d - 1) * d * (2 * d - 1) / 6;
}

/// LDL^T of a d x d block: reciprocals, multipliers, and one triangle of every update.
constexpr std::int64_t ldlt_operations(std::int64_t d) { return d + d * (d - 1) / 2 + (d - 1) * d * (d + 1) / 6; }

constexpr std::int64_t most_operations = std::numeric_limits<std::int64_t>::max();

/// A sum that stops at the largest number: what would take a century is not told apart.
constexpr void add_operations(std::int64_t& sum, std::int64_t operations) {
  sum = operations < most_operations - sum ? sum + operations : most_operations;
}

/// d m (d + m) and more would be beyond the largest number.
constexpr bool countless(std::int64_t d, std::int64_t m) {
  return static_cast<double>(d) * static_cast<double>(m) * static_cast<double>(d + m) > 9e18;
}

/// LU of such a block, and what it does to the m rows coupled to it.
constexpr std::int64_t lu_pivot_operations(std::int64_t d, std::int64_t m) {
  return countless(d, m) ? most_operations : lu_operations(d) + d * m * (d + m);
}

/// LDL^T of such a block, half a solve for each of the m rows coupled to it, and one triangle of what is between these.
constexpr std::int64_t ldlt_pivot_operations(std::int64_t d, std::int64_t m) {
  return countless(d, m) ? most_operations : ldlt_operations(d) + m * d * (d + 1) / 2 + d * m * (m + 1) / 2;
}

}  // namespace graphsolve
