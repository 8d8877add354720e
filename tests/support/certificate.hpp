#pragma once

#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

#include "physics/mechanism.hpp"
#include "physics/trajectory.hpp"

/// Judges a trajectory from its records alone, from the mathematics and the file format: nothing here calls the
/// solver or the physics library, only their plain data structs are shared. What it recomputes:
///
///   momentum    p+(w') - p-(w) = impulses,  p±(w) = c J w ± e x J w,  e = h w / 2,  c = sqrt(1 - e.e)
///   joints      closed at the new pose; the recorded wrench acts at the old pose and only along locked directions
///   contacts    0 <= gap  _|_  normal force >= 0 at the new pose; the friction pyramid in the recorded basis
///
/// Everything barred is a velocity [m/s], comparable with the solver's tolerance: impulses over mass, angular
/// impulses over sqrt(m J) (J the smallest principal moment), distances over the time step, rotations over the
/// time step times sqrt(J / m). Mass is that of the body (or of the bodies merged by fixed joints); for the laws of
/// contact it is the largest of the bodies connected by joints. A pair (s, z) is judged by min(s, z / m).
namespace certificate {

/// The worst value met of one measure, and where. NaN is worse than anything.
struct Finding {
  double value = 0;
  int step = -1;
  std::string what;

  void raise(double candidate, int at_step, const std::string& name);
  void raise(const Finding& other);
};

struct Certificate {
  // Barred, all [m/s].
  Finding kinematics;      ///< pose - pose before - dt velocity; unit quaternions
  Finding dynamics;        ///< change of momentum less all impulses
  Finding joints;          ///< joint error over dt
  Finding wrench;          ///< recorded joint force along a free direction that no motor explains
  Finding motor;           ///< recorded effort less the motor's law
  Finding penetration;     ///< negative distance over dt
  Finding tension;         ///< negative normal force
  Finding pyramid;         ///< negative facet force, beyond the pyramid, facets that do not add up, crooked basis
  Finding gap_pairs;       ///< complementarity of distance and normal force
  Finding friction_pairs;  ///< complementarity of slip and facet forces

  // Reported.
  Finding momentum;             ///< balance of total momentum [m/s]
  Finding joint_error;          ///< [m] or [rad]
  Finding distance_difference;  ///< recomputed less recorded [m]
  Finding slip_angle;           ///< between friction force and -slip, where it slips faster than 1e-4 m/s [rad]
  Finding cone_excess;          ///< friction force beyond the circular cone [N]
  double smallest_distance = std::numeric_limits<double>::infinity();  ///< [m]
  int steps = 0;    ///< judged
  int flagged = 0;  ///< of these, with substeps or the new force direction: only joints and distances judged
  int held = 0;     ///< bodies merged with the world: their dynamics cannot be judged

  /// The worst of the barred.
  [[nodiscard]] Finding worst() const;
  [[nodiscard]] double residual() const { return worst().value; }
  void merge(const Certificate& other);
};

std::ostream& operator<<(std::ostream& out, const Certificate& certificate);

/// Momentum in the world frame, angular about the centre of mass it belongs to.
struct Momentum {
  physics::Vec3 linear = physics::Vec3::Zero(), angular = physics::Vec3::Zero();
};

/// What the steps judged so far have left of the change of momentum, all together: by body, empty before the first.
/// What a step leaves, within the tolerance, the next one has to make good, so that this sum stays within it too.
using Missed = std::vector<Momentum>;

/// Judges the step from `before` to `after`; with `missed` it is the sum that `dynamics` is about. Record 0 of a `half_kick` scene is taken as such a start.
/// Without recorded joints the joint forces are eliminated by least squares (dense: small scenes only).
/// Throws std::invalid_argument when the records do not have the scene's shape or are not consecutive.
Certificate certify_step(const physics::Mechanism& mechanism, const physics::StepRecord& before,
                         const physics::StepRecord& after, Missed* missed = nullptr);

/// Judges all pairs of consecutive records; `steps` says how many there were.
Certificate certify(const physics::Trajectory& trajectory);

}  // namespace certificate
