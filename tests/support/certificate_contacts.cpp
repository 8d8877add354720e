#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/certificate_view.hpp"

namespace certificate {

namespace {

using physics::Contact;
using physics::ContactRecord;

/// Where a contact acts at the old pose, from the centre of mass, world frame: of a sphere the lowest point.
Vec3 arm(const Step& step, const Contact& contact, const Vec3& normal) {
  return step.old_at(contact.body).r * contact.point - contact.radius * normal;
}

double distance(const Step& step, const Contact& contact, const Vec3& normal) {
  const Placement& pose = step.new_at(contact.body);
  return normal.dot(pose.x + pose.r * contact.point - contact.plane_point) - contact.radius;
}

/// Natural measure of 0 <= s _|_ z >= 0; what is negative is judged elsewhere.
double complementarity(double s, double z) {
  if (std::isnan(s) || std::isnan(z)) return std::numeric_limits<double>::quiet_NaN();
  return std::max(0.0, std::min(s, z));
}

/// First friction direction: recorded, else the scene's, else any (useful only where nothing presses).
Vec3 basis(const Contact& contact, const ContactRecord& record, const Vec3& normal) {
  if (record.tangent) return *record.tangent;
  Vec3 t = contact.tangent.value_or(normal.cross(std::abs(normal.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY()));
  t -= normal * normal.dot(t);
  return t.normalized();
}

struct Friction {
  Vec3 slip;                  // [m/s]
  double bound;               // cf times normal force [N]
  std::vector<double> facet;  // [N]
  std::vector<Vec3> direction;
};

void judge_pyramid(const Step& step, std::size_t index, const Friction& friction, Certificate& result) {
  const Contact& contact = step.mechanism.contacts[index];
  const ContactRecord& record = step.after.contacts[index];
  const double unit = step.force_time / step.largest_mass[contact.body.index];  // force to velocity
  const double own_unit = step.force_time / step.scale[contact.body.index].mass;
  double sum = 0, psi = 0;
  Vec3 force = Vec3::Zero();
  for (std::size_t i = 0; i < friction.facet.size(); ++i) {
    result.pyramid.raise(-unit * friction.facet[i], step.after.step, contact.name);
    sum += friction.facet[i];
    force += friction.facet[i] * friction.direction[i];
    psi = std::max(psi, -friction.direction[i].dot(friction.slip));
  }
  result.pyramid.raise(unit * (sum - friction.bound), step.after.step, contact.name);
  result.pyramid.raise(own_unit * (force - record.friction_force).norm(), step.after.step, contact.name);
  for (std::size_t i = 0; i < friction.facet.size(); ++i) {
    const double eta = friction.direction[i].dot(friction.slip) + psi;
    result.friction_pairs.raise(complementarity(eta, unit * friction.facet[i]), step.after.step, contact.name);
  }
  const double slack = complementarity(psi, unit * (friction.bound - sum));
  result.friction_pairs.raise(slack, step.after.step, contact.name);
}

/// How far the force is from the circular cone and from opposing the slip: reported.
void report_cone(const Step& step, std::size_t index, const Friction& friction, Certificate& result) {
  const std::string& name = step.mechanism.contacts[index].name;
  const Vec3& force = step.after.contacts[index].friction_force;
  result.cone_excess.raise(force.norm() - friction.bound, step.after.step, name);
  const double unit = step.force_time / step.largest_mass[step.mechanism.contacts[index].body.index];
  if (friction.slip.norm() < 1e-4 || unit * force.norm() < 1e-6) return;
  const double angle = std::atan2(force.cross(-friction.slip).norm(), force.dot(-friction.slip));
  result.slip_angle.raise(angle, step.after.step, name);
}

/// Of `pyramid` the paper's, at the old pose; of `aligned` the way of the body's point from pose to pose, and what a
/// sphere rolls.
Vec3 slip_velocity(const Step& step, const Contact& contact, const Vec3& normal) {
  const int body = contact.body.index;
  const Placement &from = step.old_at(contact.body), &to = step.new_at(contact.body);
  const Vec3 spin = from.r * step.after.bodies[body].angular_velocity;
  if (contact.friction_model == physics::FrictionModel::aligned)
    return (to.x - from.x + (to.r - from.r) * contact.point) / step.dt - spin.cross(contact.radius * normal);
  const Vec3 from_centre = from.x - step.group_centre[body] + arm(step, contact, normal);
  return step.group_velocity[body] + spin.cross(from_centre);
}

void judge_friction(const Step& step, std::size_t index, const Vec3& normal, Certificate& result) {
  const Contact& contact = step.mechanism.contacts[index];
  const ContactRecord& record = step.after.contacts[index];
  const double unit = step.force_time / step.scale[contact.body.index].mass;
  result.pyramid.raise(unit * std::abs(normal.dot(record.friction_force)), step.after.step, contact.name);
  const double coefficient = contact.friction.value_or(0);
  if (coefficient == 0) {
    result.pyramid.raise(unit * record.friction_force.norm(), step.after.step, contact.name);
    return;
  }
  const Vec3 t1 = basis(contact, record, normal), t2 = normal.cross(t1);
  const double crooked = std::max(std::abs(t1.norm() - 1), std::abs(t1.dot(normal)));
  result.pyramid.raise(crooked, step.after.step, contact.name);

  const Vec3 velocity = slip_velocity(step, contact, normal);
  Friction friction;
  friction.slip = velocity - normal * normal.dot(velocity);
  friction.bound = coefficient * record.normal_force;
  friction.facet = record.facet_forces;
  if (friction.facet.empty()) friction.facet.assign(contact.directions, 0.0);
  const std::size_t count = friction.facet.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    friction.direction.push_back(std::cos(angle) * t1 + std::sin(angle) * t2);
  }
  judge_pyramid(step, index, friction, result);
  report_cone(step, index, friction, result);
}

}  // namespace

/// Of a step in parts it is the last part that leads to the new distances, with the impulse of its own time.
void judge_gaps(const Step& step, Certificate& result) {
  const int parts = step.after.solver ? step.after.solver->substeps : 1;
  for (std::size_t i = 0; i < step.mechanism.contacts.size(); ++i) {
    const Contact& contact = step.mechanism.contacts[i];
    const ContactRecord& record = step.after.contacts[i];
    const double gap = distance(step, contact, contact.normal.normalized());
    const double unit = step.force_time / step.largest_mass[contact.body.index];
    if (!(gap >= result.smallest_distance)) result.smallest_distance = gap;
    result.distance_difference.raise(std::abs(gap - record.distance), step.after.step, contact.name);
    result.penetration.raise(-gap / step.dt, step.after.step, contact.name);
    result.tension.raise(-unit * record.normal_force, step.after.step, contact.name);
    const double pair = complementarity(parts * gap / step.dt, unit / parts * record.normal_force);
    result.gap_pairs.raise(pair, step.after.step, contact.name);
  }
}

void judge_contacts(const Step& step, std::span<Momentum> rest, Certificate& result) {
  for (std::size_t i = 0; i < step.mechanism.contacts.size(); ++i) {
    const Contact& contact = step.mechanism.contacts[i];
    const ContactRecord& record = step.after.contacts[i];
    const Vec3 normal = contact.normal.normalized();
    const Vec3 impulse = step.force_time * (record.normal_force * normal + record.friction_force);
    rest[contact.body.index].linear -= impulse;
    rest[contact.body.index].angular -= arm(step, contact, normal).cross(impulse);
    judge_friction(step, i, normal, result);
  }
}

}  // namespace certificate
