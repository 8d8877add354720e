#include "simd/gradient_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/gradient_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "graphsolve/simd/pack-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {
namespace {

namespace simd = graphsolve::simd::HWY_NAMESPACE;
using simd::Pack;
constexpr int lanes = graphsolve::simd::lanes, packs = pass_columns / lanes;
static_assert(pass_columns % lanes == 0);

/// Three columns of C at a time, in registers meanwhile.
void Subtract(double* c, const double* a, const double* b, std::ptrdiff_t ldb, int k) {
  constexpr int some = 3;
  for (int j = 0; j < 6; j += some, c += some * pass_columns, b += some * ldb) {
    Pack sum[some][packs];
#pragma GCC unroll 3
    for (int i = 0; i < some; ++i)
#pragma GCC unroll 3
      for (int r = 0; r < packs; ++r) sum[i][r] = simd::load<lanes>(c + i * pass_columns + r * lanes);
    for (int p = 0; p < k; ++p) {
      Pack column[packs];
#pragma GCC unroll 3
      for (int r = 0; r < packs; ++r) column[r] = simd::load<lanes>(a + p * pass_columns + r * lanes);
#pragma GCC unroll 3
      for (int i = 0; i < some; ++i) {
        const Pack factor(b[i * ldb + p]);
#pragma GCC unroll 3
        for (int r = 0; r < packs; ++r) sum[i][r] = simd::negative_multiply_add(column[r], factor, sum[i][r]);
      }
    }
#pragma GCC unroll 3
    for (int i = 0; i < some; ++i)
#pragma GCC unroll 3
      for (int r = 0; r < packs; ++r) simd::store(sum[i][r], c + i * pass_columns + r * lanes);
  }
}

SubtractProduct Kernel() { return Subtract; }

}  // namespace
}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "graphsolve/simd/lanes.hpp"

namespace physics {

HWY_EXPORT(Kernel);

SubtractProduct subtract_product() {
  (void)graphsolve::simd::instruction_set();  // chosen now, if it was not yet
  return HWY_DYNAMIC_DISPATCH(Kernel)();
}

}  // namespace physics
#endif
