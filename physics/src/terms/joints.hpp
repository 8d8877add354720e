#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "terms/bodies.hpp"
#include "simd/joint_kernels.hpp"

namespace physics {

struct Sensitivity;
struct StepStart;

/// q_a^-1 q_b q_off^-1, on the half of the double cover that holds the identity.
Quat relative_rotation(const JointGeometry& g, const Pose& a, const Pose& b);

/// Largest of the rows that a joint should keep at zero.
struct JointError {
  double distance = 0, angle = 0;  ///< [m], [rad]
  [[nodiscard]] double largest() const { return std::max(distance, angle); }
};

/// Joints of all types, one saddle node each, made of parts:
///   translation rows  T R_a^T d,  d = x_b + R_b p_b - x_a - R_a p_a   (spherical, revolute: d itself)
///   rotation rows     locked components of 2 vec(q_a^-1 q_b q_off^-1)
///   motor row         lambda - dt effort(z_{k+2}), over its slope
/// Constraints hold at z_{k+2}, divided by dt; forces act along the directions at z_{k+1} (eq. 12, 24b).
/// Multipliers are impulses. A motor adds a row, not a coupling, so it makes no fill.
class Joints final : public graphsolve::Term {
 public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// copies: of the scene, side by side.
  explicit Joints(Bodies& bodies, int copies = 1) : bodies_(bodies), of_copies_(copies) {}

  /// Rows that a joint of this geometry has.
  static int rows_of(const JointGeometry& geometry, const Motor* motor);
  void reserve(int joints);
  void add(const JointGeometry& geometry, const Motor* motor, graphsolve::NodeId node);
  /// Other numbers for joint i, of the same type between the same bodies.
  void set(int i, const JointGeometry& geometry, const Motor* motor);

  /// Before a step, of a joint with a motor: its state. end_time: of the step [s]. impulse_time: what makes an impulse
  /// of a force, dt or half of it [s].
  void prepare(int i, double end_time, double impulse_time);
  /// Force directions of all joints of these copies, at the pose between steps.
  void aim(std::span<const int> copies);

  // Coordinates along free axes. Kept between steps are those of motors, and of all hinges where turns are counted.
  bool count_turns = false;
  [[nodiscard]] bool keeps_coordinates() const { return count_turns || !motors_.empty(); }
  /// After a step that is kept: remembers the coordinate.
  void commit(int i) {
    Joint& joint = joints_[i];
    if (joint.motor) joint.coordinate = motor_octet(joint).next_coordinate[lane_of(joint.place)];
    else if (counts_turns(joint)) joint.coordinate = coordinate(i);
  }
  /// Keeps the coordinate, or goes back to what was kept.
  void save(int i) { joints_[i].saved_coordinate = joints_[i].coordinate; }
  void restore(int i) { joints_[i].coordinate = joints_[i].saved_coordinate; }
  /// Exchanges the coordinate with what was kept.
  void exchange_coordinate(int i) { std::swap(joints_[i].coordinate, joints_[i].saved_coordinate); }
  /// Sets the coordinate from the poses between steps.
  void reset_coordinate(int i);
  /// After that: adds the full turns of a coordinate that was told.
  void set_turn(int i, double told);
  /// The same by the effort of the step that led to these poses and velocities at this time.
  void find_turn(int i, double effort, double time);
  [[nodiscard]] bool has_coordinate(int i) const { return has_coordinate(joints_[i]); }
  /// At the poses between steps, of joints that have one: with all turns where they are kept, else from -pi to pi.
  [[nodiscard]] double coordinate(int i) const;
  /// Its change in the step of length h that led there, over h; h = 0: by velocities that are those at these poses.
  [[nodiscard]] double rate(int i, double h) const;

  [[nodiscard]] int size() const override { return static_cast<int>(joints_.size()); }
  [[nodiscard]] std::span<const graphsolve::NodeId> nodes(int i) const override {
    return {joints_[i].nodes.data(), static_cast<std::size_t>(joints_[i].node_count)};
  }
  [[nodiscard]] graphsolve::Coupling coupling() const override { return graphsolve::Coupling::star; }
  void wire(const graphsolve::Wiring& wiring) override;
  void evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                double* values) override;

  /// At the solution x of a step: derivatives of the residual by what the step was given, after those of the bodies.
  void differentiate(std::span<const double> x, const StepStart& start, Sensitivity& out) const;

  [[nodiscard]] const JointGeometry& geometry(int i) const { return joints_[i].geometry; }
  [[nodiscard]] int row(int i) const { return joints_[i].row; }
  [[nodiscard]] int rows(int i) const { return physics::rows_of(joints_[i].kind); }
  [[nodiscard]] bool has_motor(int i) const { return joints_[i].motor != nullptr; }
  [[nodiscard]] bool any_motor() const { return !motors_.empty(); }
  [[nodiscard]] int translation_rows(int i) const { return translations(joints_[i].kind); }
  /// What the last step left: impulses of the unknowns are forces by it. Told once more for another pose, it can be put
  /// back.
  struct Aim {
    std::vector<Octet> forces;
    std::vector<MotorOctet> motors;
    std::vector<JointWrenches> wrenches;
  };
  [[nodiscard]] Aim aim() const { return {forces_, motors_, wrenches_}; }
  void put_back(const Aim& aim);
  /// Largest constraint violation between two poses [m, rad].
  [[nodiscard]] JointError error(int i, const Pose& parent, const Pose& child) const;
  /// Impulse on the child, world frame, and angular impulse about its joint point, from the multipliers.
  void impulse(int i, std::span<const double> x, Vec3& linear, Vec3& angular) const;
  [[nodiscard]] double motor_impulse(int i, std::span<const double> x) const;
  /// Largest of the joint's rows times velocities x: how fast these open the joint [m/s, rad/s].
  [[nodiscard]] double opening_rate(int i, std::span<const double> x) const;
  /// Subtracts all of them from the joint's rows of r.
  void subtract_opening(int i, std::span<const double> x, std::span<double> r) const;
  /// The motor does nothing until it is prepared again.
  void release(int i) {
    if (joints_[i].motor) motor_octet(joints_[i]).limit[lane_of(joints_[i].place)] = 0;
  }

 private:
  struct Joint {
    JointGeometry geometry;
    const Motor* motor;
    JointRows kind;
    std::array<graphsolve::NodeId, 3> nodes;  ///< own, child or parent, parent
    int node_count;
    int row = -1, parent_row = -1, child_row = -1;
    int place = -1;  ///< lane and octet that hold its numbers and force directions, once it is wired
    double coordinate = 0;              ///< between steps, where it is kept
    double saved_coordinate = 0;
  };

  using Rows = std::array<double, 6>;
  [[nodiscard]] Rows opening(const Joint& joint, std::span<const double> x) const;
  void violation(const Joint& joint, const Pose& a, const Pose& b, double* g) const;
  /// Rows x 6: derivatives of the rows by (x, theta) of parent and child, theta in the body's frame.
  static void directions(const JointGeometry& geometry, const Motor* motor, const Pose& a, const Pose& b,
                         Matrix6& parent, Matrix6& child);
  /// Locked axes as rows, parent frame.
  static Mat3 locked_translations(const JointGeometry& geometry);
  static Mat3 locked_rotations(const JointGeometry& geometry);
  [[nodiscard]] Matrix6 parent_force(const Joint& joint) const;  ///< rows x 6
  [[nodiscard]] Matrix6 child_force(const Joint& joint) const;
  static bool has_coordinate(const Joint& joint) {
    return joint.geometry.type == JointType::revolute || joint.geometry.type == JointType::prismatic;
  }
  [[nodiscard]] bool counts_turns(const Joint& joint) const {
    return joint.geometry.type == JointType::revolute && (count_turns || joint.motor);
  }
  double coordinate(const Joint& joint, const Pose& a, const Pose& b) const;
  [[nodiscard]] double rate_of_velocities(const JointGeometry& geometry) const;
  void move_to(std::span<const int> places);
  void find_blocks(const graphsolve::Wiring& wiring);
  void find_neighbours();
  void find_pushes();
  [[nodiscard]] std::array<int, 2> bodies_of(int i) const {  ///< child, parent
    return {joints_[i].geometry.child, joints_[i].geometry.parent};
  }
  [[nodiscard]] unsigned lanes_used(int octet) const;
  /// Eight joints with the same kind of rows, and where their numbers lie below: what the kind does not need is not
  /// there.
  struct JointOctet {
    JointRows kind;
    int frames = -1, motor = -1;
    int forces = 0;  ///< of the children, by row; then of the parents
    int parents = -1, children = -1;  ///< octets of bodies that lie in the same lanes
    std::array<int, graphsolve::simd::lanes> parent{}, child{};  ///< places of the bodies
    unsigned running = 0;  ///< lanes that were evaluated last
    JointTask task{};  ///< with where all of this is; lanes without a joint stand in for one that is there
  };
  using When = Bodies::When;
  void aim_octet(JointOctet& octet, unsigned used, When when);
  void point_at(JointOctet& octet, When when) const;
  void push();
  struct DirectionDerivative;
  void differentiate_translation(const Joint& joint, std::span<const double> lambda, DirectionDerivative& d) const;
  void differentiate_rotation(const Joint& joint, std::span<const double> lambda, DirectionDerivative& d) const;
  void differentiate_rows(const Joint& joint, Sensitivity& out) const;
  void differentiate_effort(const Joint& joint, double impulse_time, Sensitivity& out) const;
  void add_direction_derivative(const Joint& joint, const Vec3& impulse, double* values) const;
  /// Is the effort at its limit at the last point evaluated?
  [[nodiscard]] bool limited(const Joint& joint) const {
    return joint.motor && motor_octet(joint).limited[lane_of(joint.place)] != 0;
  }

  Bodies& bodies_;
  std::vector<Joint> joints_;
  /// What joints do to bodies: an octet to an octet in the same lanes, or one lane to one body.
  struct Push {
    int octet, lane;  ///< -1: all
    int body;         ///< octet, or place
    bool on_parent;
  };
  void make_tasks();
  [[nodiscard]] MotorOctet& motor_octet(const Joint& joint) { return motors_[octets_[octet_of(joint.place)].motor]; }
  [[nodiscard]] const MotorOctet& motor_octet(const Joint& joint) const {
    return motors_[octets_[octet_of(joint.place)].motor];
  }
  std::vector<JointOctet> octets_;
  std::vector<JointPoints> points_;  ///< by octet
  std::vector<JointBlocks> blocks_;  ///< by octet
  std::vector<JointFrames> frames_;
  std::vector<MotorOctet> motors_;
  std::vector<Octet> forces_;
  JointKernels kernels_{};
  std::vector<int> joint_at_;               ///< by place
  OctetGroups groups_;
  OctetsOfCopies of_copies_;
  std::vector<JointWrenches> wrenches_;  ///< by octet
  std::vector<Push> pushes_;             ///< to each body in the order of the joints: sums in bits depend on it
};

}  // namespace physics
