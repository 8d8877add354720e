#pragma once

#include <optional>
#include <string>
#include <vector>

#include "physics/mechanism.hpp"

/// What a simulation leaves behind: plain data, the order of the lists is that of the Mechanism.
namespace physics {

struct BodyRecord {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();
  Vec3 velocity = Vec3::Zero();          ///< of the step that led to this pose, world [m/s]
  Vec3 angular_velocity = Vec3::Zero();  ///< same, body frame [rad/s]
  /// What that step, accepted within the tolerance, missed of the change of momentum; the next one makes it good. World
  /// [N s] and body frame [N m s]; zero where it is less than 1e-4 of the tolerance. Of bodies that are fixed to each
  /// other the first one has it.
  Vec3 missed = Vec3::Zero(), missed_angular = Vec3::Zero();
};

struct ContactRecord {
  double distance = 0;                 ///< signed, after the step [m]
  double normal_force = 0;             ///< [N]
  Vec3 friction_force = Vec3::Zero();  ///< on the body, world [N]
  std::vector<double> facet_forces;    ///< along cos(2 pi i/d) t1 + sin(2 pi i/d) t2, t2 = n x t1 [N]
  std::optional<Vec3> tangent;         ///< t1 used in that step, where the model turns it
};

struct JointRecord {
  Vec3 force = Vec3::Zero();   ///< on the child at its joint point, world [N]
  Vec3 torque = Vec3::Zero();  ///< on the child, world [N m], motor effort included
  double error = 0;            ///< largest constraint violation after the step [m, rad]
  std::optional<double> effort;  ///< of the motor [N m or N]
  /// Of a revolute or prismatic joint after the step, as Simulator::joint_coordinate and joint_rate [rad or m, rad/s or
  /// m/s].
  std::optional<double> coordinate, rate;
};

struct SolverRecord {
  std::string status = "solved";
  int iterations = 0;
  double residual = 0;  ///< natural residual [m/s]
  int substeps = 1;
  bool new_force_direction = false;  ///< the step used the force direction at the new configuration
};

struct StepRecord {
  int step = 0;
  double time = 0;  ///< [s]
  std::vector<BodyRecord> bodies;
  std::vector<ContactRecord> contacts;
  std::vector<JointRecord> joints;  ///< empty when a file has none
  std::optional<SolverRecord> solver;
  Extras extras;
};

/// Why a run ended early: at a step that could not be solved and has no record.
struct FailureRecord {
  int step = 0;        ///< the one after the last record
  std::string status;  ///< "stalled" and the like, as of a SolverRecord
  std::string place;   ///< where the solver got stuck, "joint 'knee' (residual 0.02 m/s)"
  std::string cause;   ///< what the status means for a step, with advice
};

/// A scene plus its steps. Record 0 is the start.
struct Trajectory {
  Mechanism mechanism;
  std::vector<StepRecord> steps;
  std::optional<FailureRecord> failure = {};
};

}  // namespace physics
