#include <fmt/format.h>

#include "io/read.hpp"

namespace physics::io {

namespace {

BodyRecord read_body_record(const Json& json) {
  Object object(json);
  BodyRecord record{vec3(object.required("position")), quat(object.required("orientation")),
                    vec3(object.required("velocity")), vec3(object.required("angular_velocity"))};
  if (const Json* missed = object.optional("missed")) record.missed = vec3(*missed);
  if (const Json* missed = object.optional("missed_angular")) record.missed_angular = vec3(*missed);
  object.finish();
  return record;
}

ContactRecord read_contact_record(const Json& json) {
  Object object(json);
  ContactRecord record;
  record.distance = number(object.required("distance"));
  record.normal_force = number(object.required("normal_force"));
  if (const Json* force = object.optional("friction_force")) record.friction_force = vec3(*force);
  if (const Json* forces = object.optional("facet_forces")) record.facet_forces = numbers(*forces);
  if (const Json* tangent = object.optional("tangent")) record.tangent = vec3(*tangent);
  object.finish();
  return record;
}

JointRecord read_joint_record(const Json& json) {
  Object object(json);
  JointRecord record;
  record.force = vec3(object.required("force"));
  record.torque = vec3(object.required("torque"));
  if (const Json* error = object.optional("error")) record.error = number(*error);
  if (const Json* effort = object.optional("effort")) record.effort = number(*effort);
  if (const Json* coordinate = object.optional("coordinate")) record.coordinate = number(*coordinate);
  if (const Json* rate = object.optional("rate")) record.rate = number(*rate);
  object.finish();
  return record;
}

SolverRecord read_solver(const Json& json) {
  Object object(json);
  SolverRecord record;
  if (const Json* status = object.optional("status")) record.status = string(*status);
  if (const Json* iterations = object.optional("iterations")) record.iterations = integer(*iterations);
  if (const Json* residual = object.optional("residual")) record.residual = number(*residual);
  if (const Json* substeps = object.optional("substeps")) record.substeps = integer(*substeps);
  if (const Json* direction = object.optional("new_force_direction")) record.new_force_direction = boolean(*direction);
  object.finish();
  return record;
}

template <class Record>
std::vector<Record> read_list(const Json& json, Record (*read)(const Json&), std::size_t size, std::string_view kind) {
  if (list(json).size() != size)
    throw ReadError{&json, fmt::format("has {} entries, the scene has {} {}", json.size(), size, kind)};
  std::vector<Record> records;
  records.reserve(size);
  for (const Json& entry : json) records.push_back(read(entry));
  return records;
}

StepRecord read_step(const Json& json, const Mechanism& mechanism) {
  Object object(json);
  StepRecord record;
  record.step = integer(object.required("step"));
  record.time = number(object.required("time"));
  record.bodies = read_list(object.required("bodies"), read_body_record, mechanism.bodies.size(), "bodies");
  // The start has no forces, and files may leave forces out altogether.
  if (const Json* contacts = object.optional("contacts"); contacts && !contacts->empty())
    record.contacts = read_list(*contacts, read_contact_record, mechanism.contacts.size(), "contacts");
  if (const Json* joints = object.optional("joints"); joints && !joints->empty())
    record.joints = read_list(*joints, read_joint_record, mechanism.joints.size(), "joints");
  if (const Json* solver = object.optional("solver")) record.solver = read_solver(*solver);
  record.extras = object.finish();
  return record;
}

}  // namespace

std::vector<StepRecord> read_steps(const Json& steps, const Mechanism& mechanism) {
  std::vector<StepRecord> records;
  records.reserve(list(steps).size());
  for (const Json& step : steps) {
    records.push_back(read_step(step, mechanism));
    if (const std::size_t n = records.size(); n > 1 && records[n - 1].step <= records[n - 2].step)
      throw ReadError{&step, fmt::format("step {} follows step {}", records[n - 1].step, records[n - 2].step)};
  }
  return records;
}

FailureRecord read_failure(const Json& json, const std::vector<StepRecord>& steps) {
  Object object(json);
  FailureRecord failure;
  failure.step = integer(object.required("step"));
  failure.status = string(object.required("status"));
  if (const Json* place = object.optional("place")) failure.place = string(*place);
  if (const Json* cause = object.optional("cause")) failure.cause = string(*cause);
  object.finish();
  if (!steps.empty() && failure.step <= steps.back().step)
    throw ReadError{&json, fmt::format("step {} is not after the last record, {}", failure.step, steps.back().step)};
  return failure;
}

}  // namespace physics::io
