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
/// The one owner of the poses during a step: `now` is z_{k+1}, known; z_{k+2} at the present iterate lies in octets, where
/// joints and contacts read it.
class Bodies final : public graphsolve::Term {
 public:
  static constexpr double largest_turn = 1.98;  ///< bound on |w| dt
  static constexpr int nothing = -2;  ///< instead of a body, where there is none; -1 is the world

  void reserve(int bodies);
  void add(const RigidBody& body, graphsolve::NodeId node);
  /// Other numbers for body i, once it is wired.
  void set(int i, const RigidBody& body);

  // By body.
  std::vector<double> mass;
  std::vector<Mat3> inertia;
  std::vector<Pose> now;
  std::vector<Vec3> known_linear, known_angular;  ///< momentum before the step plus impulse of loads
  std::vector<int> row;                           ///< of the velocity (v', w') among the unknowns
  double dt = 0;
  bool force_at_next = false;  ///< directions of constraint forces are taken at z_{k+2} instead of `now`

  /// The world's pose, for joints; never changes.
  NextPose world_pose;
  [[nodiscard]] const Pose& pose_now(int body) const { return body < 0 ? static_cast<const Pose&>(world_pose) : now[body]; }
  /// At the present iterate, once it was evaluated.
  [[nodiscard]] NextPose pose_next(int body) const {
    if (body < 0) return world_pose;
    NextPose pose;
    copy_next(body, pose.x.data(), BodyAtOctet::numbers);
    return pose;
  }
  /// Copies of such poses, for kernels whose items do not lie in the lanes of their bodies.
  class NextRoom {
   public:
    explicit NextRoom(const Bodies& bodies) : bodies_(bodies) {}
    /// The numbers of this pose; lane by lane.
    const double* at(int lane, int body) {
      if (body == last_) return numbers_;
      last_ = body;
      if (body < 0) return numbers_ = bodies_.world_pose.x.data();
      bodies_.copy_next(body, room_[lane], BodyAtOctet::numbers);
      return numbers_ = room_[lane];
    }

   private:
    const Bodies& bodies_;
    int last_ = nothing;
    const double* numbers_ = nullptr;
    double room_[graphsolve::simd::lanes][BodyAtOctet::numbers];
  };
  /// `now` becomes that at the present iterate, with the rotation of any state that is set: the same bits again.
  void commit(int body) {
    Pose pose;
    copy_next(body, pose.x.data(), 7);
    place(body, pose.x, pose.q);
  }
  void place(int i, const Vec3& x, const Quat& q) {  ///< sets `now`
    now[i].x = x;
    if (now[i].q.coeffs() == q.coeffs()) return;
    now[i].q = q;
    now[i].rotation = q.toRotationMatrix();
  }
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
  void copy_next(int body, double* to, int count) const {
    const Octet* pose = at_[octet_of(place_[body])].pose;
    for (int k = 0, lane = lane_of(place_[body]); k < count; ++k) to[k] = pose[k][lane];
  }
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
