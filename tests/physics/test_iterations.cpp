// Newton iterations at the default tolerance, by what happens in the step. Steps are sorted by their records.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <utility>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_iterations {

using namespace physics;

enum Regime { free_flight, rest, slide, impact, regimes };
constexpr std::array<const char*, regimes> regime_names{"free", "rest", "slide", "impact"};
constexpr std::array<double, regimes> allowed_mean{2, 1, 6, 9};

constexpr double touching = 1e-6;  // [m]
constexpr double still = 1e-3;     // [m/s, rad/s]

struct Count {
  int steps = 0, most = 0;
  long long iterations = 0;

  void add(int step_iterations) {
    ++steps;
    iterations += step_iterations;
    most = std::max(most, step_iterations);
  }
  void add(const Count& other) {
    steps += other.steps;
    iterations += other.iterations;
    most = std::max(most, other.most);
  }
  [[nodiscard]] double mean() const { return steps == 0 ? 0 : static_cast<double>(iterations) / steps; }
};
using Counts = std::array<Count, regimes>;

/// Impact: a gap closes. Slide: something touches and something moves (rolling and rocking too).
Regime regime_of(const StepRecord& before, const StepRecord& after) {
  bool touches = false, closes = false, moves = false;
  for (std::size_t i = 0; i < after.contacts.size(); ++i) {
    const bool now = after.contacts[i].distance <= touching;
    touches |= now;
    closes |= now && before.contacts[i].distance > touching;
  }
  for (const BodyRecord& body : after.bodies)
    moves |= body.velocity.norm() > still || body.angular_velocity.norm() > still;
  return closes ? impact : !touches ? free_flight : moves ? slide : rest;
}

Counts count(const std::string& spec, double duration) {
  Simulator simulator(built_in_scene(spec));
  Counts counts;
  StepRecord before, after;
  simulator.write_record(before);
  for (long k = std::lround(duration / simulator.time_step()); k > 0; --k) {
    const StepResult result = simulator.step();
    EXPECT_TRUE(result.ok()) << spec << ", step " << simulator.step_index() + 1 << ": " << result.cause;
    if (!result.ok()) break;
    simulator.write_record(after);
    counts[regime_of(before, after)].add(result.iterations);
    std::swap(before, after);
  }
  return counts;
}

void print(const std::string& what, const Counts& counts) {
  std::printf("             %-34s", what.c_str());
  for (int r = 0; r < regimes; ++r) {
    if (counts[r].steps > 0)
      std::printf("  %s %.2f (%d, max %d)", regime_names[r], counts[r].mean(), counts[r].steps, counts[r].most);
  }
  std::printf("\n");
}

/// Bars one regime: over all scenes together, each scene with the same weight, and in each scene on its own.
/// A scene in which the regime lasts a few steps says nothing on its own.
void expect_few(Regime regime, std::initializer_list<std::pair<const char*, double>> specs, int lasting = 10) {
  double sum_of_means = 0;
  int scenes = 0;
  Count all;
  for (const auto& [spec, duration] : specs) {
    const Counts counts = count(spec, duration);
    print(spec, counts);
    const Count& c = counts[regime];
    ASSERT_GT(c.steps, 0) << spec << " has no such step";
    if (c.steps >= lasting) {
      EXPECT_LE(c.mean(), allowed_mean[regime]) << spec;
    }
    sum_of_means += c.mean();
    ++scenes;
    all.add(c);
  }
  EXPECT_LE(sum_of_means / scenes, allowed_mean[regime]);
  EXPECT_LE(all.mean(), allowed_mean[regime]);
  std::printf("             %s: %.2f over %d steps, %.2f over %d scenes, %d at most\n", regime_names[regime],
              all.mean(), all.steps, sum_of_means / scenes, scenes, all.most);
}

TEST(Iterations, OfFreeFlightAreTwoAtMostOnAverage) {
  expect_few(free_flight, {{"free_box", 1},
                           {"free_top", 1},
                           {"pendulum", 2},
                           {"spinning_top", 1},
                           {"disc:height=2", 0.6},
                           {"tumbling_box:height=3", 0.6},
                           {"snake:n=20,height=1", 0.4}});
}

/// Swinging chains and loops at 10 ms curve more within a step than a body in flight does.
TEST(Iterations, OfSwingingLoopsAndChainsAreThreeAtMostOnAverage) {
  for (const char* spec : {"loop", "loop:n=40", "four_bar", "pendulum:n=3", "pendulum:n=10,dt=0.001"}) {
    const Counts counts = count(spec, 1);
    print(spec, counts);
    EXPECT_LE(counts[free_flight].mean(), 3) << spec;
  }
}

TEST(Iterations, OfRestingThingsAreOneAtMostOnAverage) {
  expect_few(rest, {{"sliding_box:speed=0", 1},
                    {"box_on_slope", 1},
                    {"box_on_slope:fraction=0.5,dt=0.001", 1},
                    {"box_on_slope:fraction=0.99", 1},
                    {"tumbling_box", 3},
                    {"disc:c=100", 3},
                    {"snake:n=20,speed=0", 2}});
}

/// Motors that hold a stand let it creep on, slower than what counts as rest here: a step more often than not has to be
/// taken, not only looked at.
TEST(Iterations, OfAQuadrupedThatStandsAreOneAndAHalfAtMostOnAverage) {
  const Counts counts = count("quadruped:frequency=0", 2);
  print("quadruped:frequency=0", counts);
  ASSERT_GT(counts[rest].steps, 0);
  EXPECT_LE(counts[rest].mean(), 1.5);
}

TEST(Iterations, OfSlidingThingsAreSixAtMostOnAverage) {
  expect_few(slide, {{"sliding_box:heading=30", 0.6},
                     {"sliding_box:heading=30,model=pyramid", 0.6},
                     {"box_on_slope:fraction=1.3", 1},
                     {"disc:c=30,spin=6,height=0", 0.5},
                     {"snake:n=20,height=0", 0.4},
                     {"snake:n=100", 0.5},
                     {"spinning_sphere", 0.5},
                     {"pads:ratio=10,speed=1", 0.2}});
}

/// Impacts are single steps: the bar is on the mean over the impacts of many falls.
TEST(Iterations, OfImpactsAreNineAtMostOnAverage) {
  expect_few(impact,
             {{"tumbling_box", 3},
              {"tumbling_box:mu=0.1", 3},
              {"tumbling_box:mu=1,height=1", 3},
              {"tumbling_box:height=1.5,dt=0.002", 3},
              {"tumbling_box:height=2,model=pyramid", 3},
              {"tumbling_box:height=3,dt=0.005", 3},
              {"disc:c=2", 1},
              {"disc:c=30,spin=6", 1},
              {"disc:c=100,height=1", 1},
              {"snake:n=2", 1},
              {"snake:n=10", 1},
              {"snake:n=40", 1},
              {"snake:n=20,speed=0", 1},
              {"snake:n=10,model=pyramid", 1},
              {"hopper", 1.2},
              {"quadruped:lift=0.03", 1}},
             1000);
}

TEST(Iterations, OfTheWalkingQuadrupedAreSixAtMostOnAverage) {
  for (const char* spec : {"quadruped", "quadruped:lift=0.02", "quadruped:lift=0.03"}) {
    const Counts counts = count(spec, 3);
    Count all;
    for (const Count& c : counts) all.add(c);
    print(spec, counts);
    EXPECT_LE(all.mean(), 6) << spec;
    std::printf("             %.2f on average, %d at most\n", all.mean(), all.most);
  }
}

/// A barrier that follows the tolerance would end above the largest product that a solution may have, and every step,
/// started there, would go down to it once more.
TEST(Iterations, OfALooserToleranceAreNotMore) {
  for (const char* spec : {"sliding_box", "disc:c=20", "snake:n=20", "box_on_slope", "pads", "tumbling_box", "hopper"}) {
    const auto mean = [&](double tolerance) {
      SimulatorSettings settings;
      settings.tolerance = tolerance;
      Simulator simulator(built_in_scene(spec), settings);
      Count count;
      for (int k = 0; k < 150; ++k) count.add(simulator.step().iterations);
      return count.mean();
    };
    const double usual = mean(1e-8);
    for (const double tolerance : {1e-6, 1e-5, 1e-4, 1e-3})
      EXPECT_LE(mean(tolerance), usual + 0.5) << spec << ", tolerance " << tolerance << " m/s";
  }
}

}  // namespace test_iterations
