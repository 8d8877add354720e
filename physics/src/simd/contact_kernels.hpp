#pragma once

#include "graphsolve/simd/lane_blocks.hpp"
#include "simd/body_kernels.hpp"
#include "simd/octet.hpp"

namespace physics {

/// Eight contacts with four friction facets. The numbers and formulas are those of ContactPort<3> and PyramidLaw<4>;
/// pairs in this order: normal, four facets, friction bound.
struct ContactOctet {
  static constexpr int pairs = 6;
  // Of the port.
  Octet point[3], normal[3], radius, offset, tangent[2][3];
  Octet lever[3][3];  ///< as ContactPort::prepare makes them
  Octet rate_normal[3], rate_tangent[2][3];  ///< of the three rates, by w
  // Before a step, of the material point that is lowest: distance, velocity along the normal and the tangents.
  Octet distance, approach, slip[2];
  // Of the law.
  Octet friction, scale, largest_ratio;
  Octet s[pairs], z[pairs], ds[pairs], dz[pairs], remembered_s[pairs], remembered_z[pairs];
  Octet frozen;        ///< 1: the friction bound is held at frozen_bound
  Octet frozen_bound;
  Octet residual[pairs], ratio[pairs], defect[pairs];
  Octet inverse[pairs];  ///< 1 / (s z), since condense
  Octet psi_shift, one_over_sum;
  Octet saved_z[pairs - 1], saved_tangent[3];  ///< of the step before, in case this one fails
};

/// One operation on eight contacts or fewer: bit per lane in `used`; the other lanes point where a used one does and
/// keep what they have. What an operation does not name it does not read.
struct ContactTask {
  ContactOctet* octet;
  unsigned used;
  bool one_body;            ///< all on the same one
  unsigned displaced;       ///< lanes whose slip is a SlipMeasure::displacement
  double dt;
  /// Of the bodies, each number in an octet.
  struct Poses {
    const double* lane[8];         ///< one_body: only [0]
    const Octet* all = nullptr;    ///< instead, where they lie in the same lanes
  } now, next;                     ///< numbers of a Pose before the step, of a NextPose after it
  const Octet* velocities = nullptr;  ///< there, the six of x at the iterate
  const double* x[8];       ///< v, w of the body, or their change
  double* rows[8];          ///< 6 of the body
  double* values;           ///< of the matrix
  const graphsolve::simd::LaneBlocks* blocks;  ///< 6 x 6 of the bodies
  Octet first, second;      ///< arguments by lane
  Octet out, also_out;      ///< results by lane
};

struct ContactKernels {
  void (*look)(const ContactTask&);  ///< distances and velocities at the poses of the task
  /// Makes levers at the poses of the task; impulses times factor are remembered.
  void (*remember)(const ContactTask&, double factor);
  void (*restore)(const ContactTask&);
  void (*start_warm)(const ContactTask&);                  ///< first: mu; second: scale
  void (*start_cold)(const ContactTask&, double velocity); ///< second: scale
  /// rows -= J1^T f; second: scale; out: natural error, also_out: largest product
  void (*evaluate)(ContactTask&);
  void (*condense)(const ContactTask&);                    ///< first: largest ratio; block += J1^T K J2
  void (*right_hand_side)(const ContactTask&);             ///< first: mu; second: correction; rows += J1^T f0
  void (*recover)(ContactTask&);                           ///< out: boundary ratio
  void (*complementarity)(ContactTask&);                   ///< first: alpha; out
  void (*accept)(const ContactTask&);                      ///< first: alpha
};
/// For the instruction set in use.
ContactKernels contact_kernels();

}  // namespace physics
