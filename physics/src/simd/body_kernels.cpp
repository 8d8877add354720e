#include "simd/body_kernels.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/body_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/algebra-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {
namespace {

/// The formulas are those of rotation.hpp.
void EvaluateBodies(const BodyTask& task) {
  const unsigned used = task.used;
  const Pack dt(task.dt), half(0.5 * task.dt);
  Pack x[6], from[7];
  gs::load_transposed(task.velocity, 6, x, used);
  gs::load_transposed(task.now, 7, from, used);
  const Vector3 v = vector(x), w = vector(x + 3);
  const Pack s = gs::sqrt(Pack(4 / (task.dt * task.dt)) - dot(w, w));

  Quaternion q = Quaternion{vector(from + 3), from[6]} * Quaternion{half * w, half * s};
  const Pack shrink = Pack(1.0) / gs::sqrt(dot(q.v, q.v) + q.w * q.w);  // one already, but for rounding
  q = {shrink * q.v, shrink * q.w};
  const Vector3 w_over_s = (Pack(1.0) / s) * w;
  Pack to[25];
  put(vector(from) + dt * v, to);
  put(q.v, to + 3);
  to[6] = q.w;
  put(rotation_matrix(q), to + 7);
  put(half * (diagonal(s) + outer(w, w_over_s) - skew(w)), to + 16);
  const Mask mask = lanes_of(used);
  const auto keep = [&](const Pack* numbers, int count, Octet* at) HWY_ATTR {
    for (int i = 0; i < count; ++i) store(used == 0xffu ? numbers[i] : gs::select(mask, numbers[i], load(at[i])), at[i]);
  };
  keep(to, 25, task.at->pose);
  keep(x, 6, task.at->velocity);

  const Pack mass = load(task.constants->mass);
  const Matrix3 inertia = load33(task.constants->inertia);
  const Vector3 jw = inertia * w;
  Pack known[6], residual[6];
  gs::load_transposed(task.known_linear, 3, known, used);
  gs::load_transposed(task.known_angular, 3, known + 3, used);
  put(mass * v - vector(known), residual);
  put(half * (s * jw + cross(w, jw)) - vector(known + 3), residual + 3);
  gs::add_transposed(residual, 6, task.residual, used, 1.0);

  if (!task.values) return;
  const Matrix3 turned{cross(w, inertia.c0), cross(w, inertia.c1), cross(w, inertia.c2)};
  Pack block[36], angular[9];
  for (Pack& entry : block) entry = Pack(0.0);
  put(half * (s * inertia - outer(jw, w_over_s) + turned - skew(jw)), angular);
  for (int k = 0; k < 3; ++k) {
    block[7 * k] = mass;
    for (int i = 0; i < 3; ++i) block[6 * (k + 3) + i + 3] = angular[3 * k + i];
  }
  gs::put_blocks<gs::Put::assign>(block, 36, task.values, *task.blocks, used, 1.0);
}

BodyKernel Kernel() { return EvaluateBodies; }

}  // namespace
}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(Kernel);

BodyKernel body_kernel() {
  (void)graphsolve::simd::instruction_set();  // chosen now, if it was not yet
  return HWY_DYNAMIC_DISPATCH(Kernel)();
}

}  // namespace physics
#endif
