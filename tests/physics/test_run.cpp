#include <gtest/gtest.h>

#include <cmath>

#include "physics/run.hpp"
#include "physics/scenes.hpp"

namespace test_run {

using namespace physics;

/// Spun up in step 5 far beyond what any substep can follow.
Mechanism scene_that_fails_in_step_5() {
  Mechanism scene = built_in_scene("free_box");
  scene.add(Load{.body = {0}, .first_step = 5, .last_step = 5, .torque = Vec3(0, 0, 1e9)});
  return scene;
}

TEST(Run, MakesTheStepsThatASimulatorAloneMakes) {
  Simulator alone(built_in_scene("snake:n=3")), driven(built_in_scene("snake:n=3"));
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(alone.step().ok());
  const RunResult result = run(driven, 50);
  EXPECT_TRUE(result.ok());
  EXPECT_EQ(result.summary.steps, 50);
  StepRecord a, b;
  alone.write_record(a);
  driven.write_record(b);
  for (std::size_t i = 0; i < a.bodies.size(); ++i) EXPECT_EQ(a.bodies[i].position, b.bodies[i].position);
}

TEST(Run, SummarisesWhatItsStepsSay) {
  Simulator simulator(built_in_scene("disc"));
  RunOptions options;
  long long iterations = 0;
  int most = 0;
  double distance = simulator.smallest_distance();
  const double energy = simulator.energy();
  options.on_step = [&](const Simulator& now, const StepResult& step) {
    iterations += step.iterations;
    most = std::max(most, step.iterations);
    distance = std::min(distance, now.smallest_distance());
    return true;
  };
  const RunSummary s = run(simulator, 100, options).summary;
  EXPECT_EQ(s.iterations, iterations);
  EXPECT_EQ(s.most_iterations, most);
  EXPECT_EQ(s.distance.value, distance);
  EXPECT_EQ(s.energy_start, energy);
  EXPECT_EQ(s.energy_end, simulator.energy());
  EXPECT_EQ(s.momentum_start, Vec3(1, 0.4, 0));
  EXPECT_EQ(s.momentum_end, simulator.linear_momentum());
  EXPECT_NEAR(s.simulated_time, 1.0, 1e-12);
  ASSERT_EQ(s.statuses.size(), 1u);
  EXPECT_EQ(s.statuses[0], std::pair(graphsolve::Status::solved, 100));
  EXPECT_EQ(s.size.contact_steps, 800);
}

/// Before, energy was told of the pose before the step, and a record knows only the one after it.
TEST(Run, CutInTwoStartsAgainWithTheEnergyItEndedWith) {
  for (const char* name : {"free_box", "pendulum:n=3", "snake:n=3", "disc", "quadruped", "hanging_bob"}) {
    for (const Start start : {Start::half_kick, Start::standard}) {
      Mechanism scene = built_in_scene(name);
      scene.start = start;
      Simulator whole(scene), rest(scene);
      StepRecord record;
      for (int part = 0; part < 3; ++part) {
        const RunResult first = run(whole, 10);
        ASSERT_TRUE(first.ok()) << name;
        whole.write_record(record);
        rest.restart_from(record);
        const double size = std::abs(first.summary.energy_end) + std::abs(whole.linear_momentum().norm());
        EXPECT_NEAR(run(rest, 0).summary.energy_start, first.summary.energy_end, 1e-12 * size) << name;
      }
    }
  }
}

/// Its velocities are those of the pose where the scene says so: no step led there.
TEST(Run, ContinuedFromItsStartIsTheSameRun) {
  for (const Start start : {Start::half_kick, Start::standard}) {
    Mechanism scene = built_in_scene("snake:n=3");
    scene.start = start;
    Simulator whole(scene), again(scene);
    StepRecord first, expected, found;
    whole.write_record(first);
    again.restart_from(first);
    EXPECT_EQ(again.energy(), whole.energy());
    for (int k = 0; k < 30; ++k) ASSERT_TRUE(whole.step().ok() && again.step().ok());
    whole.write_record(expected);
    again.write_record(found);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE((found.bodies[i].position - expected.bodies[i].position).norm(), 1e-9) << static_cast<int>(start);
  }
}

TEST(Run, RecordsTheStartAndEveryStep) {
  Simulator simulator(built_in_scene("pendulum"));
  std::vector<int> steps;
  RunOptions options;
  options.record = [&](const StepRecord& record) { steps.push_back(record.step); };
  EXPECT_TRUE(run(simulator, 3, options).ok());
  EXPECT_EQ(steps, (std::vector{0, 1, 2, 3}));
}

TEST(Run, StopsWhenAsked) {
  Simulator simulator(built_in_scene("pendulum"));
  RunOptions options;
  options.on_step = [](const Simulator& now, const StepResult&) { return now.step_index() < 7; };
  const RunResult result = run(simulator, 100, options);
  EXPECT_TRUE(result.stopped);
  EXPECT_TRUE(result.ok());
  EXPECT_EQ(result.summary.steps, 7);
}

TEST(Run, EndsAtAStepThatFailsAndKeepsTheStateBeforeIt) {
  Simulator simulator(scene_that_fails_in_step_5());
  int records = 0;
  RunOptions options;
  options.record = [&](const StepRecord&) { ++records; };
  const RunResult result = run(simulator, 100, options);
  EXPECT_FALSE(result.ok());
  EXPECT_EQ(result.last.status, graphsolve::Status::step_bound);
  EXPECT_FALSE(result.last.cause.empty());
  EXPECT_EQ(result.summary.steps, 4);
  EXPECT_EQ(simulator.step_index(), 4);
  EXPECT_EQ(records, 5);
  EXPECT_EQ(result.summary.statuses.size(), 2u);
  ASSERT_TRUE(result.failure);
  EXPECT_EQ(result.failure->step, 5);
  EXPECT_EQ(result.failure->status, "step_bound");
  EXPECT_EQ(result.failure->place, simulator.failure_place());
  EXPECT_EQ(result.failure->cause, result.last.cause);
  EXPECT_FALSE(run(simulator, 0).failure);
}

TEST(Run, OfASecondStretchCountsOnlyThatStretch) {
  Simulator simulator(built_in_scene("pendulum"));
  const RunResult first = run(simulator, 10), second = run(simulator, 5);
  EXPECT_EQ(second.summary.first_step, 10);
  EXPECT_EQ(second.summary.steps, 5);
  EXPECT_NEAR(second.summary.simulated_time, 0.05, 1e-12);
}

TEST(Run, PhasesOfAStretchAreItsOwn) {
  SimulatorSettings settings;
  settings.time_phases = true;
  Simulator simulator(built_in_scene("pendulum"), settings);
  const RunResult first = run(simulator, 10), second = run(simulator, 5);
  EXPECT_GT(second.summary.phases.total(), 0);
  EXPECT_LE(first.summary.phases.total() + second.summary.phases.total(), simulator.phase_times().total() * (1 + 1e-9));
}

TEST(Run, PhasesAreTimedOnlyOnRequest) {
  Simulator simulator(built_in_scene("pendulum"));
  (void)run(simulator, 10);
  EXPECT_EQ(simulator.phase_times().total(), 0);
}

}  // namespace test_run
