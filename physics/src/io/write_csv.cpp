#include <fmt/format.h>

#include <array>
#include <span>

#include "io/write.hpp"

namespace physics::io {

namespace {

/// Quoted when it must be.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

constexpr std::array of_body{"x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"};
constexpr std::array of_contact{"distance", "normal_force", "friction_x", "friction_y", "friction_z"};
constexpr std::array of_joint{"fx", "fy", "fz", "tx", "ty", "tz", "error", "effort", "coordinate", "rate"};

void add_names(std::string& row, const std::string& thing, std::span<const char* const> keys) {
  for (const char* key : keys) row += ',' + cell(fmt::format("{}.{}", thing, key));
}

/// fmt writes the shortest form that reads back as the same bits.
void add(std::string& row, double value) { fmt::format_to(std::back_inserter(row), ",{}", value); }
void add(std::string& row, const Vec3& v) {
  for (const double value : v) add(row, value);
}

}  // namespace

std::string csv_header(const Mechanism& mechanism) {
  std::string row = "step,time";
  for (const Body& body : mechanism.bodies) add_names(row, body.name, of_body);
  for (const Contact& contact : mechanism.contacts) add_names(row, contact.name, of_contact);
  for (const Joint& joint : mechanism.joints) add_names(row, joint.name, of_joint);
  return row + ",solver.status,solver.iterations,solver.residual,solver.substeps\n";
}

/// Cells stay empty where a record says nothing.
std::string csv_row(const StepRecord& record, const Mechanism& mechanism) {
  std::string row = fmt::format("{},{}", record.step, record.time);
  for (const BodyRecord& body : record.bodies) {
    add(row, body.position);
    for (const double q : {body.orientation.w(), body.orientation.x(), body.orientation.y(), body.orientation.z()})
      add(row, q);
    add(row, body.velocity);
    add(row, body.angular_velocity);
  }
  for (const ContactRecord& contact : record.contacts) {
    add(row, contact.distance);
    add(row, contact.normal_force);
    add(row, contact.friction_force);
  }
  row.append(of_contact.size() * (mechanism.contacts.size() - record.contacts.size()), ',');
  for (const JointRecord& joint : record.joints) {
    add(row, joint.force);
    add(row, joint.torque);
    add(row, joint.error);
    for (const auto& value : {joint.effort, joint.coordinate, joint.rate})
      value ? add(row, *value) : row.push_back(',');
  }
  row.append(of_joint.size() * (mechanism.joints.size() - record.joints.size()), ',');
  if (const auto& solver = record.solver) {
    fmt::format_to(std::back_inserter(row), ",{},{},{},{}", cell(solver->status), solver->iterations, solver->residual,
                   solver->substeps);
  } else {
    row += ",,,,";
  }
  return row + '\n';
}

/// A row of the step that failed: it has a status and no state.
std::string csv_end(const std::optional<FailureRecord>& failure, const Mechanism& mechanism) {
  if (!failure) return {};
  const std::size_t empty = 1 + of_body.size() * mechanism.bodies.size() +
                            of_contact.size() * mechanism.contacts.size() + of_joint.size() * mechanism.joints.size();
  return fmt::format("{}{},{},,,\n", failure->step, std::string(empty, ','), cell(failure->status));
}

}  // namespace physics::io
