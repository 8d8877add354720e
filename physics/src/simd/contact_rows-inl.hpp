// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(PHYSICS_SIMD_CONTACT_ROWS_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef PHYSICS_SIMD_CONTACT_ROWS_INL_HPP_
#undef PHYSICS_SIMD_CONTACT_ROWS_INL_HPP_
#else
#define PHYSICS_SIMD_CONTACT_ROWS_INL_HPP_
#endif

#include <limits>

#include "simd/algebra-inl.hpp"
#include "simd/contact_kernels.hpp"

/// What eight contacts see of their bodies along their normals and tangents, and what they do to them.
HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {

constexpr int pairs = ContactOctet::pairs, facets = 4, bound = pairs - 1;

/// Local rows: along the normal and the two tangents.
struct Rows {
  Pack n, t1, t2;
};

/// Along facet i: t1, t2, -t1, -t2.
HWY_INLINE Pack along(const Rows& u, int facet) {
  const Pack& a = facet % 2 == 0 ? u.t1 : u.t2;
  return facet < 2 ? a : -a;
}

/// A task whose contacts are on one body reads it once.
HWY_INLINE unsigned read(const ContactTask& task) { return task.one_body ? 1u : task.used; }

HWY_INLINE Rows along_tangents(const ContactOctet& o, const Vector3& v, const Vector3& w) {
  return {Pack(0.0), dot(load3(o.tangent[0]), v) + dot(load3(o.rate_tangent[0]), w),
          dot(load3(o.tangent[1]), v) + dot(load3(o.rate_tangent[1]), w)};
}

/// f(number) with number(k) of the poses.
template <class F>
HWY_INLINE void read_pose(const ContactTask& task, const ContactTask::Poses& poses, F&& f) {
  if (poses.all) f([&](int k) HWY_ATTR { return load(poses.all[k]); });
  else if (task.one_body) f([&](int k) HWY_ATTR { return Pack(poses.lane[0][8 * k]); });
  else f([&](int k) HWY_ATTR { return gs::each_lane<8>([&](int l) HWY_ATTR { return poses.lane[l][8 * k]; }); });
}

/// Numbers first ... of the pose.
template <class Number>
HWY_INLINE Vector3 three(Number&& number, int first) {
  return {number(first), number(first + 1), number(first + 2)};
}
template <class Number>
HWY_INLINE Matrix3 nine(Number&& number, int first) {
  return {three(number, first), three(number, first + 3), three(number, first + 6)};
}

/// What the tangents see of the turn of a body; keeps the derivatives. As ContactPort<3>::evaluate.
HWY_INLINE void measure_turn(const ContactTask& task, const Vector3& w, const Matrix3& next, const Matrix3& turn,
                             Pack* along_tangent) {
  ContactOctet& o = *task.octet;
  Vector3 rate[2] = {load3(o.lever[1]), load3(o.lever[2])};
  for (int t = 0; t < 2; ++t) along_tangent[t] = dot(rate[t], w);
  if (task.displaced != 0) {
    const Mask displaced = lanes_of(task.displaced);
    const Vector3 point = load3(o.point), tangent[2] = {load3(o.tangent[0]), load3(o.tangent[1])};
    const Pack radius = load(o.radius);
    Matrix3 now;
    read_pose(task, task.now, [&](auto&& number) HWY_ATTR { now = nine(number, 7); });
    const Matrix3 change = {next.c0 - now.c0, next.c1 - now.c1, next.c2 - now.c2};
    const Vector3 turned = Pack(1 / task.dt) * (change * point);
    const Vector3 rolled[2] = {-radius * transposed_times(now, tangent[1]), radius * transposed_times(now, tangent[0])};
    for (int t = 0; t < 2; ++t) {
      const Vector3 moved = transposed_times(turn, cross(point, transposed_times(next, tangent[t]))) + rolled[t];
      rate[t] = select(displaced, moved, rate[t]);
      along_tangent[t] = gs::select(displaced, dot(tangent[t], turned) + dot(rolled[t], w), along_tangent[t]);
    }
  }
  for (int t = 0; t < 2; ++t) store3(rate[t], o.rate_tangent[t]);
}

/// u at the next pose; keeps its derivative.
HWY_INLINE Rows measure(const ContactTask& task) {
  ContactOctet& o = *task.octet;
  Pack x[6];
  if (task.velocities)
    for (int i = 0; i < 6; ++i) x[i] = load(task.velocities[i]);
  else gs::load_transposed(task.x, 6, x, read(task));
  const Vector3 normal = load3(o.normal), point = load3(o.point), v = vector(x);
  Rows u;
  Pack by_turn[2];
  read_pose(task, task.next, [&](auto&& number) HWY_ATTR {
    const Matrix3 rotation = nine(number, 7), turn = nine(number, 16);
    const Vector3 local = transposed_times(rotation, normal);
    store3(transposed_times(turn, cross(point, local)), o.rate_normal);
    u.n = (dot(normal, three(number, 0)) + dot(local, point) - load(o.offset) - load(o.radius)) * Pack(1 / task.dt);
    measure_turn(task, vector(x + 3), rotation, turn, by_turn);
  });
  u.t1 = dot(load3(o.tangent[0]), v) + by_turn[0];
  u.t2 = dot(load3(o.tangent[1]), v) + by_turn[1];
  return u;
}

/// rows += sign J1^T f
HWY_INLINE void add_force(const ContactTask& task, const Rows& f, double sign) {
  const ContactOctet& o = *task.octet;
  Pack wrench[6];
  put(f.n * load3(o.normal) + f.t1 * load3(o.tangent[0]) + f.t2 * load3(o.tangent[1]), wrench);
  put(f.n * load3(o.lever[0]) + f.t1 * load3(o.lever[1]) + f.t2 * load3(o.lever[2]), wrench + 3);
  gs::add_transposed(wrench, 6, task.rows, task.used, sign);
}

/// cf, or nothing where the bound is frozen.
HWY_INLINE Pack friction(const ContactOctet& o) { return load(o.friction) * (Pack(1.0) - load(o.frozen)); }

/// Largest of many numbers and 0; a NaN stays. Two chains of maxima, so that few wait for the one before.
class Largest {
 public:
  HWY_INLINE Largest() : most_{Pack(0.0), Pack(0.0)}, missing_(Pack(0.0) < Pack(0.0)) {}
  HWY_INLINE void take(const Pack& e, int chain) {
    most_[chain] = gs::max(e, most_[chain]);
    missing_ = missing_ | !(e >= e);
  }
  HWY_INLINE Pack value() const {
    return gs::select(missing_, Pack(std::numeric_limits<double>::quiet_NaN()), gs::max(most_[0], most_[1]));
  }

 private:
  Pack most_[2];
  Mask missing_;
};

}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
