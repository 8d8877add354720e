#include "rotation.hpp"
#include "stepper.hpp"

/// After a step that failed in every way: the forces of the step before, as a record of the state tells them.
namespace physics {

/// What restore() brings back is where the next attempt begins: without forces. Here contacts get theirs back, and joints
/// the directions that their impulses had; these go by the pose before the last step, which the velocity leads back to.
void Stepper::recall(int lane) {
  const LaneState& s = lanes[lane].state;
  contacts->recall(lane);
  if (s.impulse_time == 0) return;
  for (int k = 0; k < bodies_per_lane; ++k) {
    const int i = body(lane, k);
    if (lanes[lane].before.new_force_direction) bodies.place(i, state.x[i], state.q[i]);
    else
      bodies.place(i, state.x[i] - s.time_step * state.v[i],
                   rotate(state.q[i], -state.w[i], rotation_scalar(state.w[i], s.time_step), s.time_step));
  }
  for (int k = 0; k < joints_per_lane; ++k) joints.prepare(joint(lane, k), lanes[lane].time, s.impulse_time);
  joints.aim();
  load_state_into_terms(lane, s.time_step);
}

}  // namespace physics
