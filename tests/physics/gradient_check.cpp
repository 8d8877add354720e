#include "gradient_check.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <vector>

namespace gradient_check {

using namespace physics;

namespace {

/// As exact as the differences need it, every body on its own.
SimulatorSettings tight() {
  SimulatorSettings settings;
  settings.tolerance = 1e-12;
  settings.merge_fixed_joints = false;
  return settings;
}

/// The scene and the record it goes on from, both to be disturbed.
struct Start {
  Mechanism scene;
  StepRecord record;
  bool from_record = false;
  int step = 1;  ///< the one that is differentiated
};

Start start_of(const Case& test) {
  Start start{.scene = test.scene, .record = {}};
  if (test.steps_before == 0) return start;
  Simulator simulator(test.scene, tight());
  for (int k = 0; k < test.steps_before; ++k) EXPECT_TRUE(simulator.step().ok());
  simulator.write_record(start.record);
  start.from_record = true;
  start.step = test.steps_before + 1;
  return start;
}

/// One step with its derivative at hand.
struct Stepped {
  Stepped(const Start& start, const GradientSettings& settings) : simulator(start.scene, tight()), gradient(simulator, settings) {
    if (start.from_record) simulator.restart_from(start.record);
    const StepResult result = simulator.step();
    EXPECT_TRUE(result.ok()) << result.cause;
    iterations = result.iterations;
    const GradientStatus status = gradient.evaluate();
    EXPECT_EQ(status, GradientStatus::ready) << explanation(status);
  }
  Simulator simulator;
  StepGradient gradient;
  int iterations = 0;
};

/// q exp(theta), theta = size along a coordinate
Quat turned(const Quat& q, int coordinate, double size) {
  return q * Quat(Eigen::AngleAxisd(size, Vec3::Unit(coordinate)));
}

template <class Body>
void disturb_state(Body& body, int coordinate, double size) {
  const int c = coordinate % 3;
  switch (coordinate / 3) {
    case 0: body.position[c] += size; break;
    case 1: body.orientation = turned(body.orientation, c, size); break;
    case 2: body.velocity[c] += size; break;
    default: body.angular_velocity[c] += size;
  }
}

/// Effort on joint j: the motor's target moves, or the two bodies are loaded.
void disturb_effort(Start& start, int j, double size) {
  Joint& joint = start.scene.joints[j];
  if (joint.motor) {
    ASSERT_GT(joint.motor->stiffness, 0);
    const double move = size / joint.motor->stiffness;
    if (auto* sine = std::get_if<SineTarget>(&joint.motor->target)) sine->offset += move;
    else if (auto* table = std::get_if<TableTarget>(&joint.motor->target)) {
      for (auto& entry : *table) entry.second += move;
    } else {
      std::get<double>(joint.motor->target) += move;
    }
    return;
  }
  if (joint.type != JointType::revolute && joint.type != JointType::prismatic) return;
  const auto pose = [&](BodyId body) -> std::pair<Vec3, Quat> {
    if (body.is_world()) return {Vec3::Zero(), Quat::Identity()};
    if (start.from_record) return {start.record.bodies[body.index].position, start.record.bodies[body.index].orientation};
    return {start.scene.bodies[body.index].position, start.scene.bodies[body.index].orientation};
  };
  const auto [xa, qa] = pose(joint.parent);
  const auto [xb, qb] = pose(joint.child);
  const Vec3 axis = size * (qa * joint.axis), at = xb + qb * joint.child_point;
  const bool slides = joint.type == JointType::prismatic;
  const auto push = [&](BodyId body, const Vec3& x, const Quat& q, double sign) {
    if (body.is_world()) return;
    Load load;
    load.body = body;
    load.first_step = load.last_step = start.step;
    if (slides) load.force = sign * axis;
    load.torque = q.conjugate() * (slides ? Vec3((at - x).cross(sign * axis)) : Vec3(sign * axis));
    start.scene.add(load);
  };
  push(joint.child, xb, qb, 1);
  push(joint.parent, xa, qa, -1);
}

void disturb(Start& start, StepInput input, int column, double size) {
  switch (input) {
    case StepInput::state:
      if (start.from_record) disturb_state(start.record.bodies[column / 12], column % 12, size);
      else disturb_state(start.scene.bodies[column / 12], column % 12, size);
      break;
    case StepInput::load: {
      Load load;
      load.body = {column / 6};
      load.first_step = load.last_step = start.step;
      (column % 6 < 3 ? load.force : load.torque)[column % 3] = size;
      start.scene.add(load);
      break;
    }
    case StepInput::effort: disturb_effort(start, column, size); break;
    case StepInput::friction: {
      auto& friction = start.scene.contacts[column].friction;
      if (friction.value_or(0) > 0) *friction += size;
      break;
    }
    case StepInput::mass: start.scene.bodies[column].mass += size; break;
    case StepInput::inertia: {
      static constexpr int places[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
      const auto [r, c] = places[column % 6];
      Mat3& inertia = start.scene.bodies[column / 6].inertia;
      inertia(r, c) += size;
      if (r != c) inertia(c, r) += size;
    }
  }
}

double difference_step(const Start& start, StepInput input, int column) {
  switch (input) {
    case StepInput::state: return column % 12 < 6 ? 1e-6 : 1e-5;
    case StepInput::load:
    case StepInput::effort: return 1e-2;
    case StepInput::friction: return 1e-5;
    case StepInput::mass: return 3e-4 * start.scene.bodies[column].mass;
    // Felt least of all: a step at which the rounding of a solve (1e-12) and what the difference cuts off both stay below.
    case StepInput::inertia: return 6e-4 * start.scene.bodies[column / 6].inertia.diagonal().minCoeff();
  }
  return 0;
}

/// Difference of two states, rotations as rotation vectors.
Eigen::VectorXd difference(const StepGradient& plus, const StepGradient& minus) {
  Eigen::VectorXd d(plus.state_size());
  for (int i = 0; i < plus.moving_bodies(); ++i) {
    const Eigen::AngleAxisd turn(minus.orientation(i).conjugate() * plus.orientation(i));
    d.segment<3>(12 * i) = plus.position(i) - minus.position(i);
    d.segment<3>(12 * i + 3) = turn.angle() * turn.axis();
    for (int c = 0; c < 6; ++c) d[12 * i + 6 + c] = plus.velocity(i)[c] - minus.velocity(i)[c];
  }
  return d;
}

}  // namespace

Comparison compare(const Case& test, StepInput input) {
  const Start start = start_of(test);
  Stepped at(start, test.gradient);
  EXPECT_EQ(at.gradient.moving_bodies(), static_cast<int>(test.scene.bodies.size()));
  Comparison result;
  result.iterations = at.iterations;
  const int height = at.gradient.state_size(), width = at.gradient.columns(input);
  result.jacobian.resize(height, width);
  result.differences.resize(height, width);
  at.gradient.jacobian(input, {result.jacobian.data(), static_cast<std::size_t>(result.jacobian.size())});
  for (int c = 0; c < width; ++c) {
    const double h = test.closer * difference_step(start, input, c);
    Start plus = start, minus = start;
    disturb(plus, input, c, h);
    disturb(minus, input, c, -h);
    result.differences.col(c) =
        difference(Stepped(plus, test.gradient).gradient, Stepped(minus, test.gradient).gradient) / (2 * h);
  }
  if (width == 0) return result;
  // Columns that are zero but for rounding are compared with what a free body of 1 kg makes of the input.
  const bool force = input == StepInput::load || input == StepInput::effort;
  const double floor = std::max(force ? at.simulator.time_step() : 0.1,
                                1e-3 * result.differences.lpNorm<Eigen::Infinity>());
  for (int c = 0; c < width; ++c) {
    Eigen::Index row = 0;
    const double off = (result.jacobian.col(c) - result.differences.col(c)).cwiseAbs().maxCoeff(&row);
    const double size = std::max(floor, result.differences.col(c).lpNorm<Eigen::Infinity>());
    if (off == 0 || off / size <= result.largest_error) continue;
    result.largest_error = off / size;
    result.where = fmt::format("row {}, column {}: {} instead of {}", row, c, result.jacobian(row, c), result.differences(row, c));
  }
  return result;
}

double transposed_error(const Case& test, double least) {
  Stepped at(start_of(test), test.gradient);
  std::mt19937_64 random{5};
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::VectorXd adjoint(at.gradient.state_size()), gradient(at.gradient.gradient_size());
  for (double& a : adjoint) a = uniform(random);
  at.gradient.vector_jacobian({adjoint.data(), static_cast<std::size_t>(adjoint.size())},
                              {gradient.data(), static_cast<std::size_t>(gradient.size())});
  double largest = 0;
  for (const StepInput input : {StepInput::state, StepInput::load, StepInput::effort, StepInput::friction,
                                StepInput::mass, StepInput::inertia}) {
    Eigen::MatrixXd jacobian(adjoint.size(), at.gradient.columns(input));
    if (jacobian.cols() == 0) continue;
    at.gradient.jacobian(input, {jacobian.data(), static_cast<std::size_t>(jacobian.size())});
    const Eigen::VectorXd expected = jacobian.transpose() * adjoint;
    const double off = (gradient.segment(at.gradient.offset(input), jacobian.cols()) - expected).lpNorm<Eigen::Infinity>();
    if (off > 0) largest = std::max(largest, off / std::max(least, expected.lpNorm<Eigen::Infinity>()));
  }
  return largest;
}

}  // namespace gradient_check
