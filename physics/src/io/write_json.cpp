#include <fmt/format.h>

#include <array>
#include <cmath>

#include "io/document.hpp"
#include "io/names.hpp"
#include "io/write.hpp"

namespace physics::io {

namespace {

/// By trying: the error that the whole document gives names a byte, and whose it is would have to be tried all the
/// same. Text is in scenes; the record of a step holds one word.
bool is_utf8(const Json& text) {
  try {
    (void)text.dump();
  } catch (const Json::type_error&) {
    return false;
  }
  return true;
}

/// First value, at any depth, that JSON cannot say: a number that is not finite, text that is not UTF-8.
const Json* unspeakable(const Json& json) {
  if (json.is_number_float()) return std::isfinite(json.get<double>()) ? nullptr : &json;
  if (json.is_string()) return is_utf8(json) ? nullptr : &json;
  if (json.is_structured())
    for (const Json& child : json)
      if (const Json* found = unspeakable(child)) return found;
  return nullptr;
}

/// The library writes a double in the shortest form that reads back as the same bits (at most 17 digits), always
/// with a point or an exponent, so that -0.0 keeps its sign. What it would replace, here "null" and there another name,
/// is an error; where() says of what.
template <class Where>
std::string dump(const Json& json, const Where& where) {
  if (const Json* wrong = unspeakable(json)) {
    const std::string path = text(path_to(json, *wrong));
    const bool number = wrong->is_number_float();
    throw DescriptionError(fmt::format(
        "cannot write {}{}{}: {} is not {}", where(), path.empty() || path.starts_with('[') ? "" : ".", path,
        number ? fmt::format("{}", wrong->get<double>()) : wrong->dump(-1, ' ', true, Json::error_handler_t::replace),
        number ? "finite" : "UTF-8"));
  }
  return json.dump();
}
std::string dump(const Json& json, const char* key) {
  return dump(json, [key] { return key; });
}

Json to_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Json to_json(const Quat& q) { return {q.w(), q.x(), q.y(), q.z()}; }
Json to_json(const Mat3& inertia) {
  const bool principal = Mat3(inertia.diagonal().asDiagonal()) == inertia;
  if (principal) return to_json(Vec3(inertia.diagonal()));
  return {to_json(Vec3(inertia.row(0))), to_json(Vec3(inertia.row(1))), to_json(Vec3(inertia.row(2)))};
}

void add(Json& object, const Extras& extras) {
  for (const auto& [key, value] : extras) {
    (void)dump(key, "a key");  // what is said of values does not look at keys
    object[key] = Json::parse(value, nullptr, false);
    if (object[key].is_discarded()) throw DescriptionError(fmt::format("extra '{}': {} is not JSON", key, value));
  }
}

Json to_json(const Shape& shape) {
  Json json{{"type", word(shape.type, shape_types)}};
  switch (shape.type) {
    case Shape::Type::sphere:
      json["radius"] = shape.radius;
      break;
    case Shape::Type::box:
      json["size"] = to_json(shape.size);
      break;
    case Shape::Type::cylinder:
    case Shape::Type::capsule:
      json["radius"] = shape.radius;
      json["height"] = shape.height;
      break;
    case Shape::Type::mesh:
      json["file"] = shape.file;
      break;
    case Shape::Type::none:
      break;
  }
  return json;
}

Json to_json(const Body& body) {
  Json json{{"name", body.name},
            {"mass", body.mass},
            {"inertia", to_json(body.inertia)},
            {"position", to_json(body.position)},
            {"orientation", to_json(body.orientation)},
            {"velocity", to_json(body.velocity)},
            {"angular_velocity", to_json(body.angular_velocity)}};
  if (body.shape.type != Shape::Type::none) json["shape"] = to_json(body.shape);
  add(json, body.extras);
  return json;
}

Json to_json(const Motor& motor) {
  Json json{{"stiffness", motor.stiffness}, {"damping", motor.damping}};
  if (motor.limit < std::numeric_limits<double>::infinity()) json["limit"] = motor.limit;
  Json& target = json["target"];
  if (const auto* value = std::get_if<double>(&motor.target)) target = *value;
  if (const auto* sine = std::get_if<SineTarget>(&motor.target)) {
    target = {{"offset", sine->offset},
              {"amplitude", sine->amplitude},
              {"frequency", sine->frequency},
              {"phase", sine->phase}};
  }
  if (const auto* table = std::get_if<TableTarget>(&motor.target)) {
    target = Json::array();
    for (const auto& [time, value] : *table) target.push_back(std::array{time, value});
  }
  return json;
}

class Writer {
 public:
  explicit Writer(const Mechanism& mechanism) : mechanism_(mechanism) {}

  Json to_json(const Joint& joint) const {
    Json json{{"name", joint.name},
              {"type", word(joint.type, joint_types)},
              {"parent", name(joint.parent)},
              {"child", name(joint.child)},
              {"parent_point", io::to_json(joint.parent_point)},
              {"child_point", io::to_json(joint.child_point)}};
    if (has_axis(joint.type)) json["axis"] = io::to_json(joint.axis);
    json["orientation"] = io::to_json(joint.orientation);
    if (joint.motor) json["motor"] = io::to_json(*joint.motor);
    add(json, joint.extras);
    return json;
  }

  Json to_json(const Contact& contact) const {
    Json json{{"name", contact.name},
              {"body", name(contact.body)},
              {"point", io::to_json(contact.point)},
              {"normal", io::to_json(contact.normal)},
              {"plane_point", io::to_json(contact.plane_point)}};
    if (contact.friction) json["friction"] = *contact.friction;
    json["friction_model"] = word(contact.friction_model, friction_models);
    json["directions"] = contact.directions;
    if (contact.tangent) json["tangent"] = io::to_json(*contact.tangent);
    if (contact.radius != 0) json["radius"] = contact.radius;
    add(json, contact.extras);
    return json;
  }

  Json to_json(const Load& load) const {
    return {{"body", name(load.body)},
            {"steps", {load.first_step, load.last_step}},
            {"force", io::to_json(load.force)},
            {"torque", io::to_json(load.torque)}};
  }

 private:
  [[nodiscard]] std::string name(BodyId id) const {
    if (id.is_world()) return "world";
    if (id.index >= static_cast<int>(mechanism_.bodies.size()))
      throw DescriptionError(fmt::format("cannot write body {}: the scene has {}, counted from 0", id.index,
                                         mechanism_.bodies.size()));
    return mechanism_.bodies[id.index].name;
  }
  const Mechanism& mechanism_;
};

/// One entry of a list per line: readable, and lines of a diff are things of the scene.
template <class List, class ToJson>
std::string lines(const char* key, const List& list, const ToJson& to_json) {
  std::string text = fmt::format(",\n  \"{}\": [", key);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto where = [&] { return fmt::format("{}[{}]", key, i); };
    text += (i ? ",\n    " : "\n    ") + dump(to_json(list[i]), where);
  }
  return text + (list.empty() ? "]" : "\n  ]");
}

/// The scene without the bracket that ends it.
std::string open_scene(const Mechanism& mechanism) {
  std::string text = fmt::format("{{\n  \"format\": {}, \"version\": {}, \"name\": {},\n", dump(format_name, "format"),
                                 format_version, dump(mechanism.name, "name"));
  text += fmt::format("  \"time_step\": {}, \"gravity\": {}, \"start\": {}", dump(mechanism.time_step, "time_step"),
                      dump(to_json(mechanism.gravity), "gravity"), dump(word(mechanism.start, starts), "start"));
  Json extras = Json::object();
  add(extras, mechanism.extras);
  for (const auto& item : extras.items())
    text += fmt::format(",\n  {}: {}", dump(item.key(), "a key"), dump(item.value(), item.key().c_str()));
  const Writer writer(mechanism);
  const auto to_json = [&writer](const auto& thing) { return writer.to_json(thing); };
  text += lines("bodies", mechanism.bodies, [](const Body& body) { return io::to_json(body); });
  text += lines("joints", mechanism.joints, to_json);
  text += lines("contacts", mechanism.contacts, to_json);
  if (!mechanism.loads.empty()) text += lines("loads", mechanism.loads, to_json);
  return text;
}

Json to_json(const ContactRecord& contact) {
  Json json{{"distance", contact.distance},
            {"normal_force", contact.normal_force},
            {"friction_force", to_json(contact.friction_force)}};
  if (!contact.facet_forces.empty()) json["facet_forces"] = contact.facet_forces;
  if (contact.tangent) json["tangent"] = to_json(*contact.tangent);
  return json;
}

Json to_json(const JointRecord& joint) {
  Json json{{"force", to_json(joint.force)}, {"torque", to_json(joint.torque)}, {"error", joint.error}};
  if (joint.effort) json["effort"] = *joint.effort;
  if (joint.coordinate) json["coordinate"] = *joint.coordinate;
  if (joint.rate) json["rate"] = *joint.rate;
  return json;
}

Json to_json(const SolverRecord& solver) {
  Json json{{"status", solver.status},
            {"iterations", solver.iterations},
            {"residual", solver.residual},
            {"substeps", solver.substeps}};
  if (solver.new_force_direction) json["new_force_direction"] = true;
  return json;
}

Json to_json(const BodyRecord& body) {
  Json json{{"position", to_json(body.position)},
            {"orientation", to_json(body.orientation)},
            {"velocity", to_json(body.velocity)},
            {"angular_velocity", to_json(body.angular_velocity)}};
  if (!body.missed.isZero(0) || !body.missed_angular.isZero(0)) {
    json["missed"] = to_json(body.missed);
    json["missed_angular"] = to_json(body.missed_angular);
  }
  return json;
}

}  // namespace

std::string json_scene(const Mechanism& mechanism) { return open_scene(mechanism) + "\n}\n"; }

std::string json_header(const Mechanism& mechanism) { return open_scene(mechanism) + ",\n  \"steps\": [\n"; }

std::string json_step(const StepRecord& record) {
  Json json{{"step", record.step}, {"time", record.time}};
  add(json, record.extras);
  Json& bodies = json["bodies"] = Json::array();
  for (const BodyRecord& body : record.bodies) bodies.push_back(to_json(body));
  Json& contacts = json["contacts"] = Json::array();
  for (const ContactRecord& contact : record.contacts) contacts.push_back(to_json(contact));
  if (!record.joints.empty()) {
    Json& joints = json["joints"] = Json::array();
    for (const JointRecord& joint : record.joints) joints.push_back(to_json(joint));
  }
  if (record.solver) json["solver"] = to_json(*record.solver);
  return "    " + dump(json, [&] { return fmt::format("record {}", record.step); });
}

std::string json_end(const std::optional<FailureRecord>& failure) {
  std::string text = "\n  ]";
  if (failure) {
    const Json json{
        {"step", failure->step}, {"status", failure->status}, {"place", failure->place}, {"cause", failure->cause}};
    text += ",\n  \"failure\": " + dump(json, "failure");
  }
  return text + "\n}\n";
}

}  // namespace physics::io
