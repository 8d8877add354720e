#include "terms/bodies.hpp"
#include "terms/rotation.hpp"
#include "terms/sensitivity.hpp"

namespace physics {

namespace {

/// map J w, by Jxx, Jyy, Jzz, Jxy, Jxz, Jyz
Eigen::Matrix<double, 3, 6> by_inertia(const Mat3& map, const Vec3& w) {
  Eigen::Matrix<double, 3, 6> m;
  for (int i = 0; i < 3; ++i) m.col(i) = map.col(i) * w[i];
  m.col(3) = map.col(0) * w[1] + map.col(1) * w[0];
  m.col(4) = map.col(0) * w[2] + map.col(2) * w[0];
  m.col(5) = map.col(1) * w[2] + map.col(2) * w[1];
  return m;
}

}  // namespace

/// Of  m v' - m v - h (m g + F)  and  p+(w') - p-(w) - h tau;  after a half kick p- is J w. h: impulse over force.
void Bodies::differentiate(std::span<const double> x, const StepStart& start, Sensitivity& out) const {
  for (int i = 0; i < size(); ++i) {
    const Vec3 v2 = Eigen::Map<const Vec3>(x.data() + row[i]), w2 = Eigen::Map<const Vec3>(x.data() + row[i] + 3);
    const Vec3 v = velocity(i), w = spin(i);
    const double m = mass(i);
    const Mat3 j = inertia(i);
    const NextPose next = pose_next(i);
    out.carry[i].noalias() = next.rotation.transpose() * pose_now(i).rotation;
    out.turn[i] = next.turn;
    out.pose[i].setZero();
    out.velocity[i].setZero();
    out.velocity[i].diagonal().head<3>().setConstant(-m);
    out.mass[i] << v2 - v - start.impulse_time * start.gravity, Vec3::Zero();
    // p+ = (dt/2) (s I + [w]x) J w
    out.inertia[i] = by_inertia(0.5 * dt * (rotation_scalar(w2, dt) * Mat3::Identity() + skew(w2)), w2);
    if (start.half_kick) {
      out.velocity[i].bottomRightCorner<3, 3>() = -j;
      out.inertia[i] -= by_inertia(Mat3::Identity(), w);
    } else {
      const double s = rotation_scalar(w, start.time_step);
      out.velocity[i].bottomRightCorner<3, 3>() = -momentum_minus_derivative(j, w, s, start.time_step);
      out.inertia[i] -= by_inertia(0.5 * start.time_step * (s * Mat3::Identity() - skew(w)), w);
    }
  }
}

}  // namespace physics
