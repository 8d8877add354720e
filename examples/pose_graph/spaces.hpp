#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <istream>
#include <numbers>

/// Poses in the plane and in space: composition, increments, and the error of a measured relative pose with its derivatives.
/// The error is the one of g2o (translation in the measured frame; angle, or vector part of the unit quaternion),
/// so that chi^2 can be compared with what others report for the same file.
namespace pose_graph {

/// Rotation by an angle and translation.
struct Plane {
  static constexpr int size = 3;
  static constexpr const char* name = "SE(2)";
  static constexpr const char* vertex_tag = "VERTEX_SE2";
  static constexpr const char* edge_tag = "EDGE_SE2";
  using Vector = Eigen::Matrix<double, 3, 1>;
  using Matrix = Eigen::Matrix<double, 3, 3>;

  struct Pose {
    Eigen::Vector2d t = Eigen::Vector2d::Zero();
    double angle = 0;
  };

  static Pose read(std::istream& in) {
    Pose p;
    in >> p.t.x() >> p.t.y() >> p.angle;
    return p;
  }
  static bool turns(const Pose&) { return true; }
  static void write(std::ostream& out, const Pose& p) { out << p.t.x() << ' ' << p.t.y() << ' ' << p.angle; }
  static Pose compose(const Pose& a, const Pose& b) {
    return {a.t + Eigen::Rotation2Dd(a.angle) * b.t, a.angle + b.angle};
  }
  static Pose inverse(const Pose& a) { return {Eigen::Rotation2Dd(-a.angle) * -a.t, -a.angle}; }
  /// Moves the pose by d = (translation, angle) seen from itself.
  static Pose retract(const Pose& a, const Vector& d) { return compose(a, {d.head<2>(), d[2]}); }

  /// e = measured^-1 * (a^-1 * b); with `by_a`, `by_b`: derivatives by the increments of a and b.
  static Vector error(const Pose& measured, const Pose& a, const Pose& b, Matrix* by_a, Matrix* by_b) {
    const Eigen::Rotation2Dd back(-a.angle), frame(-measured.angle);
    const Eigen::Vector2d between = back * (b.t - a.t);
    Vector e;
    e << frame * (between - measured.t),
        std::remainder(b.angle - a.angle - measured.angle, 2 * std::numbers::pi);
    if (by_a) {
      *by_a = -Matrix::Identity();
      by_a->topLeftCorner<2, 2>() = -frame.toRotationMatrix();
      by_a->topRightCorner<2, 1>() = frame * Eigen::Vector2d(between.y(), -between.x());
      *by_b = Matrix::Identity();
      by_b->topLeftCorner<2, 2>() = (frame * back * Eigen::Rotation2Dd(b.angle)).toRotationMatrix();
    }
    return e;
  }
};

/// Unit quaternion and translation.
struct Space {
  static constexpr int size = 6;
  static constexpr const char* name = "SE(3)";
  static constexpr const char* vertex_tag = "VERTEX_SE3:QUAT";
  static constexpr const char* edge_tag = "EDGE_SE3:QUAT";
  using Vector = Eigen::Matrix<double, 6, 1>;
  using Matrix = Eigen::Matrix<double, 6, 6>;

  struct Pose {
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  };

  static Pose read(std::istream& in) {
    Pose p;
    in >> p.t.x() >> p.t.y() >> p.t.z() >> p.q.x() >> p.q.y() >> p.q.z() >> p.q.w();
    p.q.normalize();
    return p;
  }
  /// Is the rotation one? A quaternion of length 0 is none.
  static bool turns(const Pose& p) { return p.q.squaredNorm() > 0.5; }
  static void write(std::ostream& out, const Pose& p) {
    out << p.t.transpose() << ' ' << p.q.x() << ' ' << p.q.y() << ' ' << p.q.z() << ' ' << p.q.w();
  }
  static Pose compose(const Pose& a, const Pose& b) { return {a.t + a.q * b.t, (a.q * b.q).normalized()}; }
  static Pose inverse(const Pose& a) { return {a.q.conjugate() * -a.t, a.q.conjugate()}; }
  /// Moves the pose by d = (translation, rotation vector) seen from itself.
  static Pose retract(const Pose& a, const Vector& d) {
    const Eigen::Vector3d r = d.tail<3>();
    const double angle = r.norm(), s = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5;
    return compose(a, {d.head<3>(), Eigen::Quaterniond(std::cos(angle / 2), s * r.x(), s * r.y(), s * r.z())});
  }

  static Vector error(const Pose& measured, const Pose& a, const Pose& b, Matrix* by_a, Matrix* by_b) {
    const Eigen::Quaterniond frame = measured.q.conjugate(), turned = a.q.conjugate() * b.q;
    const Eigen::Vector3d between = a.q.conjugate() * (b.t - a.t);
    Eigen::Quaterniond q = frame * turned;
    if (q.w() < 0) q.coeffs() *= -1;  // the shorter way round
    Vector e;
    e << frame * (between - measured.t), q.vec();
    if (by_a) {
      const Eigen::Matrix3d to_frame = frame.toRotationMatrix();
      // q * (1, d/2) moves the vector part by 1/2 (w I + [v]x) d.
      const Eigen::Matrix3d half = 0.5 * (q.w() * Eigen::Matrix3d::Identity() + cross(q.vec()));
      by_a->setZero();
      by_b->setZero();
      by_a->topLeftCorner<3, 3>() = -to_frame;
      by_a->topRightCorner<3, 3>() = to_frame * cross(between);
      by_a->bottomRightCorner<3, 3>() = -half * turned.toRotationMatrix().transpose();
      by_b->topLeftCorner<3, 3>() = (frame * turned).toRotationMatrix();
      by_b->bottomRightCorner<3, 3>() = half;
    }
    return e;
  }

 private:
  static Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
    Eigen::Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
  }
};

}  // namespace pose_graph
