#include <gtest/gtest.h>

#include "physics/scene_io.hpp"
#include "physics/simulator.hpp"
#include "support/reference_files.hpp"

namespace test_reference {

/// Trajectories of an independent dense oracle: the same scheme, another code and another solver.

using namespace physics;

double velocity_difference(const StepRecord& a, const StepRecord& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    largest = std::max(largest, (a.bodies[i].velocity - b.bodies[i].velocity).lpNorm<Eigen::Infinity>());
    largest = std::max(largest, (a.bodies[i].angular_velocity - b.bodies[i].angular_velocity).lpNorm<Eigen::Infinity>());
  }
  return largest;
}

double path_difference(const StepRecord& a, const StepRecord& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    largest = std::max(largest, (a.bodies[i].position - b.bodies[i].position).lpNorm<Eigen::Infinity>());
    const double same = (a.bodies[i].orientation.coeffs() - b.bodies[i].orientation.coeffs()).lpNorm<Eigen::Infinity>();
    const double flipped = (a.bodies[i].orientation.coeffs() + b.bodies[i].orientation.coeffs()).lpNorm<Eigen::Infinity>();
    largest = std::max(largest, std::min(same, flipped));
  }
  return largest;
}

/// An extra of the file format, as the JSON text it was.
std::string extra(const Extras& extras, const std::string& key) {
  for (const auto& [name, text] : extras)
    if (name == key) return text;
  return "";
}

Trajectory read(const std::string& name) {
  return read_scene(std::string(GRAPHSOLVE_SOURCE_DIR) + "/tests/data/reference/" + name + ".json");
}

class Reference : public testing::TestWithParam<std::string> {
 protected:
  static SimulatorSettings settings() {
    SimulatorSettings s;
    s.tolerance = 1e-11;
    return s;
  }
};

TEST_P(Reference, OneStepFromEveryStoredRecordReproducesTheVelocity) {
  const Trajectory file = read(GetParam());
  Simulator simulator(file.mechanism, settings());
  const double allowed = GetParam() == "mass_ratio_1e4" ? 1e-6 : 1e-8;
  int compared = 0;
  double worst = 0;
  StepRecord record;
  for (std::size_t k = 0; k + 1 < file.steps.size(); ++k) {
    const StepRecord &from = file.steps[k], &to = file.steps[k + 1];
    if (to.step != from.step + 1 || extra(to.extras, "x_unique") != "true") continue;
    simulator.restart_from(from);
    const StepResult result = simulator.step();
    ASSERT_TRUE(result.ok()) << "step " << to.step << ": " << graphsolve::name(result.status);
    EXPECT_EQ(result.substeps, 1) << "step " << to.step;
    simulator.write_record(record);
    const double difference = velocity_difference(record, to);
    EXPECT_LE(difference, allowed) << "step " << to.step;
    worst = std::max(worst, difference);
    ++compared;
  }
  EXPECT_GT(compared, 20);
  RecordProperty("compared", compared);
  std::printf("             %d steps compared, largest difference %.1e\n", compared, worst);
}

TEST_P(Reference, PathFromTheStartIsReproduced) {
  const Trajectory file = read(GetParam());
  const std::string first = extra(file.mechanism.extras, "x_first_nonunique");
  const int until = first.empty() || first == "null" ? file.steps.back().step : std::stoi(first) - 1;
  Simulator simulator(file.mechanism, settings());
  StepRecord record;
  double worst = 0;
  for (const StepRecord& expected : file.steps) {
    if (expected.step > until) break;
    while (simulator.step_index() < expected.step) {
      const StepResult result = simulator.step();
      ASSERT_TRUE(result.ok()) << "step " << simulator.step_index() + 1 << ": " << graphsolve::name(result.status);
    }
    simulator.write_record(record);
    const double difference = path_difference(record, expected);
    ASSERT_LE(difference, 1e-6) << "step " << expected.step;
    worst = std::max(worst, difference);
  }
  std::printf("             up to step %d, largest difference %.1e\n", until, worst);
}

INSTANTIATE_TEST_SUITE_P(Oracle, Reference, testing::ValuesIn(reference::names()),
                         [](const auto& test) { return test.param; });

}  // namespace test_reference
