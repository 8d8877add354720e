#pragma once

#include "graphsolve/simd/lane_blocks.hpp"
#include "simd/octet.hpp"

namespace physics {

/// What eight bodies are.
struct BodyOctet {
  Octet mass, inertia[9];
};

/// Where eight bodies are at the present iterate: joints and contacts that lie in the same lanes read it whole.
struct BodyAtOctet {
  static constexpr int numbers = 25;
  Octet pose[numbers];  ///< NextPose
  Octet velocity[6];    ///< v, w
};

/// Eight bodies (or fewer: bit per lane in `used`; the other lanes point where a used one does and write nothing).
struct BodyTask {
  const BodyOctet* constants;
  unsigned used;
  double dt;
  const double* velocity[8];       ///< v, w
  const double* now[8];            ///< Pose
  BodyAtOctet* at;                 ///< out
  const double* known_linear[8];
  const double* known_angular[8];
  double* residual[8];             ///< 6
  double* values;                  ///< of the matrix; null where none is wanted
  const graphsolve::simd::LaneBlocks* blocks;  ///< 6 x 6
};

using BodyKernel = void (*)(const BodyTask&);
/// Poses after the step, residual, and its derivative: Bodies says which. For the instruction set in use.
BodyKernel body_kernel();

}  // namespace physics
