#include <cmath>

#include "physics/scenes.hpp"
#include "scenes/parts.hpp"

namespace physics::scenes {

namespace {

// Paper, IV-B.1.
constexpr double base_mass = 1, base_radius = 0.1;
constexpr double pole_mass = 0.2, pole_length = 0.8, pole_radius = 0.05;

// The plan of the jump (ours: the paper gives none). The coordinate is the pole's centre over the base's along
// the pole: large is crouched, small is stretched.
constexpr double crouched = 0.1, stretched = -0.15;   // [m]
constexpr double push_acceleration = 17.3;            // of the base [m/s^2]
constexpr double landing = 0.609;                     // the pole touches the ground again [s]
constexpr double landing_speed = 2.06;                // of the base, then [m/s]
constexpr double landing_acceleration = 10;           // that stops it [m/s^2]
constexpr double turn_begin = 0.18, turn_end = 0.60;  // half of it speeding up, half of it braking [s]
constexpr double turn_torque = 2.66114744;            // about [1 1 0] / sqrt 2; tuned to one full turn [N m]
constexpr double sample = 0.005;                      // between the points of the piecewise linear target [s]

TableTarget jump_plan() {
  TableTarget plan;
  const double push = std::sqrt(2 * (crouched - stretched) / push_acceleration);
  for (double t = 0; t < push; t += sample) plan.emplace_back(t, crouched - push_acceleration * t * t / 2);
  plan.emplace_back(push, stretched);
  const double stop = landing_speed / landing_acceleration;
  for (double t = 0; t < stop; t += sample)
    plan.emplace_back(landing + t, stretched + landing_speed * t - landing_acceleration * t * t / 2);
  plan.emplace_back(landing + stop, stretched + landing_speed * stop / 2);
  return plan;
}

void add_turn(Mechanism& scene, BodyId base) {
  const Vec3 torque = turn_torque * Vec3(1, 1, 0).normalized();
  const auto step = [&](double t) { return static_cast<int>(std::lround(t / scene.time_step)); };
  const int first = step(turn_begin), last = step(turn_end), middle = (first + last) / 2;
  Load load;
  load.body = base;
  load.first_step = first + 1;
  load.last_step = middle;
  load.torque = torque;
  scene.add(load);
  load.first_step = middle + 1;
  load.last_step = last;
  load.torque = -torque;
  scene.add(load);
}

}  // namespace

Mechanism hopper(const Hopper& p) {
  Mechanism scene;
  scene.name = "hopper";
  scene.time_step = p.time_step;
  const double pole_height = pole_length / 2;
  const BodyId base = scene.add(body("base", sphere(base_radius), base_mass, {0, 0, pole_height - crouched}));
  const BodyId pole =
      scene.add(body("pole", cylinder(pole_radius, pole_length), pole_mass, {0, 0, pole_height}));
  Joint slider;
  slider.name = "slider";
  slider.type = JointType::prismatic;
  slider.parent = base;
  slider.child = pole;
  slider.axis = Vec3::UnitZ();
  Motor motor;
  motor.stiffness = 4000;
  motor.damping = 60;
  motor.limit = 200;
  motor.target = jump_plan();
  slider.motor = motor;
  scene.add(std::move(slider));
  scene.add(ground_contact("tip", pole, {0, 0, -pole_length / 2}, p.friction));
  add_turn(scene, base);
  return scene;
}

}  // namespace physics::scenes
