#pragma once

#include <array>

#include "terms/bodies.hpp"
#include "graphsolve/term.hpp"

namespace physics {

/// A law at the solution of a step, as its port needs it for derivatives by the state before.
template <int Rows>
struct ContactResponse {
  double rate[Rows], force[Rows];  ///< u, f
  double stiffness[Rows * Rows];   ///< K = -df/du, column-major
  double slip_speed = 0;           ///< before the step, where t1 follows the slip; 0: t1 is constant
  double turn_by_mass = 0;         ///< then; both as Contacts::Entry has them
  bool presses = false;            ///< the normal is as stiff as it may be
};

/// What the slip of a contact in a step is. A point that is held by friction stays where it is with the second only, as
/// one that is held by a joint does; with the first it moves by dt/2 w x (w x p) in every step.
enum class SlipMeasure : char {
  velocity,      ///< t . (v + R1 (w x arm)), at the pose before the step
  displacement,  ///< t . ((x2 + R2 p) - (x1 + R1 p)) / dt, and what a sphere rolls: t . R1 (w x -r R1^T n)
};

/// How a contact stands before a step: of the material point that is lowest.
struct Approach {
  double distance = 0;  ///< [m]
  double speed = 0;     ///< along the normal [m/s]
  double slip[2] = {};  ///< along the tangents [m/s]
};

/// A sphere on a body against a plane. Port supplies point() (body frame), normal(), plane_offset() = n . o, radius().
template <class Port>
class PlanePoint {
 public:
  /// Signed distance at a pose [m].
  [[nodiscard]] double distance(const Pose& pose) const {
    return port().normal().dot(pose.x + pose.rotation * port().point()) - port().plane_offset() - port().radius();
  }
  /// From the body's centre to the lowest point of the sphere, world [m].
  [[nodiscard]] Vec3 world_arm(const Pose& pose) const {
    return pose.rotation * port().point() - port().radius() * port().normal();
  }
  [[nodiscard]] Vec3 contact_point(const Pose& pose) const {  ///< body frame, lowest point of the sphere
    return port().point() - port().radius() * (pose.rotation.transpose() * port().normal());
  }

 private:
  [[nodiscard]] const Port& port() const { return static_cast<const Port&>(*this); }
};

/// A contact point of one body against a plane, `rows` = 1 (normal) or 3 (normal, t1, t2):
///   u_n = phi(z_{k+2}) / dt,  phi = n . (x + R p - o) - radius            (eq. 14, 24f)
///   u_t = t . (v' + R1 (w' x p')),  p' the contact point at z_{k+1}       (eq. 24c)
/// Forces act along n, t1, t2 at z_{k+1}: J1 = [n^T, (p' x R1^T n)^T] and so on.
template <int Rows>
class ContactPort : public PlanePoint<ContactPort<Rows>> {
 public:
  static constexpr int rows = Rows;
  static constexpr int node_count = 1;
  std::array<graphsolve::NodeId, 1> nodes;

  ContactPort(Bodies& bodies, int body, const Vec3& point, const Vec3& normal, double offset, double radius)
      : nodes{bodies.node(body)}, bodies_(&bodies), body_(body), row_(bodies.row[body]) {
    place(point, normal, offset, radius);
  }
  /// Another point of the same body, another plane.
  void place(const Vec3& point, const Vec3& normal, double offset, double radius) {
    g_.point = point;
    g_.normal = normal;
    g_.offset = offset;
    g_.radius = radius;
  }

  void wire(const graphsolve::Wiring& wiring) {
    row_ = wiring.row(nodes[0]);
    block_ = wiring.block(nodes[0], nodes[0]);
  }

  [[nodiscard]] int body() const { return body_; }
  [[nodiscard]] const Vec3& point() const { return g_.point; }
  [[nodiscard]] double radius() const { return g_.radius; }
  [[nodiscard]] const Vec3& normal() const { return g_.normal; }
  [[nodiscard]] const Vec3& tangent1() const { return g_.tangent[0]; }
  [[nodiscard]] const Vec3& tangent2() const { return g_.tangent[1]; }
  /// t1 has to be a unit vector normal to n; t2 = n x t1.
  void set_tangent(const Vec3& t1) {
    g_.tangent[0] = t1;
    g_.tangent[1] = g_.normal.cross(t1);
  }
  [[nodiscard]] double plane_offset() const { return g_.offset; }
  [[nodiscard]] const Vec3& lever(int row) const { return g_.lever[row]; }  ///< of the force along it, body frame

  void set_slip(SlipMeasure slip) { slip_ = slip; }

  /// Force directions: before a step at `now`.
  void prepare() { prepare(bodies_->pose_now(body_)); }
  /// At `now`; velocity: the unknowns of the last step.
  [[nodiscard]] Approach approach(std::span<const double> velocity) const {
    const Pose pose = bodies_->pose_now(body_);
    const Eigen::Map<const Vec3> v(velocity.data() + row_), w(velocity.data() + row_ + 3);
    const Vec3 arm = this->world_arm(pose), u = v + (pose.rotation * w).cross(arm);
    Approach a{g_.normal.dot(pose.x + arm) - g_.offset, g_.normal.dot(u), {}};
    for (int t = 0; t < rows - 1; ++t) a.slip[t] = g_.tangent[t].dot(u);
    return a;
  }
  void prepare(const Pose& pose) {
    const Vec3 p = this->contact_point(pose);
    g_.lever[0] = p.cross(pose.rotation.transpose() * g_.normal);
    for (int r = 1; r < rows; ++r) g_.lever[r] = p.cross(pose.rotation.transpose() * g_.tangent[r - 1]);
  }

  void evaluate(std::span<const double> x, double* u) {
    const NextPose next = bodies_->pose_next(body_);
    if (bodies_->force_at_next) prepare(next);
    const Vec3 local = next.rotation.transpose() * g_.normal;
    rate_normal_.noalias() = next.turn.transpose() * g_.point.cross(local);
    u[0] = (g_.normal.dot(next.x) + local.dot(g_.point) - g_.offset - g_.radius) / bodies_->dt;
    if constexpr (rows == 3) {
      const Eigen::Map<const Vec3> v(x.data() + row_), w(x.data() + row_ + 3);
      const Pose now = bodies_->pose_now(body_);
      const Vec3 turned = (next.rotation - now.rotation) * g_.point / bodies_->dt;
      for (int t = 0; t < 2; ++t) {
        rate_tangent_[t] = g_.lever[t + 1];
        double by_turn = rate_tangent_[t].dot(w);
        if (slip_ == SlipMeasure::displacement) {
          const Vec3 rolled = this->rolled(now, t);
          rate_tangent_[t] = next.turn.transpose() * g_.point.cross(next.rotation.transpose() * g_.tangent[t]) + rolled;
          by_turn = g_.tangent[t].dot(turned) + rolled.dot(w);
        }
        u[t + 1] = g_.tangent[t].dot(v) + by_turn;
      }
    }
  }
  /// Of the slip of a rolling sphere along tangent t, by w: -r R1^T n x R1^T t
  [[nodiscard]] Vec3 rolled(const Pose& now, int t) const {
    return now.rotation.transpose() * (t == 0 ? Vec3(-g_.radius * g_.tangent[1]) : Vec3(g_.radius * g_.tangent[0]));
  }
  /// At the solution x of a step: adds the derivatives of -J1^T f by what the step was given, after those of the
  /// bodies.
  void differentiate(std::span<const double> x, const ContactResponse<Rows>& response, Sensitivity& out) const;
  /// J1^T (0, f1, f2)
  [[nodiscard]] Eigen::Matrix<double, 6, 1> friction_wrench(const double* f) const {
    Eigen::Matrix<double, 6, 1> wrench;
    wrench << g_.tangent[0] * f[0] + g_.tangent[1] * f[1], g_.lever[1] * f[0] + g_.lever[2] * f[1];
    return wrench;
  }
  void add_force(const double* f, double* residual, double sign) const {
    Vec3 force = g_.normal * (sign * f[0]), torque = g_.lever[0] * (sign * f[0]);
    if constexpr (rows == 3) {
      force += g_.tangent[0] * (sign * f[1]) + g_.tangent[1] * (sign * f[2]);
      torque += g_.lever[1] * (sign * f[1]) + g_.lever[2] * (sign * f[2]);
    }
    Eigen::Map<Vec3>(residual + row_) += force;
    Eigen::Map<Vec3>(residual + row_ + 3) += torque;
  }
  void rate(const double* dx, double* du) const {
    const Eigen::Map<const Vec3> v(dx + row_), w(dx + row_ + 3);
    du[0] = g_.normal.dot(v) + rate_normal_.dot(w);
    if constexpr (rows == 3) {
      for (int t = 0; t < 2; ++t) du[t + 1] = g_.tangent[t].dot(v) + rate_tangent_[t].dot(w);
    }
  }
  void add_condensed(const double* k, double* values) const {
    double across[6][rows], force[6][rows];
    for (int c = 0; c < 3; ++c) {
      across[c][0] = force[c][0] = g_.normal[c];
      across[c + 3][0] = rate_normal_[c];
      force[c + 3][0] = g_.lever[0][c];
      for (int r = 1; r < rows; ++r) {
        across[c][r] = force[c][r] = g_.tangent[r - 1][c];
        across[c + 3][r] = rate_tangent_[r - 1][c];
        force[c + 3][r] = g_.lever[r][c];
      }
    }
    for (int c = 0; c < 6; ++c) {
      double kj[rows];
      for (int r = 0; r < rows; ++r) {
        kj[r] = 0;
        for (int s = 0; s < rows; ++s) kj[r] += k[s * rows + r] * across[c][s];
      }
      for (int i = 0; i < 6; ++i) {
        double sum = 0;
        for (int r = 0; r < rows; ++r) sum += force[i][r] * kj[r];
        values[block_.place(i, c)] += sum;
      }
    }
  }

 private:
  /// What the contact is and where its forces act.
  struct Geometry {
    Vec3 point, normal;
    double radius, offset;  ///< offset = n . o
    std::array<Vec3, 2> tangent{Vec3::Zero(), Vec3::Zero()};
    std::array<Vec3, 3> lever{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  };
  Bodies* bodies_;
  int body_;
  int row_;  ///< -1 before it is wired
  graphsolve::BlockHandle block_;
  Geometry g_;
  SlipMeasure slip_ = SlipMeasure::velocity;
  Vec3 rate_normal_ = Vec3::Zero();
  std::array<Vec3, 2> rate_tangent_{Vec3::Zero(), Vec3::Zero()};
};

}  // namespace physics
