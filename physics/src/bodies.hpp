#pragma once

#include <vector>

#include "assembly.hpp"
#include "graphsolve/term.hpp"
#include "physics/geometry.hpp"
#include "simd/body_kernels.hpp"

namespace physics {

struct Sensitivity;
struct StepStart;

/// A body's configuration. Kernels read it as 16 numbers in this order.
struct Pose {
  Vec3 x = Vec3::Zero();
  Quat q = Quat::Identity();
  Mat3 rotation = Mat3::Identity();
};
static_assert(sizeof(Pose) == 16 * sizeof(double));

/// That at the end of a step, and how its rotation answers to the velocity: d theta = dt turn dw. 9 numbers more.
struct NextPose : Pose {
  Mat3 turn = Mat3::Identity();
};
static_assert(sizeof(NextPose) == 25 * sizeof(double));

/// The dynamics of all bodies, 6 rows each (eq. 12a without forces):
///   m v' - (m v + dt (m g + F)),   p+(w') - (p-(w) + dt tau).
/// The one owner of the poses during a step: `now` is z_{k+1}, known; `next` is z_{k+2} at the present iterate,
/// and joints and contacts read it there.
class Bodies final : public graphsolve::Term {
 public:
  static constexpr double largest_turn = 1.98;  ///< bound on |w| dt

  void reserve(int bodies);
  void add(const RigidBody& body, graphsolve::NodeId node);
  /// Other numbers for body i, once it is wired.
  void set(int i, const RigidBody& body);

  // By body.
  std::vector<double> mass;
  std::vector<Mat3> inertia;
  std::vector<Pose> now;
  std::vector<NextPose> next;
  std::vector<Vec3> known_linear, known_angular;  ///< momentum before the step plus impulse of loads
  std::vector<int> row;                           ///< of the velocity (v', w') among the unknowns
  double dt = 0;
  bool force_at_next = false;  ///< directions of constraint forces are taken at `next` instead of `now`

  /// The world's pose, for joints; never changes.
  NextPose world_pose;
  [[nodiscard]] const Pose& pose_now(int body) const { return body < 0 ? static_cast<const Pose&>(world_pose) : now[body]; }
  [[nodiscard]] const NextPose& pose_next(int body) const { return body < 0 ? world_pose : next[body]; }
  void place(int i, const Vec3& x, const Quat& q) {  ///< sets `now`
    now[i].x = x;
    if (now[i].q.coeffs() == q.coeffs()) return;
    now[i].q = q;
    now[i].rotation = q.toRotationMatrix();
  }
  static constexpr int nothing = -2;  ///< instead of a body, where there is none; -1 is the world
  /// The octet whose lanes hold just these bodies, lane by lane (or `nothing`), at the present iterate; null if there
  /// is none. Once they are wired.
  [[nodiscard]] const BodyAtOctet* octet_of_all(std::span<const int, graphsolve::simd::lanes> body) const;
  [[nodiscard]] graphsolve::NodeId node(int body) const { return node_[body]; }
  [[nodiscard]] graphsolve::BlockHandle block(int body) const {  ///< its own; once they are wired
    const auto& blocks = blocks_[octet_of(place_[body])];
    const int lane = lane_of(place_[body]);
    return {.offset = blocks.place(lane), .rows = 6, .columns = 6, .stride = blocks.stride(lane)};
  }

  [[nodiscard]] int size() const override { return static_cast<int>(node_.size()); }
  [[nodiscard]] std::span<const graphsolve::NodeId> nodes(int i) const override { return {&node_[i], 1}; }
  void wire(const graphsolve::Wiring& wiring) override;
  void evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                double* values) override;
  void bound_step(graphsolve::Instances instances, std::span<const double> x, std::span<const double> dx,
                  std::span<double> alpha) const override;
  /// At the solution x of a step: derivatives of the residual by what the step was given.
  void differentiate(std::span<const double> x, const StepStart& start, Sensitivity& out) const;

 private:
  std::vector<graphsolve::NodeId> node_;
  void set_octet(int i);
  BodyKernel kernel_ = nullptr;
  // Bodies in octets, known once they are wired.
  std::vector<int> place_, body_at_;
  std::vector<BodyAtOctet> at_;
  std::vector<BodyOctet> constants_;  ///< mass and inertia once more
  std::vector<graphsolve::simd::LaneBlocks> blocks_;  ///< by octet
  OctetGroups groups_;
};

}  // namespace physics
