#pragma once

#include "graphsolve/simd/lane_blocks.hpp"
#include "simd/body_kernels.hpp"
#include "simd/octet.hpp"

namespace physics {

/// What a joint's rows are made of: locked translations, locked rotations, and the row of a motor.
enum class JointRows {
  spherical,        ///< 3 translations in world axes
  revolute,         ///< the same and 2 rotations
  revolute_motor,   ///< and a motor about the axis
  prismatic,        ///< 2 translations in axes of the parent, 3 rotations
  prismatic_motor,  ///< and a motor along the axis
  fixed,            ///< 3 translations in world axes, 3 rotations
};

/// Eight joints with the same kind of rows. Forces act along the rows of child_force and parent_force, 6 numbers each:
/// entry 6 row + column.
struct JointOctet {
  Octet child_point[3], parent_point[3];
  Octet axis[3], side[2][3];     ///< of a hinge or slide and across it, parent frame
  Octet orientation[4];          ///< child relative to parent at rest: x, y, z, w
  Octet orientation_matrix[9];   ///< the same, column-major
  Octet child_force[36], parent_force[36];
};

/// The motors of eight joints: spring and damper towards a target, with a limit.
struct MotorOctet {
  Octet stiffness, damping, limit;
  Octet target, coordinate;  ///< where the step shall end, and where it starts
  Octet impulse_time;        ///< impulse over force [s]
  Octet next_coordinate;     ///< out: at the last point evaluated
  Octet limited;             ///< out: 1 where the effort is at its limit there
};

/// Own blocks, and blocks (joint, body) and (body, joint) of eight joints; none where the body is the world.
struct JointBlocks {
  graphsolve::simd::LaneBlocks own, to_child, to_parent, from_child, from_parent;
};

/// Eight joints or fewer: bit per lane in `used`; the other lanes point where a used one does and write nothing.
struct JointTask {
  JointRows rows;
  JointOctet* octet;
  MotorOctet* motor;                   ///< of rows with a motor
  unsigned used;
  double dt;
  const double *parent[8], *child[8];  ///< Pose
  const BodyAtOctet *parents = nullptr, *children = nullptr;  ///< all of them instead, where they lie in the same lanes
  const double* impulses[8];           ///< one per row
  double* residual[8];                 ///< of the joint's own rows
  double* wrenches[8];                 ///< out, 12: force^T impulses on the child, on the parent
  double* values;                      ///< of the matrix; null where none is wanted
  const JointBlocks* blocks;
};

struct JointKernels {
  void (*aim)(const JointTask&);       ///< force directions at the poses of the task
  void (*evaluate)(const JointTask&);  ///< residual, wrenches, and blocks: Joints says which
};
/// For the instruction set in use.
JointKernels joint_kernels();

}  // namespace physics
