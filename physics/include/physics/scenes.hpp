#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "physics/mechanism.hpp"

/// The built-in scenes: one set for the program, the tests, the benchmarks and the pictures.
///
/// Every scene is a function of a plain struct of parameters. All start consistently: joints closed to rounding,
/// velocities that keep them closed, contacts touching or open. Lengths in m, masses in kg, time in s; angles
/// in degrees, because people type them.
namespace physics {

struct SceneParameter {
  std::string name;      ///< as in the spec, "n"
  std::string fallback;  ///< the default, as it would be typed
  std::string meaning;   ///< with unit and range
};

struct SceneInfo {
  std::string name;
  std::string description;
  double duration = 1;  ///< a time after which there is something to see [s]
  std::vector<SceneParameter> parameters;
};

/// All scenes, in the order of their documentation.
const std::vector<SceneInfo>& built_in_scenes();

/// Scene from its spec, "name" or "name:parameter=value,...", as in "snake:n=100,dt=0.005".
/// Besides its own, every scene takes `dt`, `start` (half_kick, standard) and `model` (aligned, pyramid).
/// Throws DescriptionError that names the unknown scene or parameter or the bad value and lists what is valid.
Mechanism built_in_scene(std::string_view spec);

namespace scenes {

/// The paper's single body (IV-A.1): a cylinder of 1 kg, 0.1 m high, radius 0.5 m, with contacts equally spaced
/// on its base circle; dropped, lands and slides to rest.
struct Disc {
  int contacts = 8;
  double friction = 0.2;
  double height = 0.1;  ///< of the base above the ground at the start [m]
  double speed = 1.0;   ///< along x; 0.4 of it along y [m/s]
  double spin = 0.0;    ///< about its axis [rad/s]
  double time_step = 0.01;
};
Mechanism disc(const Disc& parameters = {});

/// The paper's chain (IV-A.2): n links of 1 kg, 1 m, radius 0.05 m, spherical joints, a contact at every link's
/// lower end and one at the first link's upper end. Dropped nearly flat, winding, with a sideways velocity.
struct Snake {
  int links = 10;
  double friction = 0.2;
  double height = 0.05;  ///< lowest joint point above the ground at the start [m]
  double speed = 0.6;    ///< along y, across the chain [m/s]
  double time_step = 0.01;
};
Mechanism snake(const Snake& parameters = {});

enum class Hinge { spherical, revolute };

/// A straight chain hanging from the world, released from an angle in the plane y = 0.
struct Pendulum {
  int links = 1;
  Hinge joint = Hinge::spherical;  ///< revolute: about y
  double angle = 30;    ///< from the vertical [deg]
  double length = 1.0;  ///< of a link [m]
  double time_step = 0.01;
};
Mechanism pendulum(const Pendulum& parameters = {});

/// A closed loop of links by spherical joints: a regular polygon in the plane y = 0, its top link fixed to the
/// world, the rest swinging about that link and sagging.
struct Loop {
  int links = 10;
  double swing = 0.5;  ///< about the top link [rad/s]
  double time_step = 0.01;
};
Mechanism loop(const Loop& parameters = {});

/// Planar four-bar linkage in space: four revolute joints about y, three moving bars, the world as ground.
/// Three of its joint rows are redundant.
struct FourBar {
  double ground = 1.0, crank = 0.4, coupler = 1.0, rocker = 0.7;  ///< lengths [m]
  double angle = 70;  ///< of the crank above the ground line [deg]
  double rate = 2.0;  ///< of the crank [rad/s]
  double time_step = 0.01;
};
Mechanism four_bar(const FourBar& parameters = {});

/// A heavy bob under a light chain of n links of 1 kg, 0.2 m each, released from an angle.
struct HangingBob {
  int links = 10;
  double ratio = 1e4;  ///< mass of the bob over the mass of a link
  double angle = 20;   ///< from the vertical [deg]
  double time_step = 0.01;
};
Mechanism hanging_bob(const HangingBob& parameters = {});

/// A bar on a hinge with a very stiff spring, slightly bent.
struct StiffHinge {
  double stiffness = 1e8;  ///< [N m/rad]
  double bend = 1e-3;      ///< at the start [rad]
  double time_step = 0.01;
};
Mechanism stiff_hinge(const StiffHinge& parameters = {});

/// A box at rest on a slope about y, touching it with its four lower corners.
struct BoxOnSlope {
  double friction = 0.5;
  double fraction = 0.9;  ///< tan(angle) over the friction coefficient
  double angle = -1;      ///< of the slope [deg]; negative: from `fraction`
  double time_step = 0.01;
};
Mechanism box_on_slope(const BoxOnSlope& parameters = {});

/// A flat box that slides on the ground from the first step; it stops after speed^2 / (2 friction g).
struct SlidingBox {
  double speed = 2.0;    ///< [m/s]
  double heading = 0;    ///< from x towards y [deg]
  double friction = 0.3;
  double time_step = 0.01;
};
Mechanism sliding_box(const SlidingBox& parameters = {});

/// A cube with contacts at its eight corners, thrown with spin.
struct TumblingBox {
  double friction = 0.4;
  double height = 0.6;  ///< of the centre [m]
  double time_step = 0.01;
};
Mechanism tumbling_box(const TumblingBox& parameters = {});

/// A spinning solid sphere set on the ground: slides, then rolls at 2/7 of spin times radius.
struct SpinningSphere {
  double spin = 20;  ///< about y [rad/s]
  double friction = 0.2;
  double radius = 0.1;  ///< [m]
  double time_step = 0.01;
};
Mechanism spinning_sphere(const SpinningSphere& parameters = {});

/// A rigid body without gravity, spinning about an axis next to its unstable middle one.
struct FreeTop {
  double spin = 5;  ///< about the middle axis [rad/s]; 2 % of it about the others
  double time_step = 0.005;
};
Mechanism free_top(const FreeTop& parameters = {});

/// A heavy symmetric top on a spherical joint at its tip.
struct SpinningTop {
  double spin = 100;  ///< about its axis [rad/s]
  double tilt = 25;   ///< from the vertical [deg]
  double time_step = 0.001;
};
Mechanism spinning_top(const SpinningTop& parameters = {});

/// A thrown, turning box that meets nothing.
struct FreeBox {
  double speed = 5;  ///< upwards; 0.4 of it along x [m/s]
  double spin = 3;   ///< [rad/s]
  double time_step = 0.01;
};
Mechanism free_box(const FreeBox& parameters = {});

/// A heavy block on four light pads, each with an ankle joint and four contacts, sliding to rest.
struct Pads {
  double ratio = 1e4;   ///< mass of the block over the mass of a pad
  double speed = 0.5;   ///< [m/s]
  double friction = 0.5;
  double time_step = 0.01;
};
Mechanism pads(const Pads& parameters = {});

/// The paper's hopper (IV-B.1): one jump with a full turn about [1 1 0] in the air.
struct Hopper {
  double friction = 0.2;
  double time_step = 0.001;
};
Mechanism hopper(const Hopper& parameters = {});

/// The paper's quadruped (IV-B.2) with the figures of the Unitree A1: a diagonal trot along x.
struct Quadruped {
  double friction = 0.8;
  double frequency = 3.0;  ///< of the gait [Hz]; 0: stands
  double stride = 0.04;    ///< amplitude of a foot along x [m]
  double lift = 0.02;      ///< amplitude of a foot along z [m]
  double time_step = 0.001;
};
Mechanism quadruped(const Quadruped& parameters = {});

}  // namespace scenes

}  // namespace physics
