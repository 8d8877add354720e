#include <algorithm>
#include <cmath>

#include "terms/contacts.hpp"
#include "terms/sensitivity.hpp"

namespace physics {

/// With f(u, cf) the law's force, df = -K du:  d(-J1^T f) = J1^T K du - dJ1^T f - J1^T df/dcf dcf.
template <int Rows>
void ContactPort<Rows>::differentiate(std::span<const double> x, const ContactResponse<Rows>& response,
                                      Sensitivity& out) const {
  using Columns = Eigen::Matrix<double, 6, Rows>;
  const Pose now = bodies_->pose_now(body_);
  const NextPose next = bodies_->pose_next(body_);
  const Eigen::Map<const Vec3> w2(x.data() + row_ + 3);
  const Mat3 to_body = now.rotation.transpose();
  const Vec3 p = this->contact_point(now), n = to_body * g_.normal, n2 = next.rotation.transpose() * g_.normal;
  Vec3 axis[3] = {g_.normal, g_.tangent[0], g_.tangent[1]};
  Columns force;  // J1^T
  Vec3 pushed = Vec3::Zero();
  for (int r = 0; r < Rows; ++r) {
    force.col(r) << axis[r], g_.lever[r];
    pushed += axis[r] * response.force[r];
  }
  // Arm p x g, g = R^T a: the body turns under g, and a sphere's lowest point wanders (p = point - radius n).
  const auto turned_arm = [&](const Vec3& a) -> Mat3 {
    const Mat3 g = skew(to_body * a);
    return skew(p) * g + g_.radius * g * skew(n);
  };
  Eigen::Matrix<double, Rows, 6> rate = Eigen::Matrix<double, Rows, 6>::Zero();  // du by the pose
  rate.row(0).template head<3>() = g_.normal.transpose() / bodies_->dt;
  rate.row(0).template tail<3>() = g_.point.cross(n2).transpose() * out.carry[body_] / bodies_->dt;
  for (int r = 1; r < Rows; ++r) {
    if (slip_ == SlipMeasure::velocity) {
      rate.row(r).template tail<3>() = w2.transpose() * turned_arm(axis[r]);
      continue;
    }
    const Vec3 moved = out.carry[body_].transpose() * g_.point.cross(next.rotation.transpose() * axis[r]);
    rate.row(r).template tail<3>() =
        ((moved - g_.point.cross(to_body * axis[r])) / bodies_->dt + w2.cross(rolled(now, r - 1))).transpose();
  }
  const Columns stiff = force * Eigen::Map<const Eigen::Matrix<double, Rows, Rows>>(response.stiffness);
  Matrix6& pose = out.pose[body_];
  pose.noalias() += stiff * rate;
  pose.template bottomRightCorner<3, 3>() -= turned_arm(pushed);
  if (response.presses) {
    Vector6 by_velocity;
    by_velocity << g_.normal, rate_normal_;
    out.pressing.push_back({row_, body_, stiff.col(0), by_velocity, rate.row(0).transpose()});
  }
  if constexpr (Rows == 3) {
    if (response.slip_speed == 0) return;
    // t1 = t/|t|, t = f/m - u0 with shares of it, turns by da = -t2 . (du0 + f dm/m^2) / |t|:  dt1 = t2 da, dt2 = -t1 da.
    const double *u = response.rate, *f = response.force;
    Vector6 by_turn = stiff.col(1) * u[2] - stiff.col(2) * u[1];
    by_turn -= force.col(2) * f[1] - force.col(1) * f[2];
    const Vec3 w = bodies_->spin(body_), t2 = to_body * axis[2];
    Vector6 slip_by_pose = Vector6::Zero(), slip_by_velocity;
    slip_by_pose.template tail<3>() = -(t2.transpose() * (skew(w.cross(p)) + g_.radius * skew(w) * skew(n)));
    slip_by_velocity << axis[2], g_.lever[2];
    pose.noalias() += by_turn * (slip_by_pose.transpose() / -response.slip_speed);
    out.velocity[body_].noalias() += by_turn * (slip_by_velocity.transpose() / -response.slip_speed);
    out.mass[body_] -= by_turn * response.turn_by_mass;
  }
}

namespace {

/// Of the bound on stiffness, from which on friction may rival what presses.
constexpr double sticks = 1e-6;

/// A law or port that can be asked on its own.
template <class T>
decltype(auto) whole(T& part) {
  if constexpr (requires { part.copy(); }) return part.copy();
  else return (part);
}

}  // namespace

void Contacts::differentiate(int lane, std::span<const double> x, bool basis_follows, double stiffness,
                             Sensitivity& out) {
  for (int i = 0; i < per_lane_; ++i) {
    const Entry& entry = contacts_[side_by_side_.index(lane, i)];
    if (!entry.active) continue;
    visit(entry, [&](auto&& kept_port, auto&& kept_law) {
      constexpr int rows = std::decay_t<decltype(kept_port)>::rows;
      ContactResponse<rows> response;
      auto&& port = whole(kept_port);
      auto&& law = whole(kept_law);
      port.prepare();
      port.evaluate(x, response.rate);
      law.residual(response.rate, response.force);
      const double stiffest = stiffness * law.scale();
      law.condense(stiffest, response.stiffness);
      response.presses = response.stiffness[0] == stiffest;
      if constexpr (rows == 3) {
        if (std::max(response.stiffness[4], response.stiffness[8]) > sticks * stiffest) out.something_sticks = true;
        if (entry.aligned && (entry.turned || basis_follows)) {
          response.slip_speed = entry.slip_speed;
          response.turn_by_mass = entry.turn_by_mass;
        }
        double by_friction[2];
        law.friction_derivative(by_friction);
        out.friction.push_back({entry.source, bodies_.row[port.body()], 6,
                                -port.friction_wrench(by_friction)});
      }
      port.differentiate(x, response, out);
    });
  }
}

template void ContactPort<1>::differentiate(std::span<const double>, const ContactResponse<1>&, Sensitivity&) const;
template void ContactPort<3>::differentiate(std::span<const double>, const ContactResponse<3>&, Sensitivity&) const;

}  // namespace physics
