// The paper's four scenes: disc and snake of any size, the hopper's jump, the quadruped's walk.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "graphsolve/symbolic.hpp"
#include "physics/run.hpp"
#include "physics/scenes.hpp"

namespace test_paper_scenes {

using namespace physics;

constexpr double deepest = -1e-9;      // [m]
constexpr double widest_joint = 1e-9;  // [m, rad]

/// Runs a scene that must solve every step, without substeps and without breaking through anything.
RunSummary run_well(Mechanism scene, int steps, const RunOptions& options = {}) {
  Simulator simulator(std::move(scene));
  const RunResult result = run(simulator, steps, options);
  EXPECT_TRUE(result.ok()) << "step " << simulator.step_index() + 1 << ": " << result.last.cause;
  EXPECT_EQ(result.summary.steps, steps);
  EXPECT_EQ(result.summary.substepped_steps, 0);
  EXPECT_EQ(result.summary.turned_steps, 0);
  EXPECT_GE(result.summary.distance.value, deepest) << "step " << result.summary.distance.step;
  EXPECT_LE(result.summary.joint_error.value, widest_joint) << "step " << result.summary.joint_error.step;
  return result.summary;
}

/// Touching the ground is what makes such a run worth something.
void expect_landed(const RunSummary& summary) {
  EXPECT_LE(summary.distance.value, 1e-9) << "nothing has reached the ground";
}

// ---- disc and snake -------------------------------------------------------------------------------------------------

TEST(PaperDisc, WithTwoToAHundredContactsLandsAndSlidesWithoutAFailedStep) {
  double lowest = 0;
  long long iterations = 0, steps = 0;
  int most = 0;
  for (int contacts = 2; contacts <= 100; contacts += 2) {
    SCOPED_TRACE("c = " + std::to_string(contacts));
    const RunSummary summary = run_well(scenes::disc({.contacts = contacts}), 150);
    expect_landed(summary);
    lowest = std::min(lowest, summary.distance.value);
    iterations += summary.iterations;
    steps += summary.steps;
    most = std::max(most, summary.most_iterations);
  }
  std::printf("             %lld steps, smallest distance %.1e m, iterations %.2f on average, %d at most\n", steps,
              lowest, static_cast<double>(iterations) / static_cast<double>(steps), most);
}

class PaperSnake : public testing::TestWithParam<int> {};

TEST_P(PaperSnake, LandsSlidesAndRestsWithoutAFailedStep) {
  const int links = GetParam();
  const int steps = links <= 100 ? 200 : 40;  // it lands in the 11th
  const RunSummary summary = run_well(scenes::snake({.links = links}), steps);
  expect_landed(summary);
  // Coming to rest is the hardest step: all contacts of a long snake stick at once, in the 32nd.
  EXPECT_LE(summary.momentum_end.norm(), 1e-6 * links) << "it has not come to rest";
  std::printf("             %d steps: distance %.1e m, joint error %.1e m, iterations %.2f on average, %d at most\n",
              summary.steps, summary.distance.value, summary.joint_error.value,
              static_cast<double>(summary.iterations) / summary.steps, summary.most_iterations);
}

INSTANTIATE_TEST_SUITE_P(Links, PaperSnake, testing::Values(2, 3, 5, 10, 20, 50, 100, 1000, 10000),
                         testing::PrintToStringParamName());

/// Of the order without fill, as in the paper. The simulator may take a wider one, whose tree is logarithmic: it does more
/// operations, eight at a time.
TEST(PaperScaling, EveryFurtherLinkOfTheSnakeCostsExactlyTheSameOperations) {
  const auto counts = [](int links) {
    const Simulator simulator(scenes::snake({.links = links}));
    return graphsolve::Symbolic(simulator.graph(), graphsolve::minimum_fill_ordering(simulator.graph())).counts();
  };
  const auto three = counts(3), four = counts(4);
  const long long operations = four.operations - three.operations;
  const long long scalars = four.stored_scalars - three.stored_scalars;
  EXPECT_GT(operations, 0);
  auto before = four;
  for (int links = 5; links <= 100; ++links) {
    const auto now = counts(links);
    ASSERT_EQ(now.operations - before.operations, operations) << "link " << links;
    ASSERT_EQ(now.stored_scalars - before.stored_scalars, scalars) << "link " << links;
    ASSERT_EQ(now.fill_blocks, three.fill_blocks);
    before = now;
  }
  EXPECT_EQ(counts(1001).operations - counts(1000).operations, operations);
  EXPECT_EQ(counts(10000).operations, four.operations + 9996 * operations);
  std::printf("             %lld operations and %lld stored scalars per link, %lld fill blocks\n", operations, scalars,
              static_cast<long long>(three.fill_blocks));
}

TEST(PaperScaling, OrderTheSimulatorTakesCostsEveryLinkAtMostThriceTheOrderWithoutFill) {
  for (const int links : {3, 10, 100, 1000, 10000}) {
    const Simulator simulator(scenes::snake({.links = links}));
    const auto narrow = graphsolve::Symbolic(simulator.graph(), graphsolve::minimum_fill_ordering(simulator.graph())).counts();
    EXPECT_LE(simulator.problem_size().operations, 3 * narrow.operations) << links << " links";
  }
}

TEST(PaperScaling, ContactsOfTheDiscAddNothingToTheFactorization) {
  const auto size = [](int contacts) { return Simulator(scenes::disc({.contacts = contacts})).problem_size(); };
  const ProblemSize few = size(2);
  for (int contacts = 4; contacts <= 100; contacts += 2) {
    EXPECT_EQ(size(contacts).operations, few.operations) << contacts << " contacts";
    EXPECT_EQ(size(contacts).stored_scalars, few.stored_scalars) << contacts << " contacts";
  }
}

// ---- hopper ---------------------------------------------------------------------------------------------------------

/// Rotation vector that leads from one orientation to the next [rad, body frame].
Vec3 turn(const Quat& from, const Quat& to) {
  const Quat q = from.conjugate() * to;
  const double sine = q.vec().norm();
  return sine == 0 ? Vec3::Zero()
                   : Vec3(2 * std::atan2(sine, std::abs(q.w())) / sine * std::copysign(1, q.w()) * q.vec());
}

/// What one body's records add up to.
struct Turning {
  Quat last = Quat::Identity();
  double about_axis = 0;  ///< [rad]
  double off_axis = 0;    ///< of the sum, largest [rad]
  Vec3 sum = Vec3::Zero();
  bool started = false;

  void add(const Quat& now, const Vec3& axis) {
    if (started) sum += turn(last, now);
    started = true;
    last = now;
    about_axis = sum.dot(axis);
    off_axis = std::max(off_axis, (sum - about_axis * axis).norm());
  }
};

TEST(PaperHopper, JumpsTurnsOnceAbout110LandsAndStands) {
  const Vec3 axis = Vec3(1, 1, 0).normalized();
  std::vector<Turning> bodies(2);
  double highest = 0, left = 0, landed = 0, speed = 0;
  RunOptions options;
  options.record = [&](const StepRecord& record) {
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].add(record.bodies[i].orientation, axis);
    const double distance = record.contacts[0].distance;
    highest = std::max(highest, distance);
    if (distance > 1e-6 && left == 0) left = record.time;
    if (distance <= 1e-6 && left > 0 && landed == 0) landed = record.time;
    speed = std::max(record.bodies[0].velocity.norm(), record.bodies[1].velocity.norm());
  };
  const RunSummary summary = run_well(scenes::hopper(), 1200, options);
  expect_landed(summary);
  for (const Turning& body : bodies) {
    EXPECT_NEAR(body.about_axis, 2 * std::numbers::pi, 0.01);
    EXPECT_LE(body.off_axis, 1e-6);
    EXPECT_GE((body.last * Vec3::UnitZ()).z(), std::cos(0.01)) << "it does not stand upright";
  }
  EXPECT_GT(highest, 0.2);
  EXPECT_GT(left, 0);
  EXPECT_GT(landed, left + 0.3);
  EXPECT_LE(speed, 0.01) << "it does not stand still";
  std::printf("             in the air %.3f .. %.3f s, up to %.3f m; turned by %.4f of 2 pi, %.1e rad off the axis\n",
              left, landed, highest, bodies[0].about_axis / (2 * std::numbers::pi), bodies[0].off_axis);
  std::printf("             smallest distance %.1e m, speed at the end %.1e m/s\n", summary.distance.value, speed);
}

// ---- quadruped ------------------------------------------------------------------------------------------------------

TEST(PaperQuadruped, WalksForwardForThreeSecondsOnFeetThatNeverSink) {
  const Mechanism scene = scenes::quadruped();
  ASSERT_EQ(scene.contacts.size(), 4u);
  std::vector<double> lifted(4, 0), lowest(4, INFINITY);
  std::vector<int> steps_on_ground(4, 0);
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double upright = 1;
  RunOptions options;
  options.record = [&](const StepRecord& record) {
    const BodyRecord& trunk = record.bodies[0];
    if (record.step == 0) from = trunk.position;
    to = trunk.position;
    upright = std::min(upright, (trunk.orientation * Vec3::UnitZ()).z());
    for (std::size_t i = 0; i < 4; ++i) {
      lifted[i] = std::max(lifted[i], record.contacts[i].distance);
      lowest[i] = std::min(lowest[i], record.contacts[i].distance);
      steps_on_ground[i] += record.contacts[i].normal_force > 1;
    }
  };
  const RunSummary summary = run_well(scene, 3000, options);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_GE(lowest[i], deepest) << scene.contacts[i].name;
    EXPECT_GT(lifted[i], 0.002) << scene.contacts[i].name << " never leaves the ground";
    EXPECT_GT(steps_on_ground[i], 500) << scene.contacts[i].name << " hardly carries anything";
  }
  EXPECT_GT((to - from).x(), 0.1);
  EXPECT_LT(std::abs((to - from).y()), 0.5 * (to - from).x());
  EXPECT_GT(upright, std::cos(0.2));
  std::printf("             %.3f m forward, %.3f m sideways; smallest distance %.1e m (the paper: -1.5e-9)\n",
              (to - from).x(), (to - from).y(), summary.distance.value);
  std::printf("             joint error %.1e, iterations %.2f on average, %d at most; tilt up to %.1f deg\n",
              summary.joint_error.value, static_cast<double>(summary.iterations) / summary.steps,
              summary.most_iterations, std::acos(upright) * 180 / std::numbers::pi);
}

}  // namespace test_paper_scenes
