#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "graphsolve/cheapest_ordering.hpp"
#include "stepper/stepper.hpp"

/// Descriptions -> graph -> symbolic -> terms.
namespace physics {

namespace {

int joint_rows(const Mechanism& mechanism, const JointGeometry& joint) {
  return Joints::rows_of(joint, motor_of(mechanism, joint));
}

/// `copies` equal scenes, one after the other, so that the rows of each are one run: bodies, then joints.
graphsolve::BlockGraph make_graph(const Mechanism& mechanism, const Assembly& assembly, int copies) {
  using namespace graphsolve;
  BlockGraph graph;
  graph.reserve(copies * static_cast<int>(assembly.bodies.size() + assembly.joints.size()));
  for (int copy = 0; copy < copies; ++copy) {
    const int first = graph.size();
    for (const RigidBody& body : assembly.bodies) graph.add_node(body.name, 6, NodeKind::regular);
    for (const JointGeometry& joint : assembly.joints) {
      const NodeId node =
          graph.add_node(mechanism.joints[joint.source].name, joint_rows(mechanism, joint), NodeKind::saddle);
      // The rows of one joint are independent on either body alone.
      for (const int body : {joint.child, joint.parent})
        if (body >= 0) graph.add_edge(node, {first + body}, EdgeRank::full_row);
    }
  }
  return graph;
}

/// The order of one copy, equal nodes of all copies side by side.
graphsolve::Ordering order_copies(const graphsolve::BlockGraph& all, const graphsolve::Ordering& one, int copies) {
  if (copies == 1) return one;
  const int nodes = static_cast<int>(one.sequence.size());
  std::vector<graphsolve::NodeId> sequence;
  for (const graphsolve::NodeId node : one.sequence)
    for (int copy = 0; copy < copies; ++copy) sequence.push_back({copy * nodes + node.index});
  return graphsolve::user_ordering(all, sequence);
}

}  // namespace

/// Steps start from the velocities of the step before. Were they accepted at what gravity changes in a step, nothing
/// would ever fall.
double loosest_tolerance(const Mechanism& mechanism) {
  constexpr double part = 0.01;
  const double gained = mechanism.gravity.norm() * mechanism.time_step;
  return gained > 0 ? part * gained : std::numeric_limits<double>::infinity();
}

/// What a step that ends where it begins lacks is lost, and steps add up: a force that changes velocities by less than the
/// tolerance in each would do nothing at all. One iteration leaves the square of that.
constexpr double start_part = 1e-3;
/// Joint rows that depend but for the curvature of their constraints keep their multiplier.
constexpr double leave_out = 1e-8;

const Motor* motor_of(const Mechanism& mechanism, const JointGeometry& geometry) {
  const auto& motor = mechanism.joints[geometry.source].motor;
  return motor && (motor->stiffness > 0 || motor->damping > 0) ? &*motor : nullptr;
}

constexpr int most_substeps = 1 << 20;  // far from where numbers of parts overflow

Stepper::Stepper(Mechanism scene, int copies, const SimulatorSettings& options, const Stepper* same)
    : settings(options), side_by_side(copies), lanes(copies) {
  if (!(settings.tolerance > 0 && std::isfinite(settings.tolerance)))
    throw DescriptionError(fmt::format("tolerance {} is not a number > 0", settings.tolerance));
  if (settings.max_substeps < 1 || settings.max_substeps > most_substeps)
    throw DescriptionError(
        fmt::format("max_substeps {} is not a number from 1 to {}", settings.max_substeps, most_substeps));
  for (int lane = 1; lane < copies; ++lane) (void)describe(lane, scene);
  Assembly assembly = describe(0, std::move(scene));
  dt = lanes[0].mechanism.time_step;
  settings.tolerance = std::min(settings.tolerance, lanes[0].most_noise);
  build(assembly);
  make_solver(assembly, same);
  for (int lane = 0; lane < copies; ++lane) start(lane, assembly);
}

/// Takes up a description; what it says becomes numbers in set_parameters, out of the assembly.
Assembly Stepper::describe(int lane, Mechanism scene) {
  if (settings.time_step) scene.time_step = *settings.time_step;
  if (settings.start) scene.start = *settings.start;
  if (settings.friction_model)
    for (Contact& contact : scene.contacts) contact.friction_model = *settings.friction_model;
  validate(scene);
  Assembly assembly = assemble(scene, settings.merge_fixed_joints);
  if (solver) check_structure(scene, assembly);
  const auto shrink = [](auto&... lists) { (lists.shrink_to_fit(), ...); };
  shrink(scene.bodies, scene.joints, scene.contacts, scene.loads);  // kept as long as the lane is
  lanes[lane].most_noise = loosest_tolerance(scene);
  lanes[lane].mechanism = std::move(scene);
  if (assembly.bodies.size() != lanes[lane].mechanism.bodies.size()) lanes[lane].placement = assembly.placement;
  return assembly;
}

/// Terms, ports and their places in the graph, in the numbering of all lanes side by side.
void Stepper::build(const Assembly& assembly) {
  const Mechanism& scene = lanes[0].mechanism;
  bodies_per_lane = static_cast<int>(assembly.bodies.size());
  joints_per_lane = static_cast<int>(assembly.joints.size());
  problem = std::make_unique<graphsolve::Problem>(make_graph(scene, assembly, count()));
  bodies.reserve(bodies_per_lane * count());
  joints.reserve(joints_per_lane * count());
  joints.count_turns = settings.count_turns;
  side_by_side.each(bodies_per_lane, [&](int lane, int k) { bodies.add(assembly.bodies[k], body_node(lane, k)); });
  side_by_side.each(joints_per_lane, [&](int lane, int k) {
    joints.add(on_lane(lane, assembly.joints[k]), motor_of(scene, assembly.joints[k]), joint_node(lane, k));
  });
  contacts = std::make_unique<Contacts>(bodies, side_by_side, scene, assembly);
  bodies.turn_always = contacts->size_of_lane() > 0;
  problem->add(bodies);
  problem->add(joints);
  contacts->register_with(*problem);
}

namespace {

/// Those of every build, so that steps are the same in all.
constexpr std::array orderings{graphsolve::OrderingMethod::minimum_fill, graphsolve::OrderingMethod::wide};

}  // namespace

std::shared_ptr<const graphsolve::Symbolic> Stepper::make_plan(const Assembly& assembly) const {
  // Decided for one copy, so that a copy is eliminated as a simulator of its own is.
  const auto one = make_graph(lanes[0].mechanism, assembly, 1);
  const auto cheapest = graphsolve::cheapest_in_packs(one, graphsolve::FactorizationKind::ldu, orderings);
  const auto ordering = order_copies(problem->graph(), cheapest, count());
  return std::make_shared<const graphsolve::Symbolic>(problem->graph(), ordering);
}

void Stepper::make_solver(const Assembly& assembly, const Stepper* same) {
  plan = same ? same->plan : make_plan(assembly);
  const auto& symbolic = plan;
  const int n = bodies.size();
  size.body_nodes = n;
  size.joint_nodes = joints.size();
  size.rows = symbolic->rows();
  size.islands = symbolic->components();
  size.merged_bodies = static_cast<int>(lanes.size() * lanes[0].mechanism.bodies.size()) - n;
  size.frictionless_contacts = contacts->frictionless();
  size.operations = symbolic->counts().operations;
  size.fill_blocks = symbolic->counts().fill_blocks;
  size.stored_scalars = symbolic->counts().stored_scalars;
  island.resize(n);
  for (int i = 0; i < n; ++i) island[i] = symbolic->component(bodies.node(i));
  for (int lane = 0; lane < count(); ++lane) {
    auto& islands = lanes[lane].islands;
    for (int k = 0; k < bodies_per_lane; ++k) islands.push_back(island[body(lane, k)]);
    std::sort(islands.begin(), islands.end());
    islands.erase(std::unique(islands.begin(), islands.end()), islands.end());
    islands.shrink_to_fit();
  }
  noise.assign(symbolic->components(), 0.0);
  unknowns.assign(symbolic->rows(), 0.0);
  saved_impulses.assign(count() * impulses(0).size(), 0.0);
  for (auto* list : {&going_, &solving_, &solved_}) list->reserve(lanes.size());
  components_.reserve(symbolic->components());
  solver = std::make_unique<graphsolve::InteriorPoint>(
      *problem, plan,
      graphsolve::InteriorPointSettings{.tolerance = settings.tolerance, .start_part = start_part, .leave_out = leave_out});
  if (settings.time_phases) solver->set_profile(&profile);
}

JointGeometry Stepper::on_lane(int lane, JointGeometry geometry) const {
  for (int* side : {&geometry.parent, &geometry.child})
    if (*side >= 0) *side = body(lane, *side);
  return geometry;
}

void Stepper::load(int lane, Mechanism scene) {
  Assembly assembly = describe(lane, std::move(scene));
  start(lane, assembly);
}

Assembly Stepper::assembly(int lane) const {
  Assembly assembly = assemble(lanes[lane].mechanism, settings.merge_fixed_joints);
  weigh_islands(lane, assembly);
  return assembly;
}

void Stepper::weigh_islands(int lane, Assembly& assembly) const {
  std::vector<double> largest(noise.size(), 0.0);
  for (int k = 0; k < bodies_per_lane; ++k) {
    double& mass = largest[island[body(lane, k)]];
    mass = std::max(mass, assembly.bodies[k].mass);
  }
  for (int k = 0; k < bodies_per_lane; ++k) assembly.bodies[k].island_mass = largest[island[body(lane, k)]];
}

void Stepper::set_parameters(int lane, Assembly& assembly) {
  const Mechanism& scene = lanes[lane].mechanism;
  weigh_islands(lane, assembly);
  for (int k = 0; k < bodies_per_lane; ++k) bodies.set(body(lane, k), assembly.bodies[k], scene.gravity);
  for (int k = 0; k < joints_per_lane; ++k)
    joints.set(joint(lane, k), on_lane(lane, assembly.joints[k]), motor_of(scene, assembly.joints[k]));
  contacts->set(lane, scene, assembly);
  set_row_scales(lane, assembly);
}

/// Every row as a velocity: impulses over masses, angular ones over mass times radius of gyration.
void Stepper::set_row_scales(int lane, const Assembly& assembly) {
  const auto gyration = [&](int k) { return std::sqrt(assembly.bodies[k].smallest_inertia / assembly.bodies[k].mass); };
  double scale[6];
  for (int k = 0; k < bodies_per_lane; ++k) {
    const double m = assembly.bodies[k].mass;
    for (int r = 0; r < 6; ++r) scale[r] = r < 3 ? 1 / m : 1 / (m * gyration(k));
    solver->set_row_scale(bodies.node(body(lane, k)), scale);
  }
  for (int k = 0; k < joints_per_lane; ++k) {
    const JointGeometry& g = assembly.joints[k];
    const int j = joint(lane, k);
    const double radius = gyration(g.child >= 0 ? g.child : g.parent);
    for (int r = 0; r < joints.rows(j); ++r) scale[r] = r < joints.translation_rows(j) ? 1 : radius;
    if (joints.has_motor(j) && g.type == JointType::prismatic) scale[5] = 1;
    solver->set_row_scale(joints.nodes(j).front(), {scale, static_cast<std::size_t>(joints.rows(j))});
  }
}

}  // namespace physics
