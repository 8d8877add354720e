#include "support/certificate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <ostream>

#include "support/certificate_view.hpp"

namespace certificate {

void Finding::raise(double candidate, int at_step, const std::string& name) {
  if (std::isnan(value) || candidate <= value) return;
  value = candidate;
  step = at_step;
  what = name;
}

void Finding::raise(const Finding& other) { raise(other.value, other.step, other.what); }

namespace {

struct Named {
  const char* name;
  Finding Certificate::*finding;
};
constexpr Named barred[] = {
    {"kinematics", &Certificate::kinematics},   {"dynamics", &Certificate::dynamics},
    {"joints", &Certificate::joints},           {"wrench", &Certificate::wrench},
    {"motor", &Certificate::motor},             {"penetration", &Certificate::penetration},
    {"tension", &Certificate::tension},         {"pyramid", &Certificate::pyramid},
    {"gap pairs", &Certificate::gap_pairs},     {"friction pairs", &Certificate::friction_pairs},
};
constexpr Named reported[] = {
    {"momentum", &Certificate::momentum},
    {"joint error", &Certificate::joint_error},
    {"distance difference", &Certificate::distance_difference},
    {"slip angle", &Certificate::slip_angle},
    {"cone excess", &Certificate::cone_excess},
};

/// Angular momentum of one step seen from its ends, body frame there: c J w ± e x J w with the half turn
/// (c, e) of the step. sign = +1: at its beginning, -1: at its end.
Vec3 angular_momentum(const Mat3& inertia, const Vec3& rate, double duration, double sign) {
  const Vec3 e = duration / 2 * rate, spin = inertia * rate;
  return std::sqrt(1 - e.squaredNorm()) * spin + sign * e.cross(spin);
}

void judge_kinematics(const Step& step, Certificate& result) {
  for (std::size_t i = 0; i < step.old_pose.size(); ++i) {
    const Placement &from = step.old_pose[i], &to = step.new_pose[i];
    const physics::BodyRecord& record = step.after.bodies[i];
    const std::string& name = step.mechanism.bodies[i].name;
    result.kinematics.raise(largest((to.x - from.x) / step.dt - record.velocity), step.after.step, name);
    const Turn turned = inverse(from.q) * to.q;
    const double sign = turned.w < 0 ? -1 : 1;  // q and -q are one orientation
    const Vec3 rate = 2 / step.dt * sign * turned.v;
    const double gyration = step.scale[i].gyration();
    result.kinematics.raise(gyration * largest(rate - record.angular_velocity), step.after.step, name);
    result.kinematics.raise(std::abs(to.q.w * to.q.w + to.q.v.squaredNorm() - 1), step.after.step, name);
  }
}

/// Momenta of bodies that move as one, about their common centre.
void judge_dynamics(const Step& step, std::span<const Momentum> rest, Missed* missed, Certificate& result) {
  const std::size_t n = rest.size();
  std::vector<Momentum> sum(n);
  std::vector<Vec3> centre(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    if (step.group[i] < 0) continue;
    centre[step.group[i]] += step.mechanism.bodies[i].mass / step.scale[i].mass * step.old_pose[i].x;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const int g = step.group[i];
    if (g < 0) {
      ++result.held;
      continue;
    }
    sum[g].linear += rest[i].linear;
    sum[g].angular += rest[i].angular + (step.old_pose[i].x - centre[g]).cross(rest[i].linear);
  }
  if (missed) {
    for (std::size_t i = 0; i < missed->size(); ++i) {
      sum[i].linear += (*missed)[i].linear;
      sum[i].angular += (*missed)[i].angular;
    }
    *missed = sum;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (step.group[i] != static_cast<int>(i)) continue;
    const std::string& name = step.mechanism.bodies[i].name;
    result.dynamics.raise(largest(sum[i].linear) / step.scale[i].mass, step.after.step, name);
    const Vec3 angular = step.old_pose[i].r.transpose() * sum[i].angular;
    result.dynamics.raise(largest(angular) / step.scale[i].rotational(), step.after.step, name);
  }
}

/// Inner forces cancel whatever they are: total momentum about the common centre.
void report_momentum(const Step& step, std::span<const Momentum> rest, Certificate& result) {
  double mass = 0;
  Vec3 centre = Vec3::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (step.group[i] < 0) return;
    mass += step.mechanism.bodies[i].mass;
    centre += step.mechanism.bodies[i].mass * step.old_pose[i].x;
  }
  if (mass == 0) return;
  centre /= mass;
  Momentum total;
  Mat3 inertia = Mat3::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vec3 arm = step.old_pose[i].x - centre;
    const physics::Body& body = step.mechanism.bodies[i];
    total.linear += rest[i].linear;
    total.angular += rest[i].angular + arm.cross(rest[i].linear);
    inertia += step.old_pose[i].r * body.inertia * step.old_pose[i].r.transpose() +
               body.mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  const double moment = inertia.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
  result.momentum.raise(largest(total.linear) / mass, step.after.step, "linear");
  result.momentum.raise(largest(total.angular) / std::sqrt(mass * moment), step.after.step, "angular");
}

}  // namespace

std::vector<Momentum> inertial_rest(const Step& step) {
  const physics::Mechanism& mechanism = step.mechanism;
  const int substeps = step.before.solver ? step.before.solver->substeps : 1;
  std::vector<Momentum> rest(mechanism.bodies.size());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const physics::Body& body = mechanism.bodies[i];
    const physics::BodyRecord &before = step.before.bodies[i], &after = step.after.bodies[i];
    // A velocity belongs to the step that made it, as long as that step was.
    const Vec3 old_spin = step.half_kick
                              ? Vec3(body.inertia * before.angular_velocity)
                              : angular_momentum(body.inertia, before.angular_velocity, step.dt / substeps, -1);
    const Vec3 new_spin = angular_momentum(body.inertia, after.angular_velocity, step.dt, +1);
    rest[i].linear = body.mass * (after.velocity - before.velocity - step.force_time * mechanism.gravity);
    rest[i].angular = step.old_pose[i].r * (new_spin - old_spin);
  }
  for (const physics::Load& load : mechanism.loads) {
    if (step.after.step < load.first_step || step.after.step > load.last_step || load.body.is_world()) continue;
    rest[load.body.index].linear -= step.force_time * load.force;
    rest[load.body.index].angular -= step.force_time * (step.old_pose[load.body.index].r * load.torque);
  }
  return rest;
}

Finding Certificate::worst() const {
  Finding worst;
  for (const auto& [name, finding] : barred) {
    const Finding& candidate = this->*finding;
    worst.raise(candidate.value, candidate.step, std::string(name) + " of " + candidate.what);
  }
  return worst;
}

void Certificate::merge(const Certificate& other) {
  for (const auto& [name, finding] : barred) (this->*finding).raise(other.*finding);
  for (const auto& [name, finding] : reported) (this->*finding).raise(other.*finding);
  smallest_distance = std::min(smallest_distance, other.smallest_distance);
  steps += other.steps;
  flagged += other.flagged;
  held += other.held;
}

std::ostream& operator<<(std::ostream& out, const Certificate& certificate) {
  out << certificate.steps << " steps, " << certificate.flagged << " flagged, smallest distance "
      << certificate.smallest_distance << " m\n";
  const auto print = [&](const Named& named) {
    const Finding& finding = certificate.*named.finding;
    if (finding.step < 0) return;
    out << "  " << named.name << " " << finding.value << " (" << finding.what << ", step " << finding.step << ")\n";
  };
  for (const Named& named : barred) print(named);
  out << " reported:\n";
  for (const Named& named : reported) print(named);
  return out;
}

Certificate certify_step(const physics::Mechanism& mechanism, const physics::StepRecord& before,
                         const physics::StepRecord& after, Missed* missed) {
  const Step step(mechanism, before, after);
  Certificate result;
  result.steps = 1;
  judge_joint_errors(step, result);
  judge_gaps(step, result);
  if (after.solver && (after.solver->substeps > 1 || after.solver->new_force_direction)) {
    result.flagged = 1;
    if (missed) missed->clear();
    return result;
  }
  judge_kinematics(step, result);
  std::vector<Momentum> rest = inertial_rest(step);
  judge_contacts(step, rest, result);
  judge_joints(step, rest, result);
  if (!step.forces_recorded) eliminate_joints(step, rest);
  judge_dynamics(step, rest, missed, result);
  report_momentum(step, rest, result);
  return result;
}

Certificate certify(const physics::Trajectory& trajectory) {
  Certificate result;
  Missed missed;
  for (std::size_t k = 1; k < trajectory.steps.size(); ++k) {
    const physics::StepRecord &before = trajectory.steps[k - 1], &after = trajectory.steps[k];
    if (after.step == before.step + 1) result.merge(certify_step(trajectory.mechanism, before, after, &missed));
  }
  return result;
}

}  // namespace certificate
