#pragma once

#include <cstdint>

/// Multiplications and divisions of the dense kernels, for what is predicted and for what is counted.
namespace graphsolve {

/// LU of a d x d block, reciprocals of the pivots included.
constexpr std::int64_t lu_operations(std::int64_t d) {
  return d + d * (d - 1) / 2 + (d - 1) * d * (2 * d - 1) / 6;
}

/// LDL^T of a d x d block: reciprocals, multipliers, and one triangle of every update.
constexpr std::int64_t ldlt_operations(std::int64_t d) { return d + d * (d - 1) / 2 + (d - 1) * d * (d + 1) / 6; }

/// LDL^T of such a block, half a solve for each of the m rows coupled to it, and one triangle of what is between these.
constexpr std::int64_t ldlt_pivot_operations(std::int64_t d, std::int64_t m) {
  return ldlt_operations(d) + m * d * (d + 1) / 2 + d * m * (m + 1) / 2;
}

}  // namespace graphsolve
