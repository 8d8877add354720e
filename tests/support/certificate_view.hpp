#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "support/certificate.hpp"

/// One step as the certificate sees it: poses before and after, and what bodies move as one. Internal.
namespace certificate {

using physics::Mat3;
using physics::Vec3;

/// Quaternion, scalar first.
struct Turn {
  double w = 1;
  Vec3 v = Vec3::Zero();
};
Turn operator*(const Turn& a, const Turn& b);
Turn inverse(const Turn& unit);
Mat3 matrix(const Turn& unit);
Turn turn(const physics::Quat& q);

/// Largest component, NaN when there is one.
double largest(const Vec3& v);

struct Placement {
  Vec3 x = Vec3::Zero();
  Turn q;
  Mat3 r = Mat3::Identity();
};

/// Mass and smallest principal moment that turn residuals into velocities.
struct Scale {
  double mass = 0, moment = 0;
  [[nodiscard]] double rotational() const;  ///< sqrt(m J): angular impulse to velocity
  [[nodiscard]] double gyration() const;    ///< sqrt(J / m): angular velocity to velocity
};

struct Step {
  Step(const physics::Mechanism& mechanism, const physics::StepRecord& before, const physics::StepRecord& after);

  const physics::Mechanism& mechanism;
  const physics::StepRecord& before;
  const physics::StepRecord& after;
  double dt;                 ///< from pose to pose
  double force_time;         ///< impulse / recorded force; half of dt in a half kick
  bool half_kick;
  bool forces_recorded;      ///< the records have joints
  std::vector<Placement> old_pose, new_pose;
  std::vector<int> group;    ///< of bodies that move as one: index of one of them; -1: as one with the world
  std::vector<Scale> scale;  ///< of the body's group
  /// Of the body's group: centre of mass at the old pose, and its velocity in the step. (A member's own velocity is
  /// that of a chord.)
  std::vector<Vec3> group_centre, group_velocity;
  std::vector<double> largest_mass;  ///< of a group among those connected to the body by joints

  [[nodiscard]] const Placement& old_at(physics::BodyId id) const;
  [[nodiscard]] const Placement& new_at(physics::BodyId id) const;
  /// A fixed joint without a recorded force: its bodies are judged as one.
  [[nodiscard]] bool merged(std::size_t joint) const;

 private:
  void find_groups();
};

/// Joint errors, free wrench and motors; takes the recorded joint impulses off `rest`.
void judge_joints(const Step& step, std::span<Momentum> rest, Certificate& result);
/// Takes off `rest` what joint forces can explain, in least squares; for records without joints.
void eliminate_joints(const Step& step, std::span<Momentum> rest);
/// Joint errors and complementarity only need the new pose: what can be judged of a flagged step.
void judge_joint_errors(const Step& step, Certificate& result);
/// Effort of a joint's motor by its law [N m or N]; `recorded` only decides on full turns.
double lawful_effort(const Step& step, const physics::Joint& joint, std::optional<double> recorded);

/// Distances and gap pairs.
void judge_gaps(const Step& step, Certificate& result);
/// Normal and friction forces against their laws; takes the contact impulses off `rest`.
void judge_contacts(const Step& step, std::span<Momentum> rest, Certificate& result);

/// Free motion: takes gravity, loads and momentum of the step; the start of `rest`, what is left of a body's change of
/// momentum.
std::vector<Momentum> inertial_rest(const Step& step);

}  // namespace certificate
