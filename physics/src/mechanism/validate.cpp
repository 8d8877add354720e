#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_set>

#include "mechanism/limits.hpp"
#include "physics/mechanism.hpp"

/// Every error is one sentence: the thing, the key, the value, and where it helps, what would do.
namespace physics {

namespace {

constexpr double unit_tolerance = 1e-6;     ///< vectors and quaternions this near to unit are normalised
constexpr double inertia_tolerance = 1e-9;  ///< relative; a flat disc lies on the triangle inequality
constexpr int most_directions = 1024;       ///< the cost of a contact grows with their square
constexpr double largest_friction = 1000;   ///< as in the built-in scenes; iterations run out where it wedges
constexpr double largest_turn = 1.9;        ///< |w| dt; the update of a quaternion ends at 2

/// A part of the scene: what errors call it, and where it stands in a scene file.
struct Thing {
  std::string name, place;
};

template <class... Arguments>
[[noreturn]] void fail_at(const std::string& place, fmt::format_string<Arguments...> text, Arguments&&... arguments) {
  throw DescriptionError(fmt::format(text, std::forward<Arguments>(arguments)...), place);
}

/// key: of the value, as in a scene file, "motor.target.phase"; empty: the thing as a whole.
template <class... Arguments>
[[noreturn]] void fail(const Thing& thing, std::string_view key, fmt::format_string<Arguments...> text,
                       Arguments&&... arguments) {
  const std::string_view dot = thing.place.empty() || key.empty() ? "" : ".";
  fail_at(fmt::format("{}{}{}", thing.place, dot, key), "{}: {}", thing.name,
          fmt::format(text, std::forward<Arguments>(arguments)...));
}

/// A key as a sentence has it, "motor target phase".
std::string words(std::string_view key) {
  std::string result(key);
  std::ranges::replace_if(result, [](char c) { return c == '.' || c == '_'; }, ' ');
  return result;
}

std::string text(const Vec3& v) { return fmt::format("({:g}, {:g}, {:g})", v.x(), v.y(), v.z()); }

void check_finite(const Thing& thing, std::string_view key, double value) {
  if (!std::isfinite(value)) fail(thing, key, "{} {} is not finite", words(key), value);
}
void check_finite(const Thing& thing, std::string_view key, const Vec3& value) {
  if (!value.allFinite()) fail(thing, key, "{} {} is not finite", words(key), text(value));
}
void check_positive(const Thing& thing, std::string_view key, double value, std::string_view unit) {
  if (!(value > 0)) fail(thing, key, "{} {} {} is not > 0", words(key), value, unit);
  if (std::isinf(value)) fail(thing, key, "{} {} {} is not finite", words(key), value, unit);
  if (!std::isnormal(value)) fail(thing, key, "{} {} {} is so small that its digits are lost", words(key), value, unit);
}
void check_not_negative(const Thing& thing, std::string_view key, double value) {
  if (!(value >= 0)) fail(thing, key, "{} {} is not >= 0", words(key), value);
  check_finite(thing, key, value);
}

/// Leaves what is unit to rounding alone, so that checking twice changes nothing.
template <class Vector>
void normalise(Vector& v, double length) {
  if (std::abs(length - 1) > 4 * std::numeric_limits<double>::epsilon()) v /= length;
}

void check_unit(const Thing& thing, std::string_view key, Quat& q) {
  if (!q.coeffs().allFinite()) fail(thing, key, "{} is not finite", key);
  const double length = q.coeffs().stableNorm();
  if (std::abs(length - 1) > unit_tolerance)
    fail(thing, key, "{} [{:g}, {:g}, {:g}, {:g}] has length {:.9g}, not 1", key, q.w(), q.x(), q.y(), q.z(), length);
  normalise(q.coeffs(), length);
}

void check_unit(const Thing& thing, std::string_view key, Vec3& v) {
  check_finite(thing, key, v);
  const double length = v.stableNorm();
  if (length == 0) fail(thing, key, "{} has length 0", key);
  if (std::abs(length - 1) > unit_tolerance)
    fail(thing, key, "{} {} has length {:.9g}, not 1", key, text(v), length);
  normalise(v, length);
}

/// One list of names: none empty, none twice.
class Names {
 public:
  Names(std::string_view one, std::string_view many) : one_(one), many_(many) {}
  void add(const std::string& name, std::size_t index) {
    const auto place = [&] { return fmt::format("{}[{}].name", many_, index); };
    if (name.empty()) fail_at(place(), "{} {} has no name", one_, index);
    if (!seen_.insert(name).second) fail_at(place(), "there are two {} called '{}'", many_, name);
  }

 private:
  std::string_view one_, many_;
  std::unordered_set<std::string_view> seen_;
};

void check_inertia(const Thing& thing, Mat3& inertia) {
  constexpr const char* key = "inertia";
  if (!inertia.allFinite()) fail(thing, key, "inertia is not finite");
  const double scale = inertia.cwiseAbs().maxCoeff();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < row; ++column) {
      const double lower = inertia(row, column), upper = inertia(column, row);
      if (std::abs(upper - lower) > inertia_tolerance * scale)
        fail(thing, key, "inertia is not symmetric ([{}][{}] is {:g}, [{}][{}] is {:g})", row, column, lower, column,
             row, upper);
      inertia(row, column) = inertia(column, row) = 0.5 * (upper + lower);
    }
  }
  // Moments of a diagonal matrix are read off, exact whatever their ratio; eigenvalues carry rounding.
  Vec3 moments = inertia.diagonal();
  double rounding = 0;
  if (!inertia.isDiagonal(0)) {
    moments = Eigen::SelfAdjointEigenSolver<Mat3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
    rounding = 4 * std::numeric_limits<double>::epsilon() * scale;
  }
  if (!(moments.minCoeff() > rounding))
    fail(thing, key, "inertia is not positive definite (principal moments {} kg m^2)", text(moments));
  if (!std::isnormal(moments.minCoeff()))
    fail(thing, key, "inertia is so small that its digits are lost (principal moments {} kg m^2)", text(moments));
  const double largest = moments.maxCoeff(), others = moments.sum() - largest;
  if (others < largest * (1 - inertia_tolerance))
    fail(thing, key,
         "inertia violates the triangle inequality (principal moments {} kg m^2: the smaller two add up to {:g})",
         text(moments), others);
}

void check_shape(const Thing& thing, const Shape& shape) {
  using enum Shape::Type;
  if (shape.type == sphere || shape.type == cylinder || shape.type == capsule)
    check_positive(thing, "shape.radius", shape.radius, "m");
  if (shape.type == cylinder || shape.type == capsule) check_positive(thing, "shape.height", shape.height, "m");
  if (shape.type == box && !(shape.size.allFinite() && shape.size.minCoeff() > 0))
    fail(thing, "shape.size", "shape size {} m is not > 0", text(shape.size));
  if (shape.type == mesh && shape.file.empty()) fail(thing, "shape.file", "shape file is empty");
}

/// Each of these would be infinite in the summary of a run, and so would all that follows.
void check_energy(const Thing& thing, const Body& body, const Vec3& gravity) {
  const auto told = [&](const char* key, const char* what, double value, const char* unit) {
    if (!(std::abs(value) <= largest_energy)) fail(thing, key, "{} is {:.3g} {}, more than {:g}", what, value, unit, largest_energy);
  };
  const double speed = body.velocity.stableNorm(), distance = body.position.stableNorm();
  told("velocity", "its kinetic energy", 0.5 * body.mass * speed * speed, "J");
  told("angular_velocity", "its energy of rotation", 0.5 * body.angular_velocity.dot(body.inertia * body.angular_velocity), "J");
  told("position", "its potential energy", body.mass * gravity.stableNorm() * distance, "J");
  told("position", "its angular momentum about the origin", body.mass * speed * distance, "N m s");
}

void check_body(Body& body, std::size_t index, double time_step, const Vec3& gravity) {
  const Thing thing{fmt::format("body '{}'", body.name), fmt::format("bodies[{}]", index)};
  check_positive(thing, "mass", body.mass, "kg");
  check_inertia(thing, body.inertia);
  check_finite(thing, "position", body.position);
  check_unit(thing, "orientation", body.orientation);
  check_finite(thing, "velocity", body.velocity);
  check_finite(thing, "angular_velocity", body.angular_velocity);
  const double spin = body.angular_velocity.stableNorm();
  if (!(spin * time_step < largest_turn))
    fail(thing, "angular_velocity", "spins at {:g} rad/s; |w| dt = {:g} must be < {}: use a time step below {:.3g} s",
         spin, spin * time_step, largest_turn, largest_turn / spin);
  check_shape(thing, body.shape);
  check_energy(thing, body, gravity);
}

/// Index of an existing body, or the world where that is allowed.
void check_body_id(const Mechanism& mechanism, const Thing& thing, std::string_view key, BodyId id) {
  if (id.index >= static_cast<int>(mechanism.bodies.size()))
    fail(thing, key, "{} {} is not a body (the scene has {}, counted from 0)", key, id.index, mechanism.bodies.size());
}

std::string_view name_of(JointType type) {
  switch (type) {
    case JointType::fixed:
      return "fixed";
    case JointType::revolute:
      return "revolute";
    case JointType::prismatic:
      return "prismatic";
    case JointType::spherical:
      return "spherical";
  }
  return "unknown";
}

void check_motor(const Thing& thing, const Motor& motor) {
  check_not_negative(thing, "motor.stiffness", motor.stiffness);
  check_not_negative(thing, "motor.damping", motor.damping);
  if (!(motor.limit > 0)) fail(thing, "motor.limit", "motor limit {} is not > 0", motor.limit);
  if (const auto* value = std::get_if<double>(&motor.target)) check_finite(thing, "motor.target", *value);
  if (const auto* sine = std::get_if<SineTarget>(&motor.target)) {
    check_finite(thing, "motor.target.offset", sine->offset);
    check_finite(thing, "motor.target.amplitude", sine->amplitude);
    check_finite(thing, "motor.target.frequency", sine->frequency);
    check_finite(thing, "motor.target.phase", sine->phase);
  }
  if (const auto* table = std::get_if<TableTarget>(&motor.target)) {
    if (table->empty()) fail(thing, "motor.target", "motor target is an empty table");
    for (std::size_t i = 0; i < table->size(); ++i) {
      const auto [time, value] = (*table)[i];
      const std::string row = fmt::format("motor.target[{}]", i);
      if (!std::isfinite(time)) fail(thing, row, "time {} of the motor target {} is not finite", i, time);
      if (!std::isfinite(value)) fail(thing, row, "value {} of the motor target {} is not finite", i, value);
      if (i > 0 && !(time > (*table)[i - 1].first))
        fail(thing, row, "times of the motor target do not increase (time {} is {:g} s after {:g} s)", i, time,
             (*table)[i - 1].first);
    }
  }
}

void check_joint(const Mechanism& mechanism, Joint& joint, std::size_t index) {
  const Thing thing{fmt::format("{} joint '{}'", name_of(joint.type), joint.name), fmt::format("joints[{}]", index)};
  check_body_id(mechanism, thing, "parent", joint.parent);
  check_body_id(mechanism, thing, "child", joint.child);
  if (joint.child.is_world()) fail(thing, "child", "child is the world, which can only be the parent");
  if (joint.parent == joint.child)
    fail(thing, "child", "connects body '{}' with itself", mechanism.bodies[joint.child.index].name);
  check_finite(thing, "parent_point", joint.parent_point);
  check_finite(thing, "child_point", joint.child_point);
  check_unit(thing, "orientation", joint.orientation);
  const bool has_axis = joint.type == JointType::revolute || joint.type == JointType::prismatic;
  check_finite(thing, "axis", joint.axis);
  if (has_axis) {
    const double length = joint.axis.stableNorm();
    if (length == 0) fail(thing, "axis", "axis has length 0");
    normalise(joint.axis, length);
  }
  if (!joint.motor) return;
  if (!has_axis) fail(thing, "motor", "has a motor, which only revolute and prismatic joints can have");
  check_motor(thing, *joint.motor);
}

/// Orthonormal to the normal, unless it already is.
void check_tangent(const Thing& thing, const Vec3& normal, Vec3& tangent) {
  check_finite(thing, "tangent", tangent);
  const double length = tangent.stableNorm();
  if (length == 0) fail(thing, "tangent", "tangent has length 0");
  normalise(tangent, length);
  const double along = tangent.dot(normal);
  if (1 - std::abs(along) < 1e-12)
    fail(thing, "tangent", "tangent {} is parallel to the normal {}", text(tangent), text(normal));
  if (std::abs(along) <= 4 * std::numeric_limits<double>::epsilon()) return;
  tangent -= along * normal;
  normalise(tangent, tangent.norm());
}

void check_contact(const Mechanism& mechanism, Contact& contact, std::size_t index) {
  const Thing thing{fmt::format("contact '{}'", contact.name), fmt::format("contacts[{}]", index)};
  check_body_id(mechanism, thing, "body", contact.body);
  if (contact.body.is_world()) fail(thing, "body", "body is the world, which nothing moves");
  check_finite(thing, "point", contact.point);
  check_unit(thing, "normal", contact.normal);
  check_finite(thing, "plane_point", contact.plane_point);
  if (contact.friction) check_not_negative(thing, "friction", *contact.friction);
  if (contact.friction > largest_friction)
    fail(thing, "friction", "friction {} is above {}, where nothing slides any more and solves fail", *contact.friction,
         largest_friction);
  if (contact.directions < 4 || contact.directions > most_directions || contact.directions % 2 != 0)
    fail(thing, "directions", "directions {} is not an even number from 4 to {}", contact.directions, most_directions);
  if (contact.tangent) check_tangent(thing, contact.normal, *contact.tangent);
  check_not_negative(thing, "radius", contact.radius);
}

void check_load(const Mechanism& mechanism, const Load& load, std::size_t index) {
  const Thing thing{fmt::format("load {}", index), fmt::format("loads[{}]", index)};
  check_body_id(mechanism, thing, "body", load.body);
  if (load.body.is_world()) fail(thing, "body", "body is the world, which nothing moves");
  if (load.first_step < 1)
    fail(thing, "steps[0]", "first step {} is not >= 1 (step 1 leads to record 1)", load.first_step);
  if (load.last_step < load.first_step)
    fail(thing, "steps[1]", "last step {} is before the first step {}", load.last_step, load.first_step);
  check_finite(thing, "force", load.force);
  check_finite(thing, "torque", load.torque);
}

}  // namespace

void validate(Mechanism& mechanism) {
  const Thing scene{"scene", ""};
  check_positive(scene, "time_step", mechanism.time_step, "s");
  check_finite(scene, "gravity", mechanism.gravity);
  Names bodies("body", "bodies"), joints("joint", "joints"), contacts("contact", "contacts");
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    Body& body = mechanism.bodies[i];
    bodies.add(body.name, i);
    if (body.name == "world")
      fail_at(fmt::format("bodies[{}].name", i), "body {} is called 'world', which is the name of the ground", i);
    check_body(body, i, mechanism.time_step, mechanism.gravity);
  }
  for (std::size_t i = 0; i < mechanism.joints.size(); ++i) {
    joints.add(mechanism.joints[i].name, i);
    check_joint(mechanism, mechanism.joints[i], i);
  }
  for (std::size_t i = 0; i < mechanism.contacts.size(); ++i) {
    contacts.add(mechanism.contacts[i].name, i);
    check_contact(mechanism, mechanism.contacts[i], i);
  }
  for (std::size_t i = 0; i < mechanism.loads.size(); ++i) check_load(mechanism, mechanism.loads[i], i);
}

}  // namespace physics
