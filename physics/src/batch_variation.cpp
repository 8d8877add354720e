#include "physics/batch_variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace physics {

namespace {

constexpr const char* known =
    "friction, CONTACT.friction, mass, BODY.mass, gravity, JOINT.stiffness, JOINT.damping, start.position.AXIS, "
    "start.velocity.AXIS, start.BODY.position.AXIS, start.BODY.velocity.AXIS, start.BODY.angular_velocity.AXIS";

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

/// The thing of that name, or an error that names the key.
template <class Things>
auto& find(Things& things, std::string_view name, std::string_view key, const char* kind) {
  const auto found = std::find_if(things.begin(), things.end(), [&](const auto& thing) { return thing.name == name; });
  if (found == things.end()) throw DescriptionError(fmt::format("vary '{}': the scene has no {} '{}'", key, kind, name));
  return *found;
}

/// Takes ".ending" off a text that has it; the rest may contain dots.
bool take_ending(std::string_view& text, std::string_view ending) {
  if (!text.ends_with(ending) || text.size() <= ending.size()) return false;
  const std::size_t rest = text.size() - ending.size();
  if (text[rest - 1] != '.') return false;
  text = text.substr(0, rest - 1);
  return true;
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

[[noreturn]] void unknown(std::string_view key) {
  throw DescriptionError(fmt::format("vary '{}': unknown key; there are: {}", key, known));
}

/// key without "start."
void set_start(Mechanism& mechanism, std::string_view key, std::string_view rest, double value) {
  int axis = -1;
  for (const int i : {0, 1, 2})
    if (axis < 0 && take_ending(rest, std::string_view("xyz").substr(i, 1))) axis = i;
  if (axis < 0) unknown(key);
  for (const auto& [name, member] : {std::pair{"position", &Body::position}, {"velocity", &Body::velocity}}) {
    if (rest != name) continue;
    for (Body& body : mechanism.bodies) (body.*member)[axis] += value;
    return;
  }
  for (const auto& [name, member] : {std::pair{"angular_velocity", &Body::angular_velocity},
                                     {"position", &Body::position}, {"velocity", &Body::velocity}}) {
    std::string_view body = rest;
    if (!take_ending(body, name)) continue;
    (find(mechanism.bodies, body, key, "body").*member)[axis] = value;
    return;
  }
  unknown(key);
}

void set_motor(Mechanism& mechanism, std::string_view joint_name, std::string_view key, double value) {
  Joint& joint = find(mechanism.joints, joint_name, key, "joint");
  if (!joint.motor) throw DescriptionError(fmt::format("vary '{}': joint '{}' has no motor", key, joint_name));
  (key.ends_with("stiffness") ? joint.motor->stiffness : joint.motor->damping) = value;
}

}  // namespace

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
      throw DescriptionError(fmt::format("vary '{}': the bound {} will not do: {}", variation.key, bound, error.what()));
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
  } else if (key.starts_with("start.")) {
    set_start(mechanism, key, key.substr(6), value);
  } else if (take_ending(rest, "friction")) {
    set_friction(find(mechanism.contacts, rest, key, "contact"), key, value);
  } else if (take_ending(rest, "mass")) {
    Body& body = find(mechanism.bodies, rest, key, "body");
    scale_mass(body, value / body.mass);
  } else if (take_ending(rest, "stiffness") || take_ending(rest, "damping")) {
    set_motor(mechanism, rest, key, value);
  } else {
    unknown(key);
  }
}

}  // namespace physics
