#pragma once

#include <string>
#include <vector>

#include "physics/mechanism.hpp"

/// From the description to what is simulated: bodies held by fixed joints become one, or part of the world.
namespace physics {

/// A body that moves on its own. Its frame: the orientation of its first member, origin at the common centre of mass.
struct RigidBody {
  std::string name;
  double mass;
  Mat3 inertia;
  double smallest_inertia;  ///< principal moment
  double island_mass = 0;  ///< largest mass of what hangs together with it; known to the Stepper
};

/// Frame of a described body in that of a rigid body: x = X + R offset, q = Q rotation.
struct Placement {
  int body = -1;       ///< rigid body; -1: the world
  bool leads = false;  ///< first of its members, whose name and orientation it has
  Vec3 offset = Vec3::Zero();
  Quat rotation = Quat::Identity();
};

/// A joint between rigid bodies, points and axis in their frames. Either side may be the world (-1), not both.
struct JointGeometry {
  int source;  ///< in Mechanism::joints
  JointType type;
  int parent, child;
  Vec3 parent_point, child_point;
  Vec3 axis;         ///< parent frame, unit
  Quat orientation;  ///< child relative to parent at rest
};

struct Assembly {
  std::vector<RigidBody> bodies;
  std::vector<Placement> placement;  ///< by described body
  std::vector<JointGeometry> joints;
};

Assembly assemble(const Mechanism& mechanism, bool merge_fixed_joints);

}  // namespace physics
