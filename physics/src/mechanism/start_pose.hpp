#pragma once

#include <vector>

#include "physics/mechanism.hpp"

/// Other start poses and velocities for a part of a scene that moves as if it were rigid.
namespace physics {

/// How a frame moves: v(x) = velocity + angular_velocity x (x - origin), in the world.
struct RigidMotion {
  Vec3 origin = Vec3::Zero(), velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  [[nodiscard]] Vec3 at(const Vec3& x) const { return velocity + angular_velocity.cross(x - origin); }
};

/// Of a body at the start; the world rests.
RigidMotion start_motion(const Mechanism& mechanism, BodyId body);

/// Bodies that joints connect with this one, itself included, without the joint of this index (-1: by all of them).
struct Side {
  std::vector<int> bodies;
  bool held = false;  ///< the world is among them; nothing is reached through it
  [[nodiscard]] bool has(BodyId body) const;
};
Side side_of(const Mechanism& mechanism, BodyId body, int without_joint);

/// Where a body lies; by default the world.
struct Frame {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();
};

/// How far apart the points of a joint are where its parent and child lie, but for the travel of a prismatic one [m].
double gap(const Joint& joint, const Frame& parent, const Frame& child);
/// How far their orientations are from any that the joint allows [rad].
double bend(const Joint& joint, const Frame& parent, const Frame& child);
/// The gap at the start.
double start_gap(const Mechanism& mechanism, const Joint& joint);
/// A start that is further open is a wrong description [m, rad].
inline constexpr double largest_start_error = 1e-5;

/// A turn about a point, then a shift, in the world.
struct Displacement {
  Quat turn = Quat::Identity();
  Vec3 pivot = Vec3::Zero(), shift = Vec3::Zero();
};

/// Moves the bodies as one. Their velocities relative to `frame` turn with them, so that no joint among them, and none
/// that leads to this frame along the axis of the displacement, opens: neither in position nor in velocity.
void displace(Mechanism& mechanism, const std::vector<int>& bodies, const Displacement& by, const RigidMotion& frame);

/// Adds a rigid motion to the velocities of the bodies.
void add_motion(Mechanism& mechanism, const std::vector<int>& bodies, const RigidMotion& motion);

}  // namespace physics
