#pragma once

#include <span>
#include <vector>

#include "physics/geometry.hpp"

namespace physics {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// What a step was given, beside the state of the bodies.
struct StepStart {
  double time_step = 0;        ///< of the step that made the velocities [s]
  bool half_kick = false;      ///< they are velocities at the pose
  double impulse_time = 0;     ///< impulse over force [s]
  Vec3 gravity = Vec3::Zero();
};

/// Derivatives of the residual of one step by what the step was given, its unknowns held: the right side of the
/// implicit function theorem. Terms add theirs by `differentiate`. The pose of a body has six coordinates: position in
/// the world, and the rotation vector theta of q exp(theta), body frame.
struct Sensitivity {
  /// Rows row .. row + rows - 1 of the residual by the pose of a body; entries below `rows` are not used.
  struct PoseBlock {
    int row, rows, body;
    Matrix6 values;
  };
  /// Rows by one scalar parameter, numbered as in the Mechanism.
  struct Column {
    int parameter, row, rows;
    Vector6 values;
  };
  /// The normal of a contact that presses, on the six rows of its body.
  struct Press {
    int row, body;
    Vector6 force;    ///< -d force on the body by the normal rate, friction that follows it included
    Vector6 rate;     ///< the normal rate by the velocity
    Vector6 by_pose;  ///< and by the pose before the step
  };

  // By rigid body, its own six rows.
  std::vector<Matrix6> pose, velocity;
  std::vector<Vector6> mass;
  std::vector<Eigen::Matrix<double, 3, 6>> inertia;    ///< the last three, by Jxx, Jyy, Jzz, Jxy, Jxz, Jyz
  std::vector<Mat3> carry;  ///< how a rotation before the step appears after it: theta_2 = carry theta_1
  std::vector<Mat3> turn;   ///< theta_2 = dt turn dw'
  std::vector<PoseBlock> across;  ///< rows of others by the pose of a body
  std::vector<Column> effort, friction;
  std::vector<Press> pressing;  ///< contacts whose normal is as stiff as it may be
  bool something_sticks = false;  ///< friction that may have to give way to them

  /// Room for everything; nothing is allocated later.
  Sensitivity(int bodies, int joints, int contacts)
      : pose(bodies), velocity(bodies), mass(bodies), inertia(bodies), carry(bodies), turn(bodies) {
    across.reserve(4 * joints);
    effort.reserve(2 * joints);
    friction.reserve(contacts);
    pressing.reserve(contacts);
  }
  void clear() {
    across.clear();
    effort.clear();
    friction.clear();
    pressing.clear();
    something_sticks = false;
  }
};

}  // namespace physics
