#pragma once

#include <array>
#include <vector>

#include "mechanism/assembly.hpp"
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
/// The one owner of their state. The pose between steps is z_{k+1}, known during a step; z_{k+2} is that at the present
/// iterate. Both lie in octets, where joints and contacts read them.
class Bodies final : public graphsolve::Term {
 public:
  static constexpr double largest_turn = 1.98;  ///< bound on |w| dt
  static constexpr int nothing = -2;  ///< instead of a body, where there is none; -1 is the world

  /// copies: of the scene, side by side.
  explicit Bodies(int copies = 1) : of_copies_(copies) {}
  void reserve(int bodies);
  void add(const RigidBody& body, graphsolve::NodeId node);
  /// Other numbers for body i.
  void set(int i, const RigidBody& body, const Vec3& gravity);

  std::vector<int> row;  ///< by body: of the velocity (v', w') among the unknowns
  double dt = 0;
  bool force_at_next = false;  ///< directions of constraint forces are taken at z_{k+2} instead of z_{k+1}
  bool turn_always = true;     ///< turns are made at every iterate, for contacts; else where the matrix is

  // One body: what it is, and its state.
  [[nodiscard]] double mass(int i) const { return octet_with(i).mass[lane_with(i)]; }
  [[nodiscard]] Mat3 inertia(int i) const;
  [[nodiscard]] Vec3 velocity(int i) const { return numbers<Vec3>(octet_with(i).state.velocity, i); }
  [[nodiscard]] Vec3 spin(int i) const { return numbers<Vec3>(octet_with(i).state.velocity + 3, i); }
  [[nodiscard]] Vec3 position(int i) const { return numbers<Vec3>(octet_with(i).state.x, i); }
  [[nodiscard]] Quat orientation(int i) const { return Quat(numbers<Eigen::Vector4d>(octet_with(i).state.q, i)); }
  [[nodiscard]] double kinetic_energy(int i) const;
  /// Are its energy and its momenta numbers, as `commit` asks of all?
  [[nodiscard]] bool has_energy(int i, const Vec3& gravity) const;
  void place(int i, const Vec3& x, const Quat& q);
  void set_velocity(int i, const Vec3& v, const Vec3& w);
  /// Momentum that the step before missed and the next one makes good: linear, angular.
  [[nodiscard]] Vec3 missed(int i) const { return numbers<Vec3>(octet_with(i).missed, i); }
  [[nodiscard]] Vec3 missed_angular(int i) const { return numbers<Vec3>(octet_with(i).missed + 3, i); }
  void set_missed(int i, const Vec3& linear, const Vec3& angular);
  void add_known(int i, const Vec3& linear, const Vec3& angular);

  // All bodies of some copies, once they are wired.
  /// Momenta where a step begins. Returns StartBeyond.
  unsigned begin(std::span<const int> copies, const BodyStart& start);
  /// The state becomes that at the present iterate. The next step makes good the residual that was left, by row. False
  /// where a body then has no energy or momentum.
  bool commit(std::span<const int> copies, std::span<const double> residual);
  void save();  ///< of all copies
  void restore(int copy);
  void forget_missed(int copy);
  void exchange_with_saved();

  /// The world's pose, for joints; never changes.
  NextPose world_pose;
  [[nodiscard]] Pose pose_now(int body) const;
  /// At the present iterate, once it was evaluated.
  [[nodiscard]] NextPose pose_next(int body) const {
    if (body < 0) return world_pose;
    NextPose pose;
    copy_next(body, pose.x.data());
    return pose;
  }
  enum class When { now, next };  ///< between two steps, or at the present iterate

  /// The octet whose lanes hold just these bodies, lane by lane (or `nothing`); the last one is the world's. -1 if
  /// there is none. Once they are wired.
  [[nodiscard]] int octet_of_all(std::span<const int, graphsolve::simd::lanes> body) const;
  [[nodiscard]] const Octet* poses_now(int octet) const { return octets_[octet].state.x; }  ///< 16 numbers, as in Pose
  [[nodiscard]] const Octet* poses_next(int octet) const { return at_[octet].pose; }        ///< 25, as in NextPose
  [[nodiscard]] const Octet* velocities_next(int octet) const { return at_[octet].velocity; }  ///< 6
  /// That of the world is any in the last octet.
  [[nodiscard]] int place_of(int body) const {
    return body < 0 ? (static_cast<int>(octets_.size()) - 1) * graphsolve::simd::lanes : place_[body];
  }
  [[nodiscard]] graphsolve::NodeId node(int body) const { return node_[body]; }
  [[nodiscard]] graphsolve::BlockHandle block(int body) const {  ///< its own; once they are wired
    const auto& blocks = blocks_[octet_of(place_[body])];
    const int lane = lane_with(body);
    return {.offset = blocks.place(lane), .rows = 6, .columns = 6, .stride = blocks.stride(lane)};
  }

  [[nodiscard]] int size() const override { return static_cast<int>(node_.size()); }
  [[nodiscard]] std::span<const graphsolve::NodeId> nodes(int i) const override { return {&node_[i], 1}; }
  void wire(const graphsolve::Wiring& wiring) override;
  void evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                double* values) override;
  void bound_step(graphsolve::Instances instances, std::span<const double> x, std::span<const double> dx,
                  std::span<double> alpha) const override;
  /// Once they are wired: joints add to the residual in octets, and hand it out.
  void let_joints_push();
  /// After evaluate: residual of an octet, or of one body, loses what joints do; then it is handed out.
  void push(int octet, unsigned used, const Octet* wrench) { kernels_.push(residual_[octet], used, wrench); }
  void push_one(int place, const Octet* wrench, int lane) {
    double* to = &residual_[octet_of(place)][0][lane_of(place)];
    const double* from = &wrench[0].lane[lane];
    for (int k = 0; k < 6; ++k) to[k * graphsolve::simd::lanes] -= from[k * graphsolve::simd::lanes];
  }
  void hand_out(std::span<double> residual);
  /// At the solution x of a step: derivatives of the residual by what the step was given.
  void differentiate(std::span<const double> x, const StepStart& start, Sensitivity& out) const;

 private:
  [[nodiscard]] int lane_with(int body) const { return lane_of(place_[body]); }
  [[nodiscard]] const BodyOctet& octet_with(int body) const { return octets_[octet_of(place_[body])]; }
  [[nodiscard]] BodyOctet& octet_with(int body) { return octets_[octet_of(place_[body])]; }
  template <class T>
  [[nodiscard]] T numbers(const Octet* from, int body) const {
    T t;
    for (Eigen::Index k = 0; k < t.size(); ++k) t.data()[k] = from[k][lane_with(body)];
    return t;
  }
  void copy_now(int body, double* to) const;
  void copy_next(int body, double* to) const {
    const Octet* pose = at_[octet_of(place_[body])].pose;
    for (int k = 0, lane = lane_with(body); k < BodyAtOctet::numbers; ++k) to[k] = pose[k][lane];
  }
  void move_to(std::vector<int> places);

  std::vector<graphsolve::NodeId> node_;
  BodyKernels kernels_{};
  // Bodies in octets, and the world in the last one. Once they are wired, places are those of their blocks.
  std::vector<int> place_;
  std::vector<BodyOctet> octets_;
  std::vector<BodyOctet::State> saved_;
  std::vector<BodyAtOctet> at_;
  std::vector<ResidualOctet> residual_;  ///< where joints push; else one for all, handed out at once
  std::vector<graphsolve::simd::LaneBlocks> blocks_;  ///< by octet
  /// By octet; of lanes without a body those of one that is there.
  std::vector<std::array<int, graphsolve::simd::lanes>> rows_;
  bool joints_push_ = false;
  OctetGroups groups_;
  OctetsOfCopies of_copies_;
};

}  // namespace physics
