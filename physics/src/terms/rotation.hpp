#pragma once

#include <cmath>

#include "physics/geometry.hpp"

/// The discrete rotation of the variational integrator: q2 = q1 (x) (dt/2) [s(w), w] with
/// s(w) = sqrt(4/dt^2 - w.w), for body-frame w with |w| dt < 2 (paper eq. 9b, docs/algorithm.md).
namespace physics {

inline double rotation_scalar(const Vec3& w, double dt) { return std::sqrt(4 / (dt * dt) - w.squaredNorm()); }

/// s: rotation_scalar(w, dt)
inline Quat rotate(const Quat& q, const Vec3& w, double s, double dt) {
  const double h = 0.5 * dt;
  Quat step(h * s, h * w.x(), h * w.y(), h * w.z());
  Quat next = q * step;
  next.normalize();  // a unit quaternion already, but for rounding
  return next;
}

/// p+(w) = (dt/2) (s J w + w x J w): angular momentum at the start of the step that w makes, body frame there.
inline Vec3 momentum_plus(const Mat3& inertia, const Vec3& w, double s, double dt) {
  const Vec3 jw = inertia * w;
  return 0.5 * dt * (s * jw + w.cross(jw));
}

/// p-(w) = (dt/2) (s J w - w x J w): the same momentum at the end of that step, body frame there.
inline Vec3 momentum_minus(const Mat3& inertia, const Vec3& w, double dt) {
  const Vec3 jw = inertia * w;
  return 0.5 * dt * (rotation_scalar(w, dt) * jw - w.cross(jw));
}

/// dp+/dw = (dt/2) (s J - (J w) w^T / s + [w]x J - [J w]x)
inline Mat3 momentum_plus_derivative(const Mat3& inertia, const Vec3& w, double s, double dt) {
  const Vec3 jw = inertia * w;
  return 0.5 * dt * (s * inertia - jw * (w / s).transpose() + skew(w) * inertia - skew(jw));
}

/// dp-/dw = (dt/2) (s J - (J w) w^T / s - [w]x J + [J w]x)
inline Mat3 momentum_minus_derivative(const Mat3& inertia, const Vec3& w, double s, double dt) {
  const Vec3 jw = inertia * w;
  return 0.5 * dt * (s * inertia - jw * (w / s).transpose() - skew(w) * inertia + skew(jw));
}

/// D(w) = (dt/2) (s I + w w^T / s - [w]x): rotation increment at the end of the step, body frame, is dt D dw.
inline Mat3 rotation_derivative(const Vec3& w, double s, double dt) {
  return 0.5 * dt * (s * Mat3::Identity() + w * (w / s).transpose() - skew(w));
}

}  // namespace physics
