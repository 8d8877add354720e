#pragma once

#include <cstdint>

#include "graphsolve/symbolic.hpp"
#include "simd/program.hpp"

/// What of the values the user gives: of a symmetric matrix one triangle.
namespace graphsolve {

/// Where in a group the numbers end that are given.
inline std::int64_t given_end(const simd::Program::Group& group, bool symmetric) { return symmetric ? group.upper : group.end; }

/// f(place) of every number of a pivot that is given.
template <class F>
void each_given(const Symbolic::Pivot& p, bool symmetric, F&& f) {
  for (std::int64_t i = 0; i < p.lower_scalars(); ++i) f(p.diagonal + i * p.stride);
  if (symmetric) return;
  for (std::int64_t i = 0; i < p.upper_scalars(); ++i) f(p.upper + i * p.stride);
}

}  // namespace graphsolve
