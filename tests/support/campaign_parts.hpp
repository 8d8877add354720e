#pragma once

#include "support/campaign.hpp"

/// What the scenes of the campaign are made of.
namespace campaign {

physics::Quat any_rotation(Random& random);
/// A bar along its own z, from `upper` to `lower`.
physics::Body bar(const std::string& name, const physics::Vec3& upper, const physics::Vec3& lower, double thickness, double mass);
/// A contact with the ground.
physics::Contact ground(const std::string& name, physics::BodyId body, const physics::Vec3& point, double friction);
/// Contacts at the corners of a box: all eight, or the four lower ones.
void add_corners(physics::Mechanism& scene, physics::BodyId id, double friction, int count);
/// Joins two bodies where their points meet now; parent may be the world.
void join(physics::Mechanism& scene, physics::JointType type, physics::BodyId parent, physics::BodyId child,
          const physics::Vec3& at, const physics::Vec3& axis = physics::Vec3::UnitY());
/// A chain of bars along `along` whose masses are given by the caller, a contact at every end.
void add_chain(physics::Mechanism& scene, int links, const physics::Vec3& start, const physics::Vec3& along, double friction,
               const std::function<double(int)>& mass_of);
void set_velocity(physics::Mechanism& scene, const physics::Vec3& velocity);
/// What every scene draws: start and friction model.
void vary(physics::Mechanism& scene, Random& random);

}  // namespace campaign
