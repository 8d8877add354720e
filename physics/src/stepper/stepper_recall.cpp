#include "terms/rotation.hpp"
#include "stepper/stepper.hpp"

/// After a step that failed in every way: the forces of the step before, as a record of the state tells them.
namespace physics {

/// What restore() brings back is where the next attempt begins: without forces. Here contacts get theirs back, and
/// joints the directions that their impulses had; these go by the pose before the last step, which the velocity leads
/// back to.
void Stepper::recall(int lane) {
  const LaneState& s = lanes[lane].state;
  contacts->recall(lane);
  if (s.impulse_time == 0) return;
  for (int k = 0; !lanes[lane].before.new_force_direction && k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    const Vec3 w = bodies.spin(i);
    bodies.place(i, bodies.position(i) - s.time_step * bodies.velocity(i),
                 rotate(bodies.orientation(i), -w, rotation_scalar(w, s.time_step), s.time_step));
  }
  joints.aim({&lane, 1});
  bodies.restore(lane);
}

}  // namespace physics
