#include "support/certificate_view.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace certificate {

Turn operator*(const Turn& a, const Turn& b) {
  return {a.w * b.w - a.v.dot(b.v), a.w * b.v + b.w * a.v + a.v.cross(b.v)};
}

Turn inverse(const Turn& unit) { return {unit.w, -unit.v}; }

Mat3 matrix(const Turn& unit) {
  Mat3 r;
  for (int i = 0; i < 3; ++i) {  // columns: rotated base vectors, b + 2 w v x b + 2 v x (v x b)
    const Vec3 b = Vec3::Unit(i), vb = unit.v.cross(b);
    r.col(i) = b + 2 * (unit.w * vb + unit.v.cross(vb));
  }
  return r;
}

Turn turn(const physics::Quat& q) { return {q.w(), q.vec()}; }

double largest(const Vec3& v) {
  return v.hasNaN() ? std::numeric_limits<double>::quiet_NaN() : v.cwiseAbs().maxCoeff();
}

double Scale::rotational() const { return std::sqrt(mass * moment); }
double Scale::gyration() const { return std::sqrt(moment / mass); }

namespace {

int root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

std::vector<Placement> placements(const physics::StepRecord& record) {
  std::vector<Placement> all;
  for (const physics::BodyRecord& body : record.bodies) {
    const Turn q = turn(body.orientation);
    all.push_back({body.position, q, matrix(q)});
  }
  return all;
}

void check_shape(const physics::Mechanism& mechanism, const physics::StepRecord& before,
                 const physics::StepRecord& after) {
  if (after.step != before.step + 1) throw std::invalid_argument("the records are not consecutive");
  if (before.bodies.size() != mechanism.bodies.size() || after.bodies.size() != mechanism.bodies.size())
    throw std::invalid_argument("the records do not have the scene's bodies");
  if (after.contacts.size() != mechanism.contacts.size())
    throw std::invalid_argument("the record does not have the scene's contacts");
  if (!after.joints.empty() && after.joints.size() != mechanism.joints.size())
    throw std::invalid_argument("the record does not have the scene's joints");
}

const Placement world_placement;

}  // namespace

Step::Step(const physics::Mechanism& mechanism_, const physics::StepRecord& before_,
           const physics::StepRecord& after_)
    : mechanism(mechanism_), before(before_), after(after_), dt(mechanism_.time_step) {
  check_shape(mechanism, before, after);
  half_kick = mechanism.start == physics::Start::half_kick && before.step == 0;
  force_time = half_kick ? dt / 2 : dt;
  forces_recorded = !after.joints.empty();
  old_pose = placements(before);
  new_pose = placements(after);
  find_groups();
}

const Placement& Step::old_at(physics::BodyId id) const { return id.is_world() ? world_placement : old_pose[id.index]; }
const Placement& Step::new_at(physics::BodyId id) const { return id.is_world() ? world_placement : new_pose[id.index]; }

bool Step::merged(std::size_t joint) const {
  if (!forces_recorded || mechanism.joints[joint].type != physics::JointType::fixed) return false;
  return after.joints[joint].force.isZero(0) && after.joints[joint].torque.isZero(0);
}

void Step::find_groups() {
  const int n = static_cast<int>(mechanism.bodies.size());
  std::vector<int> rigid(n + 1), island(n + 1);  // the last is the world
  std::iota(rigid.begin(), rigid.end(), 0);
  std::iota(island.begin(), island.end(), 0);
  const auto slot = [n](physics::BodyId id) { return id.is_world() ? n : id.index; };
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const physics::Joint& joint = mechanism.joints[j];
    if (merged(j)) rigid[root(rigid, slot(joint.child))] = root(rigid, slot(joint.parent));
  }
  const int world_root = root(rigid, n);
  for (const physics::Joint& joint : mechanism.joints) {  // what is held by the world connects nothing
    const int a = slot(joint.parent), b = slot(joint.child);
    if (root(rigid, a) != world_root && root(rigid, b) != world_root) island[root(island, b)] = root(island, a);
  }
  group.resize(n);
  std::vector<double> mass(n + 1, 0.0);
  std::vector<Vec3> centre(n + 1, Vec3::Zero()), velocity(n + 1, Vec3::Zero());
  for (int i = 0; i < n; ++i) {
    const int g = root(rigid, i);
    group[i] = g == world_root ? -1 : g;
    mass[g] += mechanism.bodies[i].mass;
    centre[g] += mechanism.bodies[i].mass * old_pose[i].x;
    velocity[g] += mechanism.bodies[i].mass * after.bodies[i].velocity;
  }
  std::vector<Mat3> inertia(n + 1, Mat3::Zero());
  for (int i = 0; i < n; ++i) {
    const int g = root(rigid, i);
    const Vec3 arm = old_pose[i].x - centre[g] / mass[g];
    inertia[g] += old_pose[i].r * mechanism.bodies[i].inertia * old_pose[i].r.transpose() +
                  mechanism.bodies[i].mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  std::vector<double> moment(n + 1, 0.0), largest(n + 1, 0.0);
  for (int i = 0; i < n; ++i) {
    const int g = root(rigid, i), k = root(island, i);
    if (moment[g] == 0) moment[g] = inertia[g].selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
    largest[k] = std::max(largest[k], mass[g]);  // a body held by the world is an island of its own
  }
  for (int i = 0; i < n; ++i) {
    const int g = root(rigid, i);
    scale.push_back({mass[g], moment[g]});
    group_centre.push_back(centre[g] / mass[g]);
    group_velocity.push_back(velocity[g] / mass[g]);
    largest_mass.push_back(largest[root(island, i)]);
  }
}

}  // namespace certificate
