#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace physics {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// Body-to-world rotation, scalar first in files. Unaligned, so that any container may hold it.
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Cross-product matrix: skew(a) b = a x b.
inline Mat3 skew(const Vec3& a) {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

}  // namespace physics
