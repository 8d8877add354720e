#include "simd/vector_kernels.hpp"

#include "graphsolve/largest.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/vector_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "graphsolve/simd/pack-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace graphsolve::simd::HWY_NAMESPACE {
namespace {

/// f(i) for packs that begin at i: one after the other, the last as far back as it has to be.
template <class F>
HWY_INLINE void each_pack(int n, F&& f) {
  for (int i = 0; i + lanes < n; i += lanes) f(i);
  f(n - lanes);
}

double LargestScaled(const double* a, const double* scale, int n, double first) {
  LargestMagnitude largest(first);
  if (n < lanes) {
    for (int i = 0; i < n; ++i) largest.take(a[i] * scale[i]);
    return largest.value();
  }
  // Several maxima, so that none waits for the one before.
  constexpr int chains = 4;
  Pack most[chains];
  for (Pack& m : most) m = Pack(0.0);
  const auto take = [&](const Pack& e, Pack& m) HWY_ATTR { m = select((e > m) | !(e >= e), e, m); };
  const auto at = [&](int i) HWY_ATTR { return abs(load<lanes>(a + i) * load<lanes>(scale + i)); };
  int i = 0;
  for (; i + chains * lanes <= n; i += chains * lanes)
    for (int k = 0; k < chains; ++k) take(at(i + k * lanes), most[k]);
  for (; i + lanes < n; i += lanes) take(at(i), most[0]);
  take(at(n - lanes), most[0]);
  for (int k = 1; k < chains; ++k) take(most[k], most[0]);
  double found[lanes];
  store(most[0], found);
  for (const double e : found) largest.take(e);
  return largest.value();
}

void Negate(const double* a, double* to, int n) {
  if (n >= lanes) return each_pack(n, [&](int i) HWY_ATTR { store(-load<lanes>(a + i), to + i); });
  for (int i = 0; i < n; ++i) to[i] = -a[i];
}

void AddScaled(double factor, const double* a, double* to, int n) {
  if (n < lanes) {
    for (int i = 0; i < n; ++i) to[i] += factor * a[i];
    return;
  }
  const Pack f(factor), last = load<lanes>(to + n - lanes);  // taken up before the pack in front of it changes some of it
  for (int i = 0; i + lanes < n; i += lanes) store(load<lanes>(to + i) + f * load<lanes>(a + i), to + i);
  store(last + f * load<lanes>(a + n - lanes), to + n - lanes);
}

constexpr VectorKernels here{.largest_scaled = LargestScaled, .negate = Negate, .add_scaled = AddScaled};

}  // namespace

const VectorKernels* Vectors() { return &here; }

}  // namespace graphsolve::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace graphsolve::simd {

HWY_EXPORT(Vectors);

const VectorKernels& vector_kernels() {
  (void)instruction_set();  // chosen now, if it was not yet
  return *HWY_DYNAMIC_DISPATCH(Vectors)();
}

}  // namespace graphsolve::simd
#endif
