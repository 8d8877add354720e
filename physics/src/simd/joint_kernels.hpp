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
constexpr bool has_motor(JointRows kind) {
  return kind == JointRows::revolute_motor || kind == JointRows::prismatic_motor;
}
constexpr bool is_slide(JointRows kind) { return kind == JointRows::prismatic || kind == JointRows::prismatic_motor; }
constexpr bool is_hinge(JointRows kind) { return kind == JointRows::revolute || kind == JointRows::revolute_motor; }
constexpr int translations(JointRows kind) { return is_slide(kind) ? 2 : 3; }
constexpr int rotations(JointRows kind) { return kind == JointRows::spherical ? 0 : is_hinge(kind) ? 2 : 3; }
constexpr int constraints(JointRows kind) { return translations(kind) + rotations(kind); }
constexpr int rows_of(JointRows kind) { return has_motor(kind) ? 6 : constraints(kind); }

/// Where eight joints sit on their bodies.
struct JointPoints {
  Octet child[3], parent[3];
};

/// How eight joints are turned; those without rotations and axes have no use for it.
struct JointFrames {
  Octet axis[3], side[2][3];     ///< of a hinge or slide and across it, parent frame
  Octet orientation[4];          ///< child relative to parent at rest: x, y, z, w
  Octet orientation_matrix[9];   ///< the same, column-major
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

/// What eight joints do to their bodies, and where these stand.
struct JointWrenches {
  Octet child[6], parent[6];  ///< force^T impulses at the last point evaluated
  /// Where the recorded body stood when the force acted on it, the child or the parent of a child in the world: its
  /// orientation, and from its centre to the child's joint point, world frame.
  Octet stands[7];
};

/// Eight joints or fewer: bit per lane in `used`; the other lanes point where a used one does and write nothing.
struct JointTask {
  JointRows kind;
  const JointPoints* points;
  const JointFrames* frames;           ///< null for spherical joints
  MotorOctet* motor;                   ///< of rows with a motor, else null
  Octet *child_force, *parent_force;   ///< directions of forces by row, 6 numbers each: entry 6 row + column
  unsigned used = 0;
  double dt = 0;
  /// Numbers of a NextPose, each in an octet; a Pose will do to aim, and without values.
  const double *parent[8], *child[8];
  const Octet *parents = nullptr, *children = nullptr;  ///< all of them instead, where they lie in the same lanes
  unsigned children_are_world = 0;     ///< lanes where the child is
  Octet* stands = nullptr;             ///< out, of aim
  int rows[8];                         ///< first row of each joint
  const double* x;                     ///< unknowns: impulses, one per row
  double* residual;
  JointWrenches* wrenches;             ///< out, but for where bodies stand
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
