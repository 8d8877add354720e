#pragma once

#include <algorithm>
#include <array>

#include "graphsolve/simd/lane_blocks.hpp"
#include "simd/octet.hpp"

namespace physics {

/// What eight bodies are, and their state between two steps.
struct BodyOctet {
  Octet mass, gravity[3];
  Octet inertia[6];  ///< xx, xy, xz, yy, yz, zz
  Octet known[6];    ///< momentum before the step plus impulse of loads: linear, angular
  Octet missed[6];   ///< of it, by the step before: its residual, negative
  /// What a step that fails has to leave as it was.
  struct State {
    Octet velocity[6];  ///< v, w
    Octet x[3], q[4];   ///< with the rotation the numbers of a Pose
  } state;
  Octet rotation[9];  ///< of q

  /// Nothing, at rest: what lanes without a body hold, and where the world is.
  static BodyOctet at_origin() {
    BodyOctet octet{};
    std::ranges::fill(octet.state.q[3].lane, 1.0);
    for (int k : {0, 4, 8}) std::ranges::fill(octet.rotation[k].lane, 1.0);
    return octet;
  }
};

/// Where eight bodies are at the present iterate: joints and contacts that lie in the same lanes read it whole.
struct BodyAtOctet {
  static constexpr int numbers = 25;
  Octet pose[numbers];  ///< NextPose
  Octet velocity[6];    ///< v, w

  static BodyAtOctet at_origin() {
    BodyAtOctet octet{};
    for (int k : {6, 7, 11, 15, 16, 20, 24}) std::ranges::fill(octet.pose[k].lane, 1.0);
    return octet;
  }
};

/// Residual of eight bodies' rows, until it is handed out.
using ResidualOctet = std::array<Octet, 6>;

/// Eight bodies (or fewer: bit per lane in `used`; the others keep what they have).
struct BodyTask {
  const BodyOctet* body;
  BodyAtOctet* at;                 ///< out
  ResidualOctet* residual;         ///< out
  unsigned used;
  double dt;
  const int* rows;                 ///< first row of each body
  const double* x;                 ///< unknowns: v, w
  double* values;                  ///< of the matrix; null where none is wanted
  bool turn_always;                ///< is the turn wanted without values too?
  const graphsolve::simd::LaneBlocks* blocks;  ///< 6 x 6
};

/// How a step begins.
struct BodyStart {
  double dt;            ///< its length [s]
  double time_step;     ///< of the step that made the velocity [s]
  double impulse_time;  ///< impulse over force [s]
  bool half_kick;       ///< the velocity is that at the pose
  double most_spin;     ///< [rad/s]
  double most_distance; ///< [m]
};
/// What of it lies beyond these two, of any body.
enum StartBeyond : unsigned { spins_faster = 1, lies_further = 2 };

/// For the instruction set in use.
struct BodyKernels {
  void (*place)(BodyOctet&, unsigned used);  ///< the rotation matrix follows its quaternion
  unsigned (*begin)(BodyOctet&, unsigned used, const BodyStart&);  ///< momenta; StartBeyond
  void (*evaluate)(const BodyTask&);         ///< poses, residual and its derivative: Bodies says which
  void (*push)(ResidualOctet&, unsigned used, const Octet* wrench);  ///< residual -= wrench, 6
  void (*hand_out)(const ResidualOctet&, unsigned used, const int* rows, double* all);  ///< adds to the rows
  /// The state becomes that at the iterate; what is left of the residual was missed. True where a body then has no energy
  /// or momentum: largest_energy.
  bool (*commit)(BodyOctet&, unsigned used, const BodyAtOctet&, const int* rows, const double* residual);
};
BodyKernels body_kernels();

}  // namespace physics
