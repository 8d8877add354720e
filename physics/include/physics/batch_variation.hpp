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
///   JOINT.stiffness, JOINT.damping                 of its motor
///   start.position.x                               added to all bodies [m]
///   start.velocity.x                               added to all bodies [m/s]
///   start.BODY.position.x, .velocity.x, .angular_velocity.x    of one body, instead of the scene's
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

/// Throws DescriptionError, naming the bound, when the scene has no such number, or is no valid scene with the lowest or
/// the highest value. (What start positions leave open is found when a Simulator takes the scene.)
void check_variation(const Mechanism& mechanism, const Variation& variation);

/// Sets the number that the key names. Throws DescriptionError when the scene has no such thing.
void set_value(Mechanism& mechanism, std::string_view key, double value);

}  // namespace physics
