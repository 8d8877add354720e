#include <cmath>
#include <fmt/format.h>

#include "mechanism/start_pose.hpp"
#include "stepper/stepper.hpp"

/// A lane before its first step, and whether a scene fits into it.
namespace physics {

namespace {

[[noreturn]] void misfit(const std::string& scene, const std::string& what) {
  throw DescriptionError(fmt::format("scene '{}' does not fit those beside it: {}", scene, what));
}

bool has_friction(const Contact& contact) { return contact.friction.value_or(0) > 0; }

}  // namespace

/// Loaded scenes share the graph, the order and the kinds of terms with the first; numbers are free.
void Stepper::check_structure(const Mechanism& scene, const Assembly& assembly) const {
  const Mechanism& first = lanes[0].mechanism;
  const auto same_number = [&](std::size_t have, std::size_t want, const char* things) {
    if (have != want) misfit(scene.name, fmt::format("it has {} {}, not {}", have, things, want));
  };
  same_number(scene.bodies.size(), first.bodies.size(), "bodies");
  same_number(scene.joints.size(), first.joints.size(), "joints");
  same_number(scene.contacts.size(), first.contacts.size(), "contacts");
  if (scene.time_step != dt) misfit(scene.name, fmt::format("its time step is {} s, not {} s", scene.time_step, dt));
  for (std::size_t k = 0; k < scene.bodies.size(); ++k)
    if (assembly.placement[k].body != lanes[0].place(static_cast<int>(k)).body)
      misfit(scene.name, fmt::format("body '{}' is held by another fixed joint", scene.bodies[k].name));
  same_number(assembly.joints.size(), joints_per_lane, "joints between bodies that move");
  for (std::size_t k = 0; k < assembly.joints.size(); ++k) {
    const JointGeometry a = on_lane(0, assembly.joints[k]), &b = joints.geometry(joint(0, static_cast<int>(k)));
    const bool same = a.source == b.source && a.type == b.type && a.parent == b.parent && a.child == b.child &&
                      !motor_of(scene, a) == !motor_of(first, b);
    if (!same)
      misfit(scene.name, fmt::format("joint '{}' differs in type, bodies or motor", scene.joints[a.source].name));
  }
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    const Contact &a = scene.contacts[k], &b = first.contacts[k];
    const bool same = a.body == b.body && has_friction(a) == has_friction(b) && a.directions == b.directions;
    if (!same)
      misfit(scene.name, fmt::format("contact '{}' differs in its body, in having friction, or in directions", a.name));
  }
}

void Stepper::start(int lane, Assembly& assembly) {
  set_parameters(lane, assembly);
  Lane& l = lanes[lane];
  std::vector<BodyRecord> records;
  for (const Body& body : l.mechanism.bodies)
    records.push_back({body.position, body.orientation, body.velocity, body.angular_velocity});
  set_state(lane, records, {.time_step = dt, .half_kick = l.mechanism.start == Start::half_kick});
  l.set_time(0, 0);
  l.last = {};
  check_start(lane);
  agree_with_joints(lane);
}

void Stepper::set_state(int lane, std::span<const BodyRecord> records, const LaneState& state) {
  Lane& l = lanes[lane];
  for (int k = 0; k < bodies_per_lane; ++k) {
    bodies.place(body(lane, k), Vec3::Zero(), Quat::Identity());
    bodies.set_velocity(body(lane, k), Vec3::Zero(), Vec3::Zero());
    bodies.set_missed(body(lane, k), Vec3::Zero(), Vec3::Zero());
  }
  for (std::size_t k = 0; k < records.size(); ++k) {
    const Placement place = l.place(static_cast<int>(k));
    if (place.body < 0) continue;
    const BodyRecord& record = records[k];
    const int i = body(lane, place.body);
    const Vec3 v = bodies.velocity(i) + l.mechanism.bodies[k].mass / bodies.mass(i) * record.velocity;
    bodies.set_velocity(i, v, place.leads ? Vec3(place.rotation * record.angular_velocity) : bodies.spin(i));
    if (!place.leads) continue;
    const Quat q = record.orientation.normalized() * place.rotation.conjugate();
    bodies.place(i, record.position - q * place.offset, q);
    bodies.set_missed(i, record.missed, place.rotation * record.missed_angular);
  }
  l.state = state;
  l.turned_in_a_row = 0;
  begin({&lane, 1}, dt);
  contacts->clear(lane);
  joints.aim({&lane, 1});
  for (int k = 0; k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
    std::fill_n(unknowns.data() + joints.row(j), joints.rows(j), 0.0);
    joints.prepare(j, 0, dt);
    joints.reset_coordinate(j);
  }
  l.start_correction = opening(lane, unknowns);
  l.start_energy_loss = 0;
  if (!state.half_kick && l.start_correction > settings.tolerance && led_by_a_step(lane)) l.start_correction = 0;
}

void Stepper::check_start(int lane) const {
  for (int k = 0; k < joints_per_lane; ++k) {
    const int j = joint(lane, k);
    const JointGeometry& g = joints.geometry(j);
    const auto [distance, angle] = joints.error(j, bodies.pose_now(g.parent), bodies.pose_now(g.child));
    const std::string& name = lanes[lane].mechanism.joints[g.source].name;
    const std::string place = fmt::format("joints[{}]", g.source);
    if (!(distance <= largest_start_error))
      throw DescriptionError(fmt::format("joint '{}': its points start {:.3g} m apart", name, distance), place);
    if (angle <= largest_start_error) continue;
    const auto frame = [&](const Pose& pose) { return Frame{pose.x, pose.q}; };
    const Joint rigid{.type = g.type, .axis = g.axis, .orientation = g.orientation};
    const double bent = bend(rigid, frame(bodies.pose_now(g.parent)), frame(bodies.pose_now(g.child)));  // not by its sine
    throw DescriptionError(fmt::format("joint '{}': its bodies start {:.3g} rad off their orientation", name, bent), place);
  }
}

}  // namespace physics
