#pragma once

namespace graphsolve::simd {

/// What the interior point does with runs of rows. Results are the same bits for every instruction set.
struct VectorKernels {
  double (*largest_scaled)(const double* a, const double* scale, int n, double first);  ///< max(first, |a_i scale_i|); a NaN stays
  void (*negate)(const double* a, double* to, int n);                                   ///< to = -a
  void (*add_scaled)(double factor, const double* a, double* to, int n);                ///< to += factor a
};
/// For the instruction set in use.
const VectorKernels& vector_kernels();

}  // namespace graphsolve::simd
