#include <fmt/format.h>

#include <unordered_map>

#include "io/names.hpp"
#include "io/read.hpp"

namespace physics::io {

namespace {

/// Sets the value where the key is there, else leaves the default.
template <class Value>
void set(Object& object, const char* key, Value& value, Value (*read)(const Json&)) {
  if (const Json* json = object.optional(key)) value = read(*json);
}

class BodyNames {
 public:
  void add(const std::string& name, int index) { index_.emplace(name, index); }
  [[nodiscard]] BodyId find(const Json& json) const {
    const std::string& name = string(json);
    if (name == "world") return world;
    const auto found = index_.find(name);
    if (found == index_.end()) throw ReadError{&json, fmt::format("there is no body '{}'", name)};
    return {found->second};
  }

 private:
  std::unordered_map<std::string, int> index_;
};

Shape read_shape(const Json& json) {
  Object object(json);
  Shape shape;
  shape.type = choice(object.required("type"), shape_types);
  switch (shape.type) {
    case Shape::Type::sphere:
      shape.radius = number(object.required("radius"));
      break;
    case Shape::Type::box:
      shape.size = vec3(object.required("size"));
      break;
    case Shape::Type::cylinder:
    case Shape::Type::capsule:
      shape.radius = number(object.required("radius"));
      shape.height = number(object.required("height"));
      break;
    case Shape::Type::mesh:
      shape.file = string(object.required("file"));
      break;
    case Shape::Type::none:
      break;
  }
  object.finish();
  return shape;
}

Mat3 read_inertia(const Json& json) {
  if (json.is_array() && json.size() == 3 && json[0].is_array()) {
    Mat3 inertia;
    for (int row = 0; row < 3; ++row) inertia.row(row) = vec3(json[row]);
    return inertia;
  }
  if (!json.is_array() || json.size() != 3)
    throw ReadError{&json, "is neither 3 principal moments nor a 3x3 matrix (a list of 3 rows)"};
  return vec3(json).asDiagonal();
}

Body read_body(const Json& json) {
  Object object(json);
  Body body;
  body.name = string(object.required("name"));
  body.mass = number(object.required("mass"));
  if (const Json* shape = object.optional("shape")) body.shape = read_shape(*shape);
  if (const Json* inertia = object.optional("inertia")) {
    body.inertia = read_inertia(*inertia);
  } else {
    if (body.shape.type == Shape::Type::none || body.shape.type == Shape::Type::mesh)
      throw ReadError{&json, "key 'inertia' is missing (it can be left out with a shape that has a volume)"};
    body.inertia = shape_inertia(body.shape, body.mass);
  }
  set(object, "position", body.position, vec3);
  set(object, "orientation", body.orientation, quat);
  set(object, "velocity", body.velocity, vec3);
  set(object, "angular_velocity", body.angular_velocity, vec3);
  body.extras = object.finish();
  return body;
}

SineTarget read_sine(const Json& json) {
  Object object(json);
  SineTarget sine;
  set(object, "offset", sine.offset, number);
  set(object, "amplitude", sine.amplitude, number);
  set(object, "frequency", sine.frequency, number);
  set(object, "phase", sine.phase, number);
  object.finish();
  return sine;
}

Motor read_motor(const Json& json) {
  Object object(json);
  Motor motor;
  set(object, "stiffness", motor.stiffness, number);
  set(object, "damping", motor.damping, number);
  set(object, "limit", motor.limit, number);
  if (const Json* target = object.optional("target")) {
    if (target->is_object()) {
      motor.target = read_sine(*target);
    } else if (target->is_array()) {
      TableTarget table;
      for (const Json& row : *target) {
        list(row, 2);
        table.emplace_back(number(row[0]), number(row[1]));
      }
      motor.target = std::move(table);
    } else {
      motor.target = number(*target);
    }
  }
  object.finish();
  return motor;
}

Joint read_joint(const Json& json, const BodyNames& names) {
  Object object(json);
  Joint joint;
  joint.name = string(object.required("name"));
  joint.type = choice(object.required("type"), joint_types);
  joint.parent = names.find(object.required("parent"));
  joint.child = names.find(object.required("child"));
  set(object, "parent_point", joint.parent_point, vec3);
  set(object, "child_point", joint.child_point, vec3);
  if (has_axis(joint.type)) {
    joint.axis = vec3(object.required("axis"));
  } else {
    set(object, "axis", joint.axis, vec3);
  }
  set(object, "orientation", joint.orientation, quat);
  if (const Json* motor = object.optional("motor")) joint.motor = read_motor(*motor);
  joint.extras = object.finish();
  return joint;
}

Contact read_contact(const Json& json, const BodyNames& names) {
  Object object(json);
  Contact contact;
  contact.name = string(object.required("name"));
  contact.body = names.find(object.required("body"));
  set(object, "point", contact.point, vec3);
  set(object, "normal", contact.normal, vec3);
  set(object, "plane_point", contact.plane_point, vec3);
  if (const Json* friction = object.optional("friction")) contact.friction = number(*friction);
  if (const Json* model = object.optional("friction_model")) {
    if (model->is_string() && string(*model) == "cone")
      throw ReadError{model, "'cone' is reserved but not built yet; use 'aligned', which comes closest to it"};
    contact.friction_model = choice(*model, friction_models);
  }
  set(object, "directions", contact.directions, integer);
  if (const Json* tangent = object.optional("tangent")) contact.tangent = vec3(*tangent);
  set(object, "radius", contact.radius, number);
  contact.extras = object.finish();
  return contact;
}

Load read_load(const Json& json, const BodyNames& names) {
  Object object(json);
  Load load;
  load.body = names.find(object.required("body"));
  const Json& steps = list(object.required("steps"), 2);
  load.first_step = integer(steps[0]);
  load.last_step = integer(steps[1]);
  set(object, "force", load.force, vec3);
  set(object, "torque", load.torque, vec3);
  object.finish();
  return load;
}

void check_format(Object& file) {
  const Json& format = file.required("format");
  if (string(format) != format_name)
    throw ReadError{&format, fmt::format("is '{}', expected '{}'", string(format), format_name)};
  const Json& version = file.required("version");
  if (integer(version) != format_version)
    throw ReadError{&version, fmt::format("is {}, this program reads version {}", integer(version), format_version)};
}

}  // namespace

void read_mechanism(Object& file, Mechanism& mechanism) {
  check_format(file);
  set<std::string>(file, "name", mechanism.name, [](const Json& json) { return string(json); });
  mechanism.time_step = number(file.required("time_step"));
  set(file, "gravity", mechanism.gravity, vec3);
  if (const Json* start = file.optional("start")) mechanism.start = choice(*start, starts);
  BodyNames names;
  for (const Json& json : list(file.required("bodies"))) {
    Body body = read_body(json);
    names.add(body.name, static_cast<int>(mechanism.bodies.size()));
    mechanism.add(std::move(body));
  }
  if (const Json* joints = file.optional("joints"))
    for (const Json& joint : list(*joints)) mechanism.add(read_joint(joint, names));
  if (const Json* contacts = file.optional("contacts"))
    for (const Json& contact : list(*contacts)) mechanism.add(read_contact(contact, names));
  if (const Json* loads = file.optional("loads"))
    for (const Json& load : list(*loads)) mechanism.add(read_load(load, names));
}

}  // namespace physics::io
