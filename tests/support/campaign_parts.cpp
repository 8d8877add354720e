#include "support/campaign_parts.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace campaign {

using namespace physics;

std::uint64_t Random::bits() {  // splitmix64
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}
double Random::uniform(double low, double high) {
  return low + (high - low) * std::ldexp(static_cast<double>(bits() >> 11), -53);
}
double Random::logarithmic(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
int Random::integer(int low, int high) { return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1)); }

Vec3 direction(Random& random) {
  const double z = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Body box(const std::string& name, const Vec3& size, double mass) {
  Body body;
  body.name = name;
  body.mass = mass;
  body.shape.type = Shape::Type::box;
  body.shape.size = size;
  body.inertia = shape_inertia(body.shape, mass);
  return body;
}

Quat any_rotation(Random& random) {
  return Quat(Eigen::AngleAxisd(random.uniform(0, std::numbers::pi), direction(random)));
}

Body bar(const std::string& name, const Vec3& upper, const Vec3& lower, double thickness, double mass) {
  const Vec3 along = upper - lower;
  Body body = box(name, {thickness, thickness, along.norm()}, mass);
  body.position = 0.5 * (upper + lower);
  body.orientation = Quat(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), along));
  return body;
}

Contact ground(const std::string& name, BodyId body, const Vec3& point, double friction) {
  Contact contact;
  contact.name = name;
  contact.body = body;
  contact.point = point;
  contact.friction = friction;
  return contact;
}

void add_corners(Mechanism& scene, BodyId id, double friction, int count) {
  const Body& body = scene.bodies[id.index];
  for (int i = 0; i < count; ++i) {
    const Vec3 corner((i & 1 ? 0.5 : -0.5) * body.shape.size.x(), (i & 2 ? 0.5 : -0.5) * body.shape.size.y(),
                      (i & 4 ? 0.5 : -0.5) * body.shape.size.z());
    scene.add(ground(body.name + " corner " + std::to_string(i), id, corner, friction));
  }
}

void join(Mechanism& scene, JointType type, BodyId parent, BodyId child, const Vec3& at, const Vec3& axis) {
  Joint joint;
  joint.name = "joint " + std::to_string(scene.joints.size());
  joint.type = type;
  joint.parent = parent;
  joint.child = child;
  const Body& b = scene.bodies[child.index];
  joint.child_point = b.orientation.conjugate() * (at - b.position);
  joint.parent_point = at;
  joint.axis = axis;
  joint.orientation = b.orientation;
  if (!parent.is_world()) {
    const Body& a = scene.bodies[parent.index];
    joint.parent_point = a.orientation.conjugate() * (at - a.position);
    joint.axis = a.orientation.conjugate() * axis;
    joint.orientation = a.orientation.conjugate() * b.orientation;
  }
  scene.add(std::move(joint));
}

void add_chain(Mechanism& scene, int links, const Vec3& start, const Vec3& along, double friction,
               const std::function<double(int)>& mass_of) {
  Vec3 upper = start;
  const int first = static_cast<int>(scene.bodies.size());
  for (int i = 0; i < links; ++i) {
    const Vec3 lower = upper + along;
    const BodyId id = scene.add(bar("link " + std::to_string(i), upper, lower, 0.1 * along.norm(), mass_of(i)));
    if (i > 0) join(scene, JointType::spherical, {first + i - 1}, id, upper);
    const double half = 0.5 * along.norm();
    if (i == 0) scene.add(ground("upper end", id, {0, 0, half}, friction));
    scene.add(ground("lower end " + std::to_string(i), id, {0, 0, -half}, friction));
    upper = lower;
  }
}

void set_velocity(Mechanism& scene, const Vec3& velocity) {
  for (Body& body : scene.bodies) body.velocity = velocity;
}

void vary(Mechanism& scene, Random& random) {
  scene.start = random.coin() ? Start::half_kick : Start::standard;
  const FrictionModel model = random.coin() ? FrictionModel::aligned : FrictionModel::pyramid;
  for (Contact& contact : scene.contacts) {
    contact.friction_model = model;
    contact.tangent = Vec3::UnitX();  // said, so that the certificate knows the pyramid
  }
}

}  // namespace campaign
