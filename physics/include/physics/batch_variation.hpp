#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "physics/mechanism.hpp"

/// Numbers of a scene that differ from copy to copy, drawn at random.
namespace physics {

/// A number drawn evenly from low .. high. Keys, for things called BODY, CONTACT, JOINT and axes x, y, z:
///   friction            coefficient of all contacts that have one
///   CONTACT.friction    of one contact
///   mass                factor on all masses and inertias
///   BODY.mass           [kg]; the inertia keeps its proportion to it
///   gravity             magnitude of it [m/s^2]
///   BODY.force.x, BODY.torque.x                    a load in every step, beside those there are: force at the centre
///                                                  of mass, world [N]; torque in the body's frame [N m]
///   BODY.force.x@20-40                             in the steps 20 to 40 only, and so with torque
///   loads, BODY.loads                              factor on the forces and torques of all loads, of one body's
///   JOINT.stiffness, JOINT.damping, JOINT.limit    of its motor
///   JOINT.target                                   of a motor whose target is a number [rad or m]
///   JOINT.target.offset, .amplitude, .frequency, .phase    of one whose target is a sine [rad or m, Hz, rad]
///   start.position.x                               added to all bodies [m]
///   start.velocity.x                               added to all bodies [m/s]
///   start.BODY.position.x, .velocity.x, .angular_velocity.x    of one body, instead of the scene's
///   start.BODY.rotation.x    turns it, with all that is joined to it, about the world's axis through its centre of
///                            mass [rad]; its velocity in the world stays, the others' relative to it turn along
///   start.JOINT.angle        of a revolute joint [rad], -pi to pi
///   start.JOINT.travel       of a prismatic joint [m]
///   start.JOINT.rate         of either [rad/s or m/s]
///   start.JOINT.angle.x      turns a spherical joint about an axis of its parent's frame [rad]
///   start.JOINT.rate.x       its rate about such an axis [rad/s]
/// A start joint moves the bodies behind it as one, on the child's side or, where that is joined to the world, on the
/// parent's: no other joint opens. Joints of closed loops cannot move alone and are refused, as are bodies that joints
/// hold at the world.
struct Variation {
  std::string key;
  double low = 0, high = 0;
};

/// From "KEY=LOW:HIGH". Throws DescriptionError with the text that is wrong.
Variation parse_variation(std::string_view text);

/// In [0, 1), the same for the same seed, copy and key on every machine: no state, so copies can be drawn in any order
/// and anywhere. 53 bits of SplitMix64's finalizer over seed, copy and the FNV-1a hash of the key.
double uniform(std::uint64_t seed, long long copy, std::string_view key);

/// The value of each variation for a copy.
std::vector<double> draw(std::span<const Variation> variations, std::uint64_t seed, long long copy);

/// Throws DescriptionError, naming the bound, when the scene has no such number, or is no valid scene with the lowest
/// or the highest value. (What start positions leave open depends on all of them: check_start.)
void check_variation(const Mechanism& mechanism, const Variation& variation);

/// With these values set in turn, do joints hold together as they do in the scene? Throws DescriptionError that names
/// the joint, and the key that opened it: bodies that start.BODY.position moves have to be free to go there.
void check_start(const Mechanism& mechanism, std::span<const Variation> variations, std::span<const double> values);

/// Sets the number that the key names. Throws DescriptionError when the scene has no such thing.
void set_value(Mechanism& mechanism, std::string_view key, double value);

}  // namespace physics
