#pragma once

#include <cstddef>

namespace physics {

/// Rows of what the derivatives of a step are worked out in: the velocities of four bodies.
inline constexpr int pass_columns = 24;

/// C (pass_columns x 6) -= A (pass_columns x k) B (k x 6). Columns of C and A lie one after the other, those of B `ldb`
/// apart.
using SubtractProduct = void (*)(double* c, const double* a, const double* b, std::ptrdiff_t ldb, int k);

/// For the instruction set in use.
SubtractProduct subtract_product();

}  // namespace physics
