#include <gtest/gtest.h>

#include <random>

#include "terms/bodies.hpp"
#include "terms/contact_port.hpp"
#include "graphsolve/derivative_check.hpp"
#include "graphsolve/ordering.hpp"
#include "terms/joints.hpp"
#include "terms/pyramid_law.hpp"

namespace test_derivatives {

/// Every term, port and law of the simulator against central differences, in general position in space.

using namespace physics;
using graphsolve::NodeId;

constexpr int only_copy[] = {0};

class Derivatives : public testing::Test {
 protected:
  std::mt19937_64 random{17};
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Quat rotation() { return Quat(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized(); }
  Mat3 inertia() {
    const Mat3 r = rotation().toRotationMatrix();
    return r * Vec3(0.4, 0.7, 0.9).asDiagonal() * r.transpose();
  }

  /// Two bodies at random poses, 0.05 s.
  void two_bodies() {
    bodies.dt = 0.05;
    for (int i = 0; i < 2; ++i) {
      bodies.add({.name = "b", .mass = 1.3 + i, .inertia = inertia(), .smallest_inertia = 0.4}, {i});
      const Vec3 x = vector(1);
      bodies.place(i, x, rotation());
      const Vec3 linear = vector(1);
      bodies.add_known(i, linear, vector(1));
    }
  }
  /// A joint in general position that the poses do satisfy at the start (so that the force directions make sense).
  JointGeometry joint(JointType type, int parent, int child) {
    const Pose a = bodies.pose_now(parent), b = bodies.pose_now(child);
    JointGeometry g{.source = 0, .type = type, .parent = parent, .child = child, .parent_point = vector(0.5),
                    .child_point = vector(0.5), .axis = vector(1).normalized(), .orientation = Quat::Identity()};
    g.orientation = a.q.conjugate() * b.q;
    g.parent_point = a.rotation.transpose() * (b.x + b.rotation * g.child_point - a.x);
    return g;
  }
  /// Only then are there places for force directions.
  void wire(graphsolve::BlockGraph& graph, Joints& joints) {
    for (const NodeId node : joints.nodes(0).subspan(1)) graph.add_edge(joints.nodes(0)[0], node);
    const graphsolve::Symbolic symbolic(graph, graphsolve::natural_ordering(graph));
    const graphsolve::Wiring wiring(symbolic, graph);
    bodies.wire(wiring);
    joints.wire(wiring);
  }
  Bodies bodies;
};

class JointDerivatives : public Derivatives, public testing::WithParamInterface<std::tuple<JointType, bool, int>> {};

TEST_P(JointDerivatives, MatchCentralDifferences) {
  const auto [type, with_motor, world_side] = GetParam();
  for (int trial = 0; trial < 5; ++trial) {
    bodies = Bodies();
    two_bodies();
    Motor motor{.stiffness = 30, .damping = 2, .limit = trial == 4 ? 0.01 : 1e9, .target = 0.3};
    const Motor* driven = with_motor ? &motor : nullptr;
    const JointGeometry g = joint(type, world_side == 1 ? -1 : 0, world_side == 2 ? -1 : 1);
    graphsolve::BlockGraph graph;
    graph.add_node("a", 6);
    graph.add_node("b", 6);
    const NodeId node = graph.add_node("joint", Joints::rows_of(g, driven), graphsolve::NodeKind::saddle);
    Joints joints(bodies);
    joints.add(g, driven, node);
    wire(graph, joints);
    joints.reset_coordinate(0);
    joints.prepare(0, 0.1, bodies.dt);
    joints.aim(only_copy);
    graphsolve::Problem problem(graph);
    problem.add(bodies);
    problem.add(joints);
    std::vector<double> x(graph.rows());
    for (double& value : x) value = uniform(-3, 3);
    const auto report = graphsolve::check_terms(problem, x, 1e-5);
    EXPECT_LE(report.largest_error, 2e-7) << report.where << ", trial " << trial;
  }
}

TEST_F(Derivatives, SphericalJointWithForcesAtTheNewConfigurationMatchesCentralDifferences) {
  two_bodies();
  const JointGeometry g = joint(JointType::spherical, 0, 1);
  graphsolve::BlockGraph graph;
  graph.add_node("a", 6);
  graph.add_node("b", 6);
  Joints joints(bodies);
  joints.add(g, nullptr, graph.add_node("joint", 3, graphsolve::NodeKind::saddle));
  wire(graph, joints);
  joints.prepare(0, 0.1, bodies.dt);
  joints.aim(only_copy);
  bodies.force_at_next = true;
  graphsolve::Problem problem(graph);
  problem.add(bodies);
  problem.add(joints);
  std::vector<double> x(graph.rows());
  for (double& value : x) value = uniform(-3, 3);
  const auto report = graphsolve::check_terms(problem, x, 1e-5);
  EXPECT_LE(report.largest_error, 2e-7) << report.where;
}

std::string case_name(const testing::TestParamInfo<std::tuple<JointType, bool, int>>& info) {
  static const char* types[] = {"fixed", "revolute", "prismatic", "spherical"};
  static const char* worlds[] = {"", "_parent_world", "_child_world"};
  return std::string(types[static_cast<int>(std::get<0>(info.param))]) + (std::get<1>(info.param) ? "_motor" : "") +
         worlds[std::get<2>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Passive, JointDerivatives,
                         testing::Combine(testing::Values(JointType::fixed, JointType::revolute, JointType::prismatic,
                                                          JointType::spherical),
                                          testing::Values(false), testing::Values(0, 1, 2)),
                         case_name);
INSTANTIATE_TEST_SUITE_P(Driven, JointDerivatives,
                         testing::Combine(testing::Values(JointType::revolute, JointType::prismatic),
                                          testing::Values(true), testing::Values(0, 1, 2)),
                         case_name);

TEST_F(Derivatives, ContactPortMatchesCentralDifferences) {
  bodies.dt = 0.05;
  bodies.add({.name = "b", .mass = 1, .inertia = inertia(), .smallest_inertia = 0.4}, {0});
  const Vec3 x0 = vector(1);
  bodies.place(0, x0, rotation());
  graphsolve::BlockGraph graph;
  graph.add_node("b", 6);
  const graphsolve::Symbolic symbolic(graph, graphsolve::natural_ordering(graph));
  const graphsolve::Wiring wiring(symbolic, graph);
  bodies.wire(wiring);

  /// The port reads the body's pose, which the body's own evaluation makes from x.
  struct WithBody : ContactPort<3> {
    WithBody(const ContactPort<3>& port, Bodies& b) : ContactPort<3>(port), bodies(b) {}
    void evaluate(std::span<const double> x, double* u) {
      const int zero[] = {0};
      std::vector<double> residual(6);
      bodies.evaluate({zero, zero}, x, residual, nullptr);
      ContactPort<3>::evaluate(x, u);
    }
    Bodies& bodies;
  };
  const Vec3 normal = vector(1).normalized();
  WithBody port(ContactPort<3>(bodies, 0, vector(0.5), normal, 0.1, 0.07), bodies);
  port.wire(wiring);
  port.set_tangent(normal.unitOrthogonal());
  port.prepare();
  std::vector<double> x(6);
  for (const SlipMeasure slip : {SlipMeasure::velocity, SlipMeasure::displacement}) {
    port.set_slip(slip);
    for (double& value : x) value = uniform(-3, 3);
    const auto report = graphsolve::check_port(port, x, 1e-5);
    EXPECT_LE(report.largest_error, 1e-7) << report.where;
  }
}

template <class Law>
void expect_consistent(Law law, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  law.start_cold(0.6, 1.5);
  for (int step = 0; step < 6; ++step) {  // from the central start into ever less balanced points
    const double u[] = {uniform(random), uniform(random), uniform(random)};
    const double du[] = {uniform(random), uniform(random), uniform(random)};
    Law at = law;
    const auto report = graphsolve::check_law(at, u, du, 0.02, 1e-6);
    EXPECT_LE(report.largest_error, 1e-3) << report.where << " at step " << step;
    double f[3], k[9];
    law.residual(u, f);
    law.condense(1e300, k);
    law.right_hand_side(0.02, 0.0, f);
    law.recover(du);
    law.accept(0.9 / std::max(1.0, law.boundary_ratio()));
  }
}

TEST_F(Derivatives, PyramidLawsTakeConsistentNewtonSteps) {
  expect_consistent(PyramidLaw<4>(0.4, 1.5, 1e300), random);
  expect_consistent(PyramidLaw<0>(0.4, 1.5, 1e300, 4), random);
  expect_consistent(PyramidLaw<0>(0.7, 1.5, 1e300, 10), random);
}

TEST_F(Derivatives, FourFacetsFromTheTableAndFromTheShortFormCondenseEqually) {
  PyramidLaw<4> four(0.4, 1.5, 1e300);
  PyramidLaw<0> any(0.4, 1.5, 1e300, 4);
  four.start_cold(0.6, 1.5);
  any.start_cold(0.6, 1.5);
  for (int step = 0; step < 6; ++step) {
    const double u[] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
    double f[2][3], k[2][9];
    const auto advance = [&](auto& law, int which) {
      law.residual(u, f[which]);
      law.condense(1e300, k[which]);
      law.right_hand_side(0.02, 0.0, f[which]);
      const double du[] = {0.1, -0.3, 0.2};
      law.recover(du);
      law.accept(0.9 / std::max(1.0, law.boundary_ratio()));
    };
    advance(four, 0);
    advance(any, 1);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(k[0][i], k[1][i], 1e-9 * (1 + std::abs(k[0][i]))) << i << " at step " << step;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(f[0][i], f[1][i], 1e-9 * (1 + std::abs(f[0][i])));
  }
}

}  // namespace test_derivatives
