// Included once per instruction set by Highway's foreach_target.hpp: the guard below toggles, as Highway asks.
#if defined(PHYSICS_SIMD_ALGEBRA_INL_HPP_) == defined(HWY_TARGET_TOGGLE)
#ifdef PHYSICS_SIMD_ALGEBRA_INL_HPP_
#undef PHYSICS_SIMD_ALGEBRA_INL_HPP_
#else
#define PHYSICS_SIMD_ALGEBRA_INL_HPP_
#endif

#include "graphsolve/simd/pack_memory-inl.hpp"
#include "simd/octet.hpp"

/// Vectors, rotations and quaternions of eight problems at once: just what bodies, joints and contacts need of them.
/// (Eigen's functions are not compiled for the instruction sets that are chosen when the program runs.)
HWY_BEFORE_NAMESPACE();
namespace physics::HWY_NAMESPACE {
using graphsolve::simd::HWY_NAMESPACE::Mask;
using graphsolve::simd::HWY_NAMESPACE::Pack;
namespace gs = graphsolve::simd::HWY_NAMESPACE;

HWY_INLINE Pack load(const Octet& from) { return gs::load<graphsolve::simd::lanes>(from.lane); }
HWY_INLINE void store(const Pack& a, Octet& to) { gs::store(a, to.lane); }

HWY_INLINE Mask lanes_of(unsigned set) { return gs::lanes_of<graphsolve::simd::lanes>(set); }

struct Vector3 {
  Pack x, y, z;
};
/// Columns.
struct Matrix3 {
  Vector3 c0, c1, c2;
};
struct Quaternion {
  Vector3 v;
  Pack w;
};

HWY_INLINE Vector3 load3(const Octet* from) { return {load(from[0]), load(from[1]), load(from[2])}; }
HWY_INLINE Vector3 vector(const Pack* p) { return {p[0], p[1], p[2]}; }
HWY_INLINE Matrix3 matrix(const Pack* p) { return {vector(p), vector(p + 3), vector(p + 6)}; }  ///< column-major
HWY_INLINE Matrix3 load33(const Octet* from) { return {load3(from), load3(from + 3), load3(from + 6)}; }
HWY_INLINE void put(const Vector3& a, Pack* to) { to[0] = a.x, to[1] = a.y, to[2] = a.z; }
HWY_INLINE void put(const Matrix3& a, Pack* to) { put(a.c0, to), put(a.c1, to + 3), put(a.c2, to + 6); }
HWY_INLINE void store3(const Vector3& a, Octet* to) { store(a.x, to[0]), store(a.y, to[1]), store(a.z, to[2]); }

/// Changes the used lanes only.
class Keeper {
 public:
  explicit HWY_INLINE Keeper(unsigned used) : all_(used == 0xffu), mask_(lanes_of(used)) {}
  HWY_INLINE void operator()(const Pack& a, Octet& to) const { store(all_ ? a : gs::select(mask_, a, load(to)), to); }
  HWY_INLINE void operator()(const Vector3& a, Octet* to) const {
    (*this)(a.x, to[0]), (*this)(a.y, to[1]), (*this)(a.z, to[2]);
  }

 private:
  bool all_;
  Mask mask_;
};

HWY_INLINE Vector3 operator+(const Vector3& a, const Vector3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
HWY_INLINE Vector3 operator-(const Vector3& a, const Vector3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
HWY_INLINE Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
HWY_INLINE Vector3 operator*(const Pack& s, const Vector3& a) { return {s * a.x, s * a.y, s * a.z}; }
HWY_INLINE Vector3 select(const Mask& mask, const Vector3& yes, const Vector3& no) {
  return {gs::select(mask, yes.x, no.x), gs::select(mask, yes.y, no.y), gs::select(mask, yes.z, no.z)};
}
HWY_INLINE Pack dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

HWY_INLINE Vector3 operator*(const Matrix3& m, const Vector3& a) { return a.x * m.c0 + a.y * m.c1 + a.z * m.c2; }
/// m^T a
HWY_INLINE Vector3 transposed_times(const Matrix3& m, const Vector3& a) {
  return {dot(m.c0, a), dot(m.c1, a), dot(m.c2, a)};
}
HWY_INLINE Matrix3 operator+(const Matrix3& a, const Matrix3& b) { return {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2}; }
HWY_INLINE Matrix3 operator-(const Matrix3& a, const Matrix3& b) { return {a.c0 - b.c0, a.c1 - b.c1, a.c2 - b.c2}; }
HWY_INLINE Matrix3 operator*(const Pack& s, const Matrix3& a) { return {s * a.c0, s * a.c1, s * a.c2}; }
/// a b^T
HWY_INLINE Matrix3 outer(const Vector3& a, const Vector3& b) { return {b.x * a, b.y * a, b.z * a}; }
/// Cross-product matrix: skew(a) b = a x b.
HWY_INLINE Matrix3 skew(const Vector3& a) {
  const Pack zero(0.0);
  return {{zero, a.z, -a.y}, {-a.z, zero, a.x}, {a.y, -a.x, zero}};
}
HWY_INLINE Matrix3 diagonal(const Pack& s) {
  const Pack zero(0.0);
  return {{s, zero, zero}, {zero, s, zero}, {zero, zero, s}};
}

HWY_INLINE Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.v + b.w * a.v + cross(a.v, b.v), a.w * b.w - dot(a.v, b.v)};
}
HWY_INLINE Quaternion conjugate(const Quaternion& q) { return {-q.v, q.w}; }
HWY_INLINE Matrix3 rotation_matrix(const Quaternion& q) {
  const Pack one(1.0), two(2.0);
  const Vector3 t = two * q.v;
  const Pack xx = t.x * q.v.x, yy = t.y * q.v.y, zz = t.z * q.v.z, xy = t.x * q.v.y, xz = t.x * q.v.z, yz = t.y * q.v.z,
             wx = t.x * q.w, wy = t.y * q.w, wz = t.z * q.w;
  return {{one - yy - zz, xy + wz, xz - wy}, {xy - wz, one - xx - zz, yz + wx}, {xz + wy, yz - wx, one - xx - yy}};
}

}  // namespace physics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
