#include <cmath>
#include <numbers>

#include "batch/variation_keys.hpp"
#include "mechanism/start_pose.hpp"
#include "physics/batch_variation.hpp"

/// Keys of what a scene starts with.
namespace physics {

namespace {

Quat turn_about(const Vec3& axis, double angle) { return Quat(Eigen::AngleAxisd(angle, axis)); }

/// With all that is joined to it, about its centre of mass. Its own velocity stays what it is in the world, and the
/// others' relative to it turn along.
void turn_body(Mechanism& mechanism, std::string_view key, const Body& body, const Vec3& axis, double angle) {
  const BodyId id{static_cast<int>(&body - mechanism.bodies.data())};
  const Side side = side_of(mechanism, id, -1);
  if (side.held)
    wrong_key(key, "joints hold body '{}' at the world, and a turn would open them: vary start.JOINT.angle", body.name);
  const RigidMotion own = {.origin = body.position, .velocity = body.velocity, .angular_velocity = Vec3::Zero()};
  displace(mechanism, side.bodies, {.turn = turn_about(axis, angle), .pivot = body.position, .shift = Vec3::Zero()},
           own);
}

/// A joint at the start, and the bodies that go along when its child moves against its parent, or these against those.
struct JointStart {
  Quat parent = Quat::Identity();  ///< frame of the parent, to the world
  Vec3 parent_point, child_point;  ///< world
  RigidMotion parent_motion, child_motion;
  std::vector<int> bodies;
  double sign = 1;  ///< -1: the bodies are those of the parent's side
};

/// Throws where neither side is free to move.
JointStart joint_start(const Mechanism& mechanism, std::string_view key, const Joint& joint) {
  JointStart start;
  const auto point = [&](BodyId id, const Vec3& local) {
    if (id.is_world()) return local;
    const Body& body = mechanism.bodies[id.index];
    return Vec3(body.position + body.orientation * local);
  };
  if (!joint.parent.is_world()) start.parent = mechanism.bodies[joint.parent.index].orientation;
  start.parent_point = point(joint.parent, joint.parent_point);
  start.child_point = point(joint.child, joint.child_point);
  start.parent_motion = start_motion(mechanism, joint.parent);
  start.child_motion = start_motion(mechanism, joint.child);
  const int index = static_cast<int>(&joint - mechanism.joints.data());
  Side child = side_of(mechanism, joint.child, index), parent = side_of(mechanism, joint.parent, index);
  if (child.has(joint.parent) || (child.held && parent.held))
    wrong_key(key, "joint '{}' is part of a closed loop, which another start would open", joint.name);
  start.sign = child.held ? -1 : 1;
  start.bodies = std::move((child.held ? parent : child).bodies);
  return start;
}

double angle_of(const Mechanism& mechanism, const Joint& joint, const Quat& parent) {
  const Quat e = parent.conjugate() * mechanism.bodies[joint.child.index].orientation * joint.orientation.conjugate();
  return 2 * std::atan2(joint.axis.normalized().dot(e.vec()), e.w());
}

/// Turns or shifts one side of the joint against the other.
void move_joint(Mechanism& mechanism, const JointStart& start, const Vec3& axis, double angle, double travel) {
  const bool child = start.sign > 0;
  displace(mechanism, start.bodies,
           {.turn = turn_about(axis, start.sign * angle),
            .pivot = child ? start.parent_point : start.child_point,
            .shift = start.sign * travel * axis},
           child ? start.parent_motion : start.child_motion);
}

/// Makes the rate of the joint along this axis (world) the given one.
void set_rate(Mechanism& mechanism, const JointStart& start, const Vec3& axis, bool slides, double rate) {
  const RigidMotion &parent = start.parent_motion, &child = start.child_motion;
  const double now = slides ? axis.dot(child.at(start.child_point) - parent.at(start.child_point))
                            : axis.dot(child.angular_velocity - parent.angular_velocity);
  const Vec3 change = start.sign * (rate - now) * axis;
  const Vec3 none = Vec3::Zero();
  add_motion(
      mechanism, start.bodies,
      {.origin = start.child_point, .velocity = slides ? change : none, .angular_velocity = slides ? none : change});
}

enum class Quantity { angle, travel, rate };

/// start.JOINT.angle, .travel, .rate; of spherical joints with an axis 0, 1, 2.
void set_joint_start(Mechanism& mechanism, std::string_view key, std::string_view name, Quantity quantity, int axis,
                     double value) {
  const Joint& joint = find(mechanism.joints, name, key, "joint");
  const bool slides = joint.type == JointType::prismatic, ball = joint.type == JointType::spherical;
  if (joint.type == JointType::fixed) wrong_key(key, "joint '{}' is fixed", name);
  if (quantity == Quantity::angle && slides)
    wrong_key(key, "joint '{}' is prismatic: vary start.{}.travel", name, name);
  if (quantity == Quantity::travel && !slides)
    wrong_key(key, "joint '{}' is not prismatic: vary start.{}.angle", name, name);
  if (ball && axis < 0) wrong_key(key, "joint '{}' is spherical: the key needs an axis, as in {}.x", name, key);
  if (!ball && axis >= 0) wrong_key(key, "joint '{}' has one axis: leave out .{}", name, "xyz"[axis]);
  const JointStart start = joint_start(mechanism, key, joint);
  const Vec3 direction = start.parent * (ball ? Vec3(Vec3::Unit(axis)) : Vec3(joint.axis.normalized()));
  if (quantity == Quantity::rate) return set_rate(mechanism, start, direction, slides, value);
  if (slides)
    return move_joint(mechanism, start, direction, 0, value - direction.dot(start.child_point - start.parent_point));
  if (ball) return move_joint(mechanism, start, direction, value, 0);
  // Poses know no full turns: another angle would be taken for this one less some of them, by its motor too.
  if (!(std::abs(value) <= std::numbers::pi))
    throw DescriptionError(fmt::format("joint '{}': start angle {} rad is not from -pi to pi", name, value));
  move_joint(mechanism, start, direction, value - angle_of(mechanism, joint, start.parent), 0);
}

/// start.position.AXIS and the like, of all bodies or of one. False: the key is none of these.
bool set_body_start(Mechanism& mechanism, std::string_view key, std::string_view rest, int axis, double value) {
  for (const auto& [name, member] : {std::pair{"position", &Body::position}, {"velocity", &Body::velocity}}) {
    if (rest != name) continue;
    for (Body& body : mechanism.bodies) (body.*member)[axis] += value;
    return true;
  }
  for (const auto& [name, member] : {std::pair{"angular_velocity", &Body::angular_velocity},
                                     {"position", &Body::position}, {"velocity", &Body::velocity}}) {
    std::string_view body = rest;
    if (!take_ending(body, name)) continue;
    (find(mechanism.bodies, body, key, "body").*member)[axis] = value;
    return true;
  }
  if (!take_ending(rest, "rotation")) return false;
  turn_body(mechanism, key, find(mechanism.bodies, rest, key, "body"), Vec3::Unit(axis), value);
  return true;
}

}  // namespace

namespace {

/// What moves it and opens nothing.
std::string own_key_of(const Joint& joint) {
  switch (joint.type) {
    case JointType::fixed: break;
    case JointType::revolute: return fmt::format(": vary start.{}.angle", joint.name);
    case JointType::prismatic: return fmt::format(": vary start.{}.travel", joint.name);
    case JointType::spherical: return fmt::format(": vary start.{}.angle.x, .y or .z", joint.name);
  }
  return {};
}

}  // namespace

void check_start(const Mechanism& mechanism, std::span<const Variation> variations, std::span<const double> values) {
  constexpr int nobody = -1;
  Mechanism copy = mechanism;
  std::vector<int> opened(copy.joints.size(), nobody);
  // More than they are: of what fixed joints hold, a scene may leave the positions out.
  std::vector<double> usual;
  for (const Joint& joint : mechanism.joints) usual.push_back(start_gap(mechanism, joint));
  const auto is_open = [&](std::size_t j) { return start_gap(copy, copy.joints[j]) > usual[j] + largest_start_error; };
  for (std::size_t i = 0; i < variations.size(); ++i) {
    set_value(copy, variations[i].key, values[i]);
    for (std::size_t j = 0; j < copy.joints.size(); ++j)
      opened[j] = !is_open(j) ? nobody : opened[j] == nobody ? static_cast<int>(i) : opened[j];
  }
  for (std::size_t j = 0; j < copy.joints.size(); ++j) {
    if (opened[j] == nobody) continue;
    const Joint& joint = copy.joints[j];
    const auto name = [&](BodyId id) {
      return id.is_world() ? "the world" : fmt::format("body '{}'", copy.bodies[id.index].name);
    };
    wrong_key(variations[opened[j]].key, "joint '{}' holds {} at {}, and their points would start {:.3g} m apart{}",
              joint.name, name(joint.child), name(joint.parent), start_gap(copy, joint), own_key_of(joint));
  }
}

void set_start(Mechanism& mechanism, std::string_view key, double value) {
  std::string_view rest = key.substr(std::string_view("start.").size());
  const int axis = take_axis(rest);
  if (axis >= 0 && set_body_start(mechanism, key, rest, axis, value)) return;
  for (const auto& [name, quantity] :
       {std::pair{"angle", Quantity::angle}, {"travel", Quantity::travel}, {"rate", Quantity::rate}})
    if (take_ending(rest, name)) return set_joint_start(mechanism, key, rest, quantity, axis, value);
  unknown_key(key);
}

}  // namespace physics
