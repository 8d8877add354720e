#include "physics/batch_variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "batch/variation_keys.hpp"

namespace physics {

namespace {

constexpr const char* known =
    "friction, CONTACT.friction, mass, BODY.mass, gravity, BODY.force.AXIS, BODY.torque.AXIS (with @FIRST-LAST: in "
    "these steps), loads, BODY.loads, JOINT.stiffness, JOINT.damping, JOINT.limit, JOINT.target, "
    "JOINT.target.offset|amplitude|frequency|phase, start.position.AXIS, start.velocity.AXIS, "
    "start.BODY.position.AXIS, start.BODY.velocity.AXIS, start.BODY.angular_velocity.AXIS, start.BODY.rotation.AXIS, "
    "start.JOINT.angle, start.JOINT.travel, start.JOINT.rate, start.JOINT.angle.AXIS, start.JOINT.rate.AXIS";

std::uint64_t mix(std::uint64_t z) {  // Steele, Lea, Flood 2014
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

std::uint64_t hash(std::string_view text) {
  std::uint64_t value = 14695981039346656037u;
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return value;
}

double number(std::string_view text, std::string_view whole) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw DescriptionError(fmt::format("vary '{}': '{}' is not a number", whole, text));
  return value;
}

void set_friction(Contact& contact, std::string_view key, double value) {
  if (!(contact.friction.value_or(0) > 0))
    throw DescriptionError(fmt::format("vary '{}': contact '{}' has no friction to vary", key, contact.name));
  // Without friction a contact is another law.
  if (!(value > 0))
    throw DescriptionError(fmt::format("contact '{}': friction {} is not > 0; take a small coefficient, such as 1e-6 "
                                       "(without any, a contact is another law, and all copies share one)",
                                       contact.name, value));
  contact.friction = value;
}

void scale_mass(Body& body, double factor) {
  body.mass *= factor;
  body.inertia *= factor;
}

/// Steps of a load.
struct Steps {
  int first = 1, last = std::numeric_limits<int>::max();
};

/// Takes "@FIRST-LAST" off a text that has it.
Steps take_steps(std::string_view& text, std::string_view key) {
  const std::size_t at = text.rfind('@');
  if (at == text.npos || at < text.rfind('.')) return {};  // of a name
  Steps steps;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data() + at + 1, end, steps.first);
  const bool dash = first.ec == std::errc() && first.ptr != end && *first.ptr == '-';
  const auto last = dash ? std::from_chars(first.ptr + 1, end, steps.last) : first;
  if (!dash || last.ec != std::errc() || last.ptr != end || steps.first < 1 || steps.last < steps.first)
    wrong_key(key, "'{}' is not @FIRST-LAST with steps 1 <= FIRST <= LAST", text.substr(at));
  text = text.substr(0, at);
  return steps;
}

/// BODY.force.AXIS and BODY.torque.AXIS. False: the key is none of these.
bool add_load(Mechanism& mechanism, std::string_view key, double value) {
  std::string_view rest = key;
  const Steps steps = take_steps(rest, key);
  const int axis = take_axis(rest);
  const bool force = axis >= 0 && take_ending(rest, "force");
  if (axis < 0 || !(force || take_ending(rest, "torque"))) return false;
  const Body& body = find(mechanism.bodies, rest, key, "body");
  Load load{
      .body = {static_cast<int>(&body - mechanism.bodies.data())}, .first_step = steps.first, .last_step = steps.last};
  (force ? load.force : load.torque)[axis] = value;
  mechanism.add(load);
  return true;
}

/// Of this body, or of all where there is none.
void scale_loads(Mechanism& mechanism, std::string_view key, const Body* body, double factor) {
  bool any = false;
  for (Load& load : mechanism.loads) {
    if (body && &mechanism.bodies[load.body.index] != body) continue;
    load.force *= factor;
    load.torque *= factor;
    any = true;
  }
  if (any) return;
  if (body) wrong_key(key, "the scene has no load on body '{}': vary {}.force.x to add one", body->name, body->name);
  wrong_key(key, "the scene has no loads: vary BODY.force.x to add one");
}

constexpr std::pair<std::string_view, double SineTarget::*> of_sine[] = {{"offset", &SineTarget::offset},
                                                                        {"amplitude", &SineTarget::amplitude},
                                                                        {"frequency", &SineTarget::frequency},
                                                                        {"phase", &SineTarget::phase}};
constexpr std::pair<std::string_view, double Motor::*> of_motor[] = {
    {"stiffness", &Motor::stiffness}, {"damping", &Motor::damping}, {"limit", &Motor::limit}};

Motor& motor_of(Mechanism& mechanism, std::string_view joint_name, std::string_view key) {
  Joint& joint = find(mechanism.joints, joint_name, key, "joint");
  if (!joint.motor) wrong_key(key, "joint '{}' has no motor", joint_name);
  return *joint.motor;
}

/// JOINT.stiffness, JOINT.target and the like. False: the key is none of these.
bool set_motor(Mechanism& mechanism, std::string_view key, double value) {
  std::string_view joint = key;
  for (const auto& [name, member] : of_motor)
    if (take_ending(joint, name)) return motor_of(mechanism, joint, key).*member = value, true;
  if (take_ending(joint, "target")) {
    auto& target = motor_of(mechanism, joint, key).target;
    if (std::holds_alternative<SineTarget>(target))
      wrong_key(key, "the target of joint '{}' is a sine: vary {}.offset, .amplitude, .frequency or .phase", joint,
                key);
    if (std::holds_alternative<TableTarget>(target)) wrong_key(key, "the target of joint '{}' is a table", joint);
    return target = value, true;
  }
  for (const auto& [name, member] : of_sine) {
    joint = key;
    if (!take_ending(joint, name) || !take_ending(joint, "target")) continue;
    auto* sine = std::get_if<SineTarget>(&motor_of(mechanism, joint, key).target);
    if (!sine) wrong_key(key, "the target of joint '{}' is no sine", joint);
    return sine->*member = value, true;
  }
  return false;
}

}  // namespace

void unknown_key(std::string_view key) { wrong_key(key, "unknown key; there are: {}", known); }

Variation parse_variation(std::string_view text) {
  const std::size_t equals = text.rfind('='), colon = text.find(':', equals == text.npos ? 0 : equals);
  if (equals == text.npos || equals == 0 || colon == text.npos)
    throw DescriptionError(fmt::format("vary '{}' is not KEY=LOW:HIGH", text));
  Variation variation{.key = std::string(text.substr(0, equals)),
                      .low = number(text.substr(equals + 1, colon - equals - 1), text),
                      .high = number(text.substr(colon + 1), text)};
  if (!(variation.low <= variation.high)) throw DescriptionError(fmt::format("vary '{}': low is above high", text));
  return variation;
}

double uniform(std::uint64_t seed, long long copy, std::string_view key) {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15u;
  const std::uint64_t stream = mix(mix(seed + golden) ^ hash(key));
  return static_cast<double>(mix(stream + golden * (static_cast<std::uint64_t>(copy) + 1)) >> 11) * 0x1p-53;
}

std::vector<double> draw(std::span<const Variation> variations, std::uint64_t seed, long long copy) {
  std::vector<double> values;
  for (const Variation& v : variations) values.push_back(v.low + (v.high - v.low) * uniform(seed, copy, v.key));
  return values;
}

void check_variation(const Mechanism& mechanism, const Variation& variation) {
  for (const double bound : {variation.low, variation.high}) {
    Mechanism copy = mechanism;
    try {
      set_value(copy, variation.key, bound);
      validate(copy);
    } catch (const DescriptionError& error) {
      if (std::string_view(error.what()).starts_with("vary ")) throw;  // the key, not the value
      throw DescriptionError(
          fmt::format("vary '{}': the bound {} will not do: {}", variation.key, bound, error.what()));
    }
  }
}

void set_value(Mechanism& mechanism, std::string_view key, double value) {
  std::string_view rest = key;
  if (key == "friction") {
    bool any = false;
    for (Contact& contact : mechanism.contacts)
      if (contact.friction.value_or(0) > 0) set_friction(contact, key, value), any = true;
    if (!any) throw DescriptionError("vary 'friction': no contact of the scene has friction");
  } else if (key == "mass") {
    for (Body& body : mechanism.bodies) scale_mass(body, value);
  } else if (key == "gravity") {
    const double now = mechanism.gravity.norm();
    if (!(now > 0)) throw DescriptionError("vary 'gravity': the scene has none, so it has no direction");
    if (!(value >= 0)) throw DescriptionError(fmt::format("scene: gravity {} m/s^2 is not >= 0", value));
    mechanism.gravity *= value / now;
  } else if (key == "loads") {
    scale_loads(mechanism, key, nullptr, value);
  } else if (key.starts_with("start.")) {
    set_start(mechanism, key, value);
  } else if (take_ending(rest, "friction")) {
    set_friction(find(mechanism.contacts, rest, key, "contact"), key, value);
  } else if (take_ending(rest, "mass")) {
    Body& body = find(mechanism.bodies, rest, key, "body");
    scale_mass(body, value / body.mass);
  } else if (take_ending(rest, "loads")) {
    scale_loads(mechanism, key, &find(mechanism.bodies, rest, key, "body"), value);
  } else if (!set_motor(mechanism, key, value) && !add_load(mechanism, key, value)) {
    unknown_key(key);
  }
}

}  // namespace physics
