#pragma once

#include "graphsolve/simd/lane_blocks.hpp"
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

/// Blocks (joint, body) and (body, joint) of eight joints; none where the body is the world.
struct JointBlocks {
  graphsolve::simd::LaneBlocks to_child, to_parent, from_child, from_parent;
};

/// Eight joints or fewer: bit per lane in `used`; the other lanes point where a used one does and write nothing.
struct JointTask {
  JointRows rows;
  JointOctet* octet;
  unsigned used;
  double dt;
  const double *parent[8], *child[8];  ///< Pose
  const double* impulses[8];           ///< one per row
  double* residual[8];                 ///< of the joint's own rows
  double* wrenches[8];                 ///< out, 12: force^T impulses on the child, on the parent
  double* values;                      ///< of the matrix; null where none is wanted
  const JointBlocks* blocks;
};

/// Force directions at the poses of the task.
void aim_joints(const JointTask& task);
/// Residual of the constraint rows, wrenches, and blocks: Joints says which. Of a motor only its directions.
void evaluate_joints(const JointTask& task);

}  // namespace physics
