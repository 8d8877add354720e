#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "physics/scenes.hpp"
#include "scenes/fields.hpp"

namespace physics {

namespace scenes {

namespace {

constexpr Range any_friction{0, 1e3}, any_length{1e-3, 1e3}, any_speed{-1e3, 1e3}, any_angle{-180, 180};

void visit(Disc& p, Fields& f) {
  f.integer("c", p.contacts, {1, 100000}, "contacts on the base circle");
  f.number("mu", p.friction, any_friction, "friction coefficient");
  f.number("height", p.height, {0, 1e3}, "of the base above the ground [m]");
  f.number("speed", p.speed, any_speed, "along x, 0.4 of it along y [m/s]");
  f.number("spin", p.spin, any_speed, "about the axis [rad/s]");
}
void visit(Snake& p, Fields& f) {
  f.integer("n", p.links, {1, 100000}, "links");
  f.number("mu", p.friction, any_friction, "friction coefficient");
  f.number("height", p.height, {0, 1e3}, "of the lowest joint [m]");
  f.number("speed", p.speed, any_speed, "across the chain [m/s]");
}
void visit(Pendulum& p, Fields& f) {
  f.integer("n", p.links, {1, 100000}, "links");
  f.choice("joint", p.joint, {"spherical", "revolute"}, "kind of the joints");
  f.number("angle", p.angle, any_angle, "from the vertical [deg]");
  f.number("length", p.length, any_length, "of a link [m]");
}
void visit(Loop& p, Fields& f) {
  f.integer("n", p.links, {3, 100000}, "links");
  f.number("swing", p.swing, any_speed, "about the top link [rad/s]");
}
void visit(FourBar& p, Fields& f) {
  f.number("ground", p.ground, any_length, "distance of the pivots [m]");
  f.number("crank", p.crank, any_length, "length [m]");
  f.number("coupler", p.coupler, any_length, "length [m]");
  f.number("rocker", p.rocker, any_length, "length [m]");
  f.number("angle", p.angle, any_angle, "of the crank [deg]");
  f.number("rate", p.rate, any_speed, "of the crank [rad/s]");
}
void visit(HangingBob& p, Fields& f) {
  f.integer("n", p.links, {1, 100000}, "links");
  f.number("ratio", p.ratio, {1e-6, 1e8}, "mass of the bob over that of a link");
  f.number("angle", p.angle, any_angle, "from the vertical [deg]");
}
void visit(StiffHinge& p, Fields& f) {
  f.number("stiffness", p.stiffness, {0, 1e12}, "of the spring [N m/rad]");
  f.number("bend", p.bend, {-1, 1}, "at the start [rad]");
}
void visit(BoxOnSlope& p, Fields& f) {
  f.number("mu", p.friction, any_friction, "friction coefficient");
  f.number("fraction", p.fraction, {0, 1e3}, "tangent of the angle over mu");
  f.number("angle", p.angle, {-1, 89}, "of the slope [deg], negative: from fraction");
}
void visit(SlidingBox& p, Fields& f) {
  f.number("speed", p.speed, any_speed, "[m/s]");
  f.number("heading", p.heading, {-360, 360}, "from x towards y [deg]");
  f.number("mu", p.friction, any_friction, "friction coefficient");
}
void visit(TumblingBox& p, Fields& f) {
  f.number("mu", p.friction, any_friction, "friction coefficient");
  f.number("height", p.height, {0.4, 1e3}, "of the centre [m]");
}
void visit(SpinningSphere& p, Fields& f) {
  f.number("spin", p.spin, any_speed, "about y [rad/s]");
  f.number("mu", p.friction, any_friction, "friction coefficient");
  f.number("radius", p.radius, any_length, "[m]");
}
void visit(FreeTop& p, Fields& f) { f.number("spin", p.spin, any_speed, "about the middle axis [rad/s]"); }
void visit(SpinningTop& p, Fields& f) {
  f.number("spin", p.spin, any_speed, "about the axis [rad/s]");
  f.number("tilt", p.tilt, any_angle, "from the vertical [deg]");
}
void visit(FreeBox& p, Fields& f) {
  f.number("speed", p.speed, any_speed, "upwards [m/s]");
  f.number("spin", p.spin, any_speed, "[rad/s]");
}
void visit(Pads& p, Fields& f) {
  f.number("ratio", p.ratio, {1e-6, 1e8}, "mass of the block over that of a pad");
  f.number("speed", p.speed, any_speed, "[m/s]");
  f.number("mu", p.friction, any_friction, "friction coefficient");
}
void visit(Hopper& p, Fields& f) { f.number("mu", p.friction, any_friction, "friction coefficient"); }
void visit(Quadruped& p, Fields& f) {
  f.number("mu", p.friction, any_friction, "friction coefficient");
  f.number("frequency", p.frequency, {0, 20}, "of the gait [Hz], 0: stands");
  f.number("stride", p.stride, {-0.1, 0.1}, "amplitude of a foot along x [m]");
  f.number("lift", p.lift, {0, 0.1}, "amplitude of a foot along z [m]");
}

/// What every scene can be told.
struct Common {
  Start start = Start::half_kick;
  FrictionModel model = FrictionModel::aligned;
};

void visit(Common& common, double& time_step, Fields& f) {
  f.number("dt", time_step, {1e-7, 1}, "time step [s]");
  f.choice("start", common.start, {"standard", "half_kick"}, "of the integrator");
  f.choice("model", common.model, {"pyramid", "aligned"}, "of the friction");
}

void apply(const Common& common, Mechanism& scene) {
  scene.start = common.start;
  for (Contact& contact : scene.contacts) {
    contact.friction_model = common.model;
    if (contact.friction_model != FrictionModel::pyramid || contact.tangent) continue;
    contact.tangent = Vec3::UnitX();  // all scenes without a tangent have level ground
  }
}

struct Entry {
  SceneInfo info;
  std::function<Mechanism(Fields&)> build;
};

template <class Parameters>
Entry entry(const char* name, double duration, Mechanism (*function)(const Parameters&), const char* description) {
  const auto build = [function](Fields& fields) {
    Parameters parameters;
    Common common;
    visit(parameters, fields);
    visit(common, parameters.time_step, fields);
    fields.expect_all_taken();
    Mechanism scene = function(parameters);
    apply(common, scene);
    return scene;
  };
  Parameters defaults;
  Common common;
  Fields list(name);
  visit(defaults, list);
  visit(common, defaults.time_step, list);
  return {{name, description, duration, list.listed()}, build};
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all{
      entry("disc", 1.5, disc, "the paper's cylinder with c contacts on its base circle: drops, slides, rests"),
      entry("snake", 2, snake, "the paper's chain of n links with n + 1 contacts: drops, slides, rests"),
      entry("pendulum", 5, pendulum, "a chain of n links hanging from the world, released from an angle"),
      entry("loop", 5, loop, "a closed loop of n links, its top link fixed to the world"),
      entry("four_bar", 5, four_bar, "four-bar linkage, revolute joints, three redundant rows"),
      entry("hanging_bob", 5, hanging_bob, "a heavy bob under a light chain"),
      entry("stiff_hinge", 1, stiff_hinge, "a bar on a hinge with a very stiff spring"),
      entry("box_on_slope", 2, box_on_slope, "a box on a slope at a fraction of its friction cone"),
      entry("sliding_box", 2, sliding_box, "a flat box sliding to rest on level ground"),
      entry("tumbling_box", 3, tumbling_box, "a thrown cube with eight contacts"),
      entry("spinning_sphere", 3, spinning_sphere, "a spinning sphere set on the ground: slides, then rolls"),
      entry("free_top", 10, free_top, "a free rigid body spinning about its unstable axis, no gravity"),
      entry("spinning_top", 3, spinning_top, "a heavy symmetric top on its tip"),
      entry("free_box", 1, free_box, "a thrown box that meets nothing"),
      entry("pads", 2, pads, "a heavy block on four light pads with sixteen contacts, sliding to rest"),
      entry("hopper", 1.2, hopper, "the paper's hopper: one jump with a full turn about [1 1 0]"),
      entry("quadruped", 3, quadruped, "the paper's quadruped: the Unitree A1 in a diagonal trot"),
  };
  return all;
}

}  // namespace

}  // namespace scenes

const std::vector<SceneInfo>& built_in_scenes() {
  static const std::vector<SceneInfo> infos = [] {
    std::vector<SceneInfo> list;
    for (const auto& entry : scenes::entries()) list.push_back(entry.info);
    return list;
  }();
  return infos;
}

Mechanism built_in_scene(std::string_view spec) {
  const std::size_t colon = std::min(spec.find(':'), spec.size());
  const std::string_view name = spec.substr(0, colon);
  for (const auto& entry : scenes::entries()) {
    if (entry.info.name != name) continue;
    scenes::Fields fields(entry.info.name, spec.substr(std::min(colon + 1, spec.size())));
    return entry.build(fields);
  }
  std::string names;
  for (const SceneInfo& info : built_in_scenes()) names += (names.empty() ? "" : ", ") + info.name;
  throw DescriptionError(fmt::format("there is no built-in scene '{}'; there are {}", name, names));
}

}  // namespace physics
