#pragma once

namespace physics {

/// Energies and momenta of a body end here [J, N m s]: far enough below the largest number that those of a million
/// bodies have a sum.
inline constexpr double largest_energy = 1e300;

}  // namespace physics
