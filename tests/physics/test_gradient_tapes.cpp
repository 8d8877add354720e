#include <gtest/gtest.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "physics/gradients.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_gradient_tapes {

/// Derivatives through many steps, one StepGradient for each, against central differences of whole runs.

using namespace physics;

SimulatorSettings tight() {
  SimulatorSettings settings;
  settings.tolerance = 1e-12;
  return settings;
}

/// Where the first body ends.
Vec3 end_of(const Mechanism& scene, int steps) {
  Simulator simulator(scene, tight());
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(simulator.step().ok());
  StepRecord record;
  simulator.write_record(record);
  return record.bodies[0].position;
}

struct Gradient {
  Vec3 velocity, spin;
  double friction;
};

/// Of the entry `row` of the last state; rows 0 to 2 are the place.
Gradient by_tape(const Mechanism& scene, int steps, int row) {
  Simulator simulator(scene, tight());
  std::vector<StepGradient> tape;
  for (int k = 0; k < steps; ++k) tape.emplace_back(simulator);
  for (StepGradient& step : tape) {
    EXPECT_TRUE(simulator.step().ok());
    EXPECT_EQ(step.evaluate(), GradientStatus::ready);
  }
  const int states = tape[0].state_size();
  Eigen::VectorXd adjoint = Eigen::VectorXd::Unit(states, row), all(tape[0].gradient_size());
  Gradient result{};
  for (auto step = tape.rbegin(); step != tape.rend(); ++step) {
    step->vector_jacobian({adjoint.data(), static_cast<std::size_t>(states)}, {all.data(), static_cast<std::size_t>(all.size())});
    adjoint = all.segment(step->offset(StepInput::state), states);
    result.friction += all.segment(step->offset(StepInput::friction), step->columns(StepInput::friction)).sum();
  }
  result.velocity = adjoint.segment<3>(6);
  result.spin = adjoint.segment<3>(9);
  return result;
}

double difference(const Mechanism& scene, int steps, int row, const std::function<void(Mechanism&, double)>& change) {
  constexpr double h = 1e-6;
  Mechanism more = scene, less = scene;
  change(more, h), change(less, -h);
  return (end_of(more, steps)[row] - end_of(less, steps)[row]) / (2 * h);
}

void expect_agreement(const Mechanism& scene, int steps, double tolerance) {
  for (const int row : {0, 1}) {
    const Gradient tape = by_tape(scene, steps, row);
    const double scale = tolerance * steps * scene.time_step;
    const auto by = [&](const std::function<void(Mechanism&, double)>& change) { return difference(scene, steps, row, change); };
    for (const int axis : {0, 1})
      EXPECT_NEAR(tape.velocity[axis], by([&](Mechanism& m, double h) { m.bodies[0].velocity[axis] += h; }), scale)
          << scene.name << ", row " << row << " by velocity " << axis;
    EXPECT_NEAR(tape.spin.z(), by([](Mechanism& m, double h) { m.bodies[0].angular_velocity.z() += h; }), scale)
        << scene.name << ", row " << row << " by spin";
    const auto rougher = [](Mechanism& m, double h) {
      for (Contact& contact : m.contacts) *contact.friction += h;
    };
    EXPECT_NEAR(tape.friction, by(rougher), scale) << scene.name << ", row " << row << " by friction";
  }
}

/// Three contacts that slip in directions of their own while the disc turns.
TEST(GradientTape, ThroughAFixedPyramidIsThatOfTheWholeRun) {
  expect_agreement(built_in_scene("disc:c=3,height=0,spin=2,model=pyramid"), 20, 1e-3);
  expect_agreement(built_in_scene("sliding_box:heading=30,model=pyramid"), 20, 1e-3);
}

}  // namespace test_gradient_tapes
