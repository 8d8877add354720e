#include "support/reference_files.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace reference {

namespace {

// A reader of its own, for just what these files hold, so that judging them does not rest on the library's reader.
using nlohmann::json;
using physics::Vec3;

double number(const json& j, int i) { return j.at(i).get<double>(); }

Vec3 vec3(const json& j) { return {number(j, 0), number(j, 1), number(j, 2)}; }

physics::Quat quat(const json& j) { return {number(j, 0), number(j, 1), number(j, 2), number(j, 3)}; }

physics::BodyId body_id(const physics::Mechanism& mechanism, const std::string& name) {
  for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) {
    if (mechanism.bodies[i].name == name) return {static_cast<int>(i)};
  }
  if (name == "world") return physics::world;
  throw std::runtime_error("no body '" + name + "'");
}

physics::Body read_body(const json& j) {
  physics::Body body;
  body.name = j.at("name");
  body.mass = j.at("mass");
  body.inertia = vec3(j.at("inertia")).asDiagonal();
  body.position = vec3(j.at("position"));
  body.orientation = quat(j.at("orientation"));
  body.velocity = vec3(j.at("velocity"));
  body.angular_velocity = vec3(j.at("angular_velocity"));
  return body;
}

physics::Joint read_joint(const physics::Mechanism& mechanism, const json& j) {
  physics::Joint joint;
  joint.name = j.at("name");
  const std::string type = j.at("type");
  if (type != "spherical" && type != "revolute") throw std::runtime_error("unexpected joint type " + type);
  joint.type = type == "spherical" ? physics::JointType::spherical : physics::JointType::revolute;
  joint.parent = body_id(mechanism, j.at("parent").get<std::string>());
  joint.child = body_id(mechanism, j.at("child").get<std::string>());
  joint.parent_point = vec3(j.at("parent_point"));
  joint.child_point = vec3(j.at("child_point"));
  if (j.contains("axis")) joint.axis = vec3(j.at("axis"));
  joint.orientation = quat(j.at("orientation"));
  return joint;
}

physics::Contact read_contact(const physics::Mechanism& mechanism, const json& j) {
  physics::Contact contact;
  contact.name = j.at("name");
  contact.body = body_id(mechanism, j.at("body").get<std::string>());
  contact.point = vec3(j.at("point"));
  contact.normal = vec3(j.at("normal"));
  contact.plane_point = vec3(j.at("plane_point"));
  contact.friction = j.at("friction").get<double>();
  if (j.at("friction_model") != "pyramid") throw std::runtime_error("unexpected friction model");
  contact.friction_model = physics::FrictionModel::pyramid;
  contact.directions = j.at("directions");
  contact.tangent = vec3(j.at("tangent"));
  return contact;
}

physics::StepRecord read_step(const json& j) {
  physics::StepRecord record;
  record.step = j.at("step");
  record.time = j.at("time");
  for (const json& b : j.at("bodies")) {
    record.bodies.push_back(
        {vec3(b.at("position")), quat(b.at("orientation")), vec3(b.at("velocity")), vec3(b.at("angular_velocity"))});
  }
  for (const json& c : j.at("contacts")) {
    physics::ContactRecord contact;
    contact.distance = c.at("distance");
    contact.normal_force = c.at("normal_force");
    contact.friction_force = vec3(c.at("friction_force"));
    contact.facet_forces = c.at("facet_forces").get<std::vector<double>>();
    record.contacts.push_back(std::move(contact));
  }
  return record;
}

}  // namespace

const std::vector<std::string>& names() {
  static const std::vector<std::string> all{"box_4contacts", "chain_n2_c3", "cylinder_c2",
                                            "cylinder_c8",   "double_pendulum_ground", "free_top",
                                            "incline_box",   "mass_ratio_1e4", "pendulum"};
  return all;
}

physics::Trajectory read(const std::string& name) {
  std::ifstream file(std::string(GRAPHSOLVE_SOURCE_DIR) + "/tests/data/reference/" + name + ".json");
  const json j = json::parse(file);
  physics::Trajectory trajectory;
  physics::Mechanism& mechanism = trajectory.mechanism;
  mechanism.name = j.at("name");
  mechanism.time_step = j.at("time_step");
  mechanism.gravity = vec3(j.at("gravity"));
  if (j.at("start") != "standard") throw std::runtime_error("unexpected start");
  mechanism.start = physics::Start::standard;
  for (const json& b : j.at("bodies")) mechanism.add(read_body(b));
  for (const json& k : j.at("joints")) mechanism.add(read_joint(mechanism, k));
  for (const json& c : j.at("contacts")) mechanism.add(read_contact(mechanism, c));
  for (const json& s : j.at("steps")) trajectory.steps.push_back(read_step(s));
  return trajectory;
}

}  // namespace reference
