#include <Eigen/Eigenvalues>
#include <cmath>
#include <fmt/format.h>

#include "graphsolve/ordering.hpp"
#include "rotation.hpp"
#include "simulator_impl.hpp"

/// Description -> graph -> symbolic -> terms -> start.
namespace physics {

namespace {

constexpr double largest_start_error = 1e-5;  ///< [m, rad] a start that is further open is a wrong description

const Motor* motor_of(const Mechanism& mechanism, const JointGeometry& geometry) {
  const auto& motor = mechanism.joints[geometry.source].motor;
  return motor && (motor->stiffness > 0 || motor->damping > 0) ? &*motor : nullptr;
}

graphsolve::BlockGraph make_graph(const Mechanism& mechanism, const Assembly& assembly) {
  using namespace graphsolve;
  BlockGraph graph;
  for (const RigidBody& body : assembly.bodies) graph.add_node(body.name, 6, NodeKind::regular);
  for (const JointGeometry& joint : assembly.joints) {
    const NodeId node = graph.add_node(mechanism.joints[joint.source].name,
                                       Joints::rows_of(joint, motor_of(mechanism, joint)), NodeKind::saddle);
    // The rows of one joint are independent on either body alone.
    if (joint.child >= 0) graph.add_edge(node, {joint.child}, EdgeRank::full_row);
    if (joint.parent >= 0) graph.add_edge(node, {joint.parent}, EdgeRank::full_row);
  }
  return graph;
}

}  // namespace

Simulator::Impl::Impl(Mechanism scene, const SimulatorSettings& options)
    : mechanism(std::move(scene)), settings(options) {
  if (settings.time_step) mechanism.time_step = *settings.time_step;
  if (settings.start) mechanism.start = *settings.start;
  validate(mechanism);
  dt = mechanism.time_step;
  if (!(settings.tolerance > 0)) throw DescriptionError(fmt::format("tolerance {} is not > 0", settings.tolerance));
  assembly = assemble(mechanism, settings.merge_fixed_joints);
  build();
  std::vector<BodyRecord> start;
  for (const Body& body : mechanism.bodies)
    start.push_back({body.position, body.orientation, body.velocity, body.angular_velocity});
  set_state(start, mechanism.start == Start::half_kick);
  check_start();
  save();
}

void Simulator::Impl::build() {
  graphsolve::BlockGraph graph = make_graph(mechanism, assembly);
  const auto components = graphsolve::connected_components(graph);
  const int n = static_cast<int>(assembly.bodies.size());
  std::vector<double> largest(components.count, 0.0), island_mass(n);
  for (int i = 0; i < n; ++i) {
    const int c = components.of_node[i];
    largest[c] = std::max(largest[c], assembly.bodies[i].mass);
  }
  for (int i = 0; i < n; ++i) island_mass[i] = largest[components.of_node[i]];

  for (int i = 0; i < n; ++i) bodies.add(assembly.bodies[i], {i});
  for (std::size_t j = 0; j < assembly.joints.size(); ++j)
    joints.add(assembly.joints[j], motor_of(mechanism, assembly.joints[j]), {n + static_cast<int>(j)});
  contacts = std::make_unique<Contacts>(mechanism, assembly, bodies, island_mass, settings.friction_model);

  problem = std::make_unique<graphsolve::Problem>(std::move(graph));
  problem->add(bodies);
  problem->add(joints);
  contacts->register_with(*problem);
  const auto gyration = [&](int body) { return std::sqrt(assembly.bodies[body].smallest_inertia / assembly.bodies[body].mass); };
  double scale[6];
  for (int i = 0; i < n; ++i) {
    const double m = assembly.bodies[i].mass;
    for (int r = 0; r < 6; ++r) scale[r] = r < 3 ? 1 / m : 1 / (m * gyration(i));
    problem->set_row_scale({i}, scale);
  }
  for (int j = 0; j < joints.size(); ++j) {
    const JointGeometry& g = joints.geometry(j);
    const double radius = gyration(g.child >= 0 ? g.child : g.parent);
    for (int r = 0; r < joints.rows(j); ++r) scale[r] = r < joints.translation_rows(j) ? 1 : radius;
    if (joints.has_motor(j) && g.type == JointType::prismatic) scale[5] = 1;
    problem->set_row_scale({n + j}, {scale, static_cast<std::size_t>(joints.rows(j))});
  }

  const auto ordering = graphsolve::minimum_fill_ordering(problem->graph());
  auto symbolic = std::make_shared<const graphsolve::Symbolic>(problem->graph(), ordering);
  size.body_nodes = n;
  size.joint_nodes = joints.size();
  size.rows = symbolic->rows();
  size.islands = symbolic->components();
  size.merged_bodies = static_cast<int>(mechanism.bodies.size()) - n;
  size.frictionless_contacts = contacts->frictionless();
  size.operations = symbolic->counts().operations;
  size.fill_blocks = symbolic->counts().fill_blocks;
  size.stored_scalars = symbolic->counts().stored_scalars;
  island.resize(n);
  for (int i = 0; i < n; ++i) island[i] = symbolic->component({i});
  noise.assign(symbolic->components(), 0.0);
  unknowns.assign(symbolic->rows(), 0.0);
  solver = std::make_unique<graphsolve::InteriorPoint>(*problem, std::move(symbolic),
                                                       graphsolve::InteriorPointSettings{.tolerance = settings.tolerance});
  solver->set_profile(&profile);
}

void Simulator::Impl::set_state(std::span<const BodyRecord> records, bool half_kick) {
  const int n = bodies.size();
  for (auto* v : {&state.x, &state.v, &state.w}) v->assign(n, Vec3::Zero());
  state.q.assign(n, Quat::Identity());
  for (std::size_t k = 0; k < records.size(); ++k) {
    const Placement& place = assembly.placement[k];
    if (place.body < 0) continue;
    const BodyRecord& body = records[k];
    state.v[place.body] += mechanism.bodies[k].mass / bodies.mass[place.body] * body.velocity;
    if (assembly.bodies[place.body].first_member != static_cast<int>(k)) continue;
    const Quat q = body.orientation.normalized() * place.rotation.conjugate();
    state.q[place.body] = q;
    state.x[place.body] = body.position - q * place.offset;
    state.w[place.body] = place.rotation * body.angular_velocity;
  }
  state.time_step = dt;
  state.half_kick = half_kick;
  std::fill(unknowns.begin(), unknowns.end(), 0.0);
  load_state_into_terms(dt);
  state.kinetic_energy = state.previous_kinetic_energy = kinetic_energy();
  state.potential_energy = potential_energy();
  impulse_time = 0;
  contacts->clear();
  joints.prepare(0, dt);
  joints.reset_coordinates();
  start_correction = 0;
  for (int j = 0; j < joints.size(); ++j)
    start_correction = std::max(start_correction, joints.opening_rate(j, unknowns));
}

void Simulator::Impl::check_start() const {
  for (int j = 0; j < joints.size(); ++j) {
    const JointGeometry& g = joints.geometry(j);
    const double error = joints.error(j, bodies.pose_now(g.parent), bodies.pose_now(g.child));
    if (error > largest_start_error)
      throw DescriptionError(fmt::format("joint '{}': the start leaves it open by {:.3g} (m or rad)",
                                         mechanism.joints[g.source].name, error));
  }
}

void Simulator::restart_from(const StepRecord& record) {
  Impl& s = *impl_;
  if (record.bodies.size() != s.mechanism.bodies.size())
    throw DescriptionError(fmt::format("record {}: {} bodies, the scene has {}", record.step, record.bodies.size(),
                                       s.mechanism.bodies.size()));
  for (std::size_t k = 0; k < record.bodies.size(); ++k) {
    const BodyRecord& body = record.bodies[k];
    const bool finite = body.position.allFinite() && body.velocity.allFinite() && body.angular_velocity.allFinite();
    if (!finite || !(std::abs(body.orientation.norm() - 1) < 1e-6))
      throw DescriptionError(fmt::format("record {}: body '{}' has a value that is not finite or a quaternion that is "
                                         "not a unit one", record.step, s.mechanism.bodies[k].name));
  }
  s.set_state(record.bodies, false);
  const int substeps = record.solver ? std::max(1, record.solver->substeps) : 1;
  s.state.time_step = s.dt / substeps;
  // Forces of the record make the start warm and keep the friction basis; a start without them is only colder.
  if (record.contacts.size() == s.mechanism.contacts.size())
    s.contacts->load_record(record.contacts, s.state.time_step);
  s.step_index = record.step;
  s.time = record.time;
  s.last = {};
}

}  // namespace physics
