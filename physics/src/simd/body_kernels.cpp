#include "simd/body_kernels.hpp"

#include "mechanism/limits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/body_kernels.cpp"
#include "graphsolve/simd/targets.hpp"
// Compiles the rest of this file once per instruction set.
#include <hwy/foreach_target.h>

#include "simd/algebra-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {
namespace {

HWY_INLINE Matrix3 load_symmetric(const Octet* m) {
  const Vector3 c0 = load3(m);
  const Pack yy = load(m[3]), yz = load(m[4]), zz = load(m[5]);
  return {c0, {c0.y, yy, yz}, {c0.z, yz, zz}};
}
HWY_INLINE Quaternion load_quaternion(const Octet* q) { return {load3(q), load(q[3])}; }

/// One function for all who need it: the same bits for a state that was set and one that a step led to.
HWY_NOINLINE void Place(BodyOctet& body, unsigned used) {
  const Keeper keep(used);
  const Matrix3 rotation = rotation_matrix(load_quaternion(body.state.q));
  keep(rotation.c0, body.rotation), keep(rotation.c1, body.rotation + 3), keep(rotation.c2, body.rotation + 6);
}

HWY_INLINE Pack largest(const Vector3& v) { return gs::max(gs::abs(v.x), gs::max(gs::abs(v.y), gs::abs(v.z))); }

/// Written so that a NaN has none.
HWY_INLINE bool has_no_energy(const BodyOctet& body, unsigned used) {
  const Vector3 v = load3(body.state.velocity), w = load3(body.state.velocity + 3), x = load3(body.state.x);
  const Pack mass = load(body.mass), momentum = mass * largest(v);
  const Pack turning = dot(w, load_symmetric(body.inertia) * w), height = gs::abs(mass * dot(load3(body.gravity), x));
  const Pack told = momentum * (largest(v) + largest(x)) + turning + height;
  return (gs::bits(!(told <= Pack(largest_energy))) & used) != 0;
}

// The formulas are those of rotation.hpp.
unsigned Begin(BodyOctet& body, unsigned used, const BodyStart& start) {
  const Keeper keep(used);
  const Vector3 v = load3(body.state.velocity), w = load3(body.state.velocity + 3), g = load3(body.gravity),
                x = load3(body.state.x);
  const Pack mass = load(body.mass), ww = dot(w, w);
  const Vector3 jw = load_symmetric(body.inertia) * w;
  const Vector3 missed = load3(body.missed + 3);
  keep(mass * v + Pack(start.impulse_time) * (mass * g) + load3(body.missed), body.known);
  if (start.half_kick) {
    keep(jw + missed, body.known + 3);
  } else {
    const Pack s = gs::sqrt(Pack(4 / (start.time_step * start.time_step)) - ww);
    keep(Pack(0.5 * start.time_step) * (s * jw - cross(w, jw)) + missed, body.known + 3);
  }
  const Mask fast = !(ww <= Pack(start.most_spin * start.most_spin)), far = !(largest(x) <= Pack(start.most_distance));
  return ((gs::bits(fast) & used) != 0 ? spins_faster : 0u) | ((gs::bits(far) & used) != 0 ? lies_further : 0u);
}

void EvaluateBodies(const BodyTask& task) {
  const unsigned used = task.used;
  const BodyOctet& body = *task.body;
  const Keeper keep(used);
  const Pack dt(task.dt), half(0.5 * task.dt), half_of_one(0.5);
  Pack velocity[6];
  const double* from[8];
  for (int l = 0; l < 8; ++l) from[l] = task.x + task.rows[l];
  gs::load_transposed(from, 6, velocity, used);
  const Vector3 v = vector(velocity), w = vector(velocity + 3);
  const Pack s = gs::sqrt(Pack(4 / (task.dt * task.dt)) - dot(w, w));

  Quaternion q = load_quaternion(body.state.q) * Quaternion{half * w, half * s};
  const Pack shrink = Pack(1.5) - half_of_one * (dot(q.v, q.v) + q.w * q.w);  // of 1 + rounding: 1 / sqrt
  q = {shrink * q.v, shrink * q.w};
  Octet* pose = task.at->pose;
  keep(load3(body.state.x) + dt * v, pose);
  keep(q.v, pose + 3);
  keep(q.w, pose[6]);
  const auto keep_matrix = [&](const Matrix3& m, Octet* to) HWY_ATTR {
    keep(m.c0, to), keep(m.c1, to + 3), keep(m.c2, to + 6);
  };
  keep_matrix(rotation_matrix(q), pose + 7);
  keep(v, task.at->velocity);
  keep(w, task.at->velocity + 3);

  const Pack mass = load(body.mass);
  const Matrix3 inertia = load_symmetric(body.inertia);
  const Vector3 jw = inertia * w;
  Octet* residual = task.residual->data();
  keep(mass * v - load3(body.known), residual);
  keep(half * (s * jw + cross(w, jw)) - load3(body.known + 3), residual + 3);

  if (!task.values && !task.turn_always) return;
  const Vector3 w_over_s = (Pack(1.0) / s) * w;
  keep_matrix(half * (diagonal(s) + outer(w, w_over_s) - skew(w)), pose + 16);
  if (!task.values) return;
  gs::BlockAssignment<36> block(task.values, *task.blocks, used);
  const Pack zero(0.0);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 6; ++r) block(6 * c + r, r == c ? mass : zero);
  const auto angular = [&](int c, const Vector3& column) HWY_ATTR {
    for (int r = 0; r < 3; ++r) block(6 * c + r, zero);
    block(6 * c + 3, column.x), block(6 * c + 4, column.y), block(6 * c + 5, column.z);
  };
  const Matrix3 turned{cross(w, inertia.c0), cross(w, inertia.c1), cross(w, inertia.c2)};
  const Matrix3 rate = half * (s * inertia - outer(jw, w_over_s) + turned - skew(jw));
  angular(3, rate.c0), angular(4, rate.c1), angular(5, rate.c2);
  block.finish();
}

void Push(ResidualOctet& residual, unsigned used, const Octet* wrench) {
  const Keeper keep(used);
  for (int k = 0; k < 6; ++k) keep(load(residual[k]) - load(wrench[k]), residual[k]);
}

void HandOut(const ResidualOctet& residual, unsigned used, const int* rows, double* all) {
  Pack numbers[6];
  for (int k = 0; k < 6; ++k) numbers[k] = load(residual[k]);
  double* to[8];
  for (int l = 0; l < 8; ++l) to[l] = all + rows[l];
  gs::add_transposed(numbers, 6, to, used, 1.0);
}

bool Commit(BodyOctet& body, unsigned used, const BodyAtOctet& at, const int* rows, const double* residual) {
  const Keeper keep(used);
  Pack missed[6];
  const double* from[8];
  for (int l = 0; l < 8; ++l) from[l] = residual + rows[l];
  gs::load_transposed(from, 6, missed, used);
  keep(-vector(missed), body.missed);
  // In the frame of the body, which has turned.
  keep(-transposed_times(load33(at.pose + 7), load33(body.rotation) * vector(missed + 3)), body.missed + 3);
  for (int k = 0; k < 3; ++k) keep(load(at.pose[k]), body.state.x[k]);
  for (int k = 0; k < 4; ++k) keep(load(at.pose[3 + k]), body.state.q[k]);
  for (int k = 0; k < 6; ++k) keep(load(at.velocity[k]), body.state.velocity[k]);
  Place(body, used);
  return has_no_energy(body, used);
}

BodyKernels Kernels() {
  return {.place = Place,
          .begin = Begin,
          .evaluate = EvaluateBodies,
          .push = Push,
          .hand_out = HandOut,
          .commit = Commit};
}

}  // namespace
}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(Kernels);

BodyKernels body_kernels() {
  (void)graphsolve::simd::instruction_set();  // chosen now, if it was not yet
  return HWY_DYNAMIC_DISPATCH(Kernels)();
}

}  // namespace physics
#endif
