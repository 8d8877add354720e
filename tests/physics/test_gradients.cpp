#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gradient_check.hpp"
#include "physics/scenes.hpp"

namespace test_gradients {

/// Derivatives of a step against central differences of steps, in space.

using namespace physics;
using gradient_check::Case;

constexpr std::array all_inputs{StepInput::state,    StepInput::load, StepInput::effort,
                                StepInput::friction, StepInput::mass, StepInput::inertia};
/// Where motors hold the legs, their inertia is felt too little for differences to see it.
constexpr std::array without_inertia{StepInput::state, StepInput::load, StepInput::effort, StepInput::friction,
                                     StepInput::mass};
/// The barrier counts the island's mass as given.
constexpr std::array smooth_inputs{StepInput::state, StepInput::load, StepInput::friction, StepInput::inertia};
const char* name_of(StepInput input) {
  static const char* names[] = {"state", "load", "effort", "friction", "mass", "inertia"};
  return names[static_cast<int>(input)];
}

void expect_agreement(const Case& test, double tolerance, std::span<const StepInput> inputs = all_inputs) {
  for (const StepInput input : inputs) {
    const auto result = gradient_check::compare(test, input);
    EXPECT_LE(result.largest_error, tolerance) << test.scene.name << " by " << name_of(input) << ", " << result.where;
    std::printf("             %-16s step %4d, %2d iterations, by %-8s: %.1e\n", test.scene.name.c_str(),
                test.steps_before + 1, result.iterations, name_of(input), result.largest_error);
  }
  // Both round off with the stiffness that holds the contacts.
  EXPECT_LE(gradient_check::transposed_error(test), test.scene.contacts.empty() ? 1e-9 : 1e-6) << test.scene.name;
}

Case scene(const char* spec, int steps_before) {
  return {.scene = built_in_scene(spec), .steps_before = steps_before, .gradient = {}};
}

TEST(StepGradient, OfFreeBodiesMatchesCentralDifferences) {
  for (const char* spec : {"free_top", "free_top:start=standard"})
    for (const int steps : {0, 7}) {
      Case test = scene(spec, steps);
      test.scene.bodies[0].inertia << 1, 0.1, 0, 0.1, 2, 0.2, 0, 0.2, 2.5;
      expect_agreement(test, 1e-6);
    }
}

TEST(StepGradient, OfChainsLoopsAndMotorsMatchesCentralDifferences) {
  for (const char* spec : {"pendulum:n=4", "pendulum:n=3,joint=revolute", "loop:n=5", "stiff_hinge:stiffness=1e3"}) {
    expect_agreement(scene(spec, 0), 1e-6);
    expect_agreement(scene(spec, 11), 1e-6);
  }
}

/// A tree of all joint types in general position, with and without motors, one of them at its limit.
Mechanism every_joint(double limit) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&](double size) { return Vec3(size * uniform(random), size * uniform(random), size * uniform(random)); };
  Mechanism scene;
  scene.name = "every joint";
  for (int i = 0; i < 6; ++i) {
    Body body;
    body.name = "body " + std::to_string(i);
    body.mass = 1 + 0.2 * i;
    body.inertia << 0.3, 0.02, 0.01, 0.02, 0.4, -0.03, 0.01, -0.03, 0.5;
    body.position = vector(1);
    body.orientation = Quat(uniform(random), uniform(random), uniform(random), uniform(random)).normalized();
    scene.add(body);
  }
  const JointType types[] = {JointType::revolute,  JointType::prismatic, JointType::spherical,
                             JointType::revolute, JointType::prismatic, JointType::fixed};
  for (int i = 0; i < 6; ++i) {
    Joint joint;
    joint.name = "joint " + std::to_string(i);
    joint.type = types[i];
    joint.child = {i};
    if (i > 0) joint.parent = {i - 1};
    const Body &b = scene.bodies[i], a = i > 0 ? scene.bodies[i - 1] : Body{};
    joint.child_point = vector(0.4);
    joint.parent_point = a.orientation.conjugate() * (b.position + b.orientation * joint.child_point - a.position);
    joint.axis = vector(1).normalized();
    joint.orientation = a.orientation.conjugate() * b.orientation;
    if (i == 0 || i == 1) joint.motor = Motor{.stiffness = 40, .damping = 3, .limit = i == 1 ? limit : 1e9, .target = 0.2};
    scene.add(joint);
  }
  return scene;
}

TEST(StepGradient, OfEveryJointInGeneralPositionMatchesCentralDifferences) {
  for (const double limit : {1e9, 0.5})
    for (const int steps : {0, 5, 20}) expect_agreement({every_joint(limit), steps, {}}, 1e-6);
}

TEST(StepGradient, OfRestingSlidingAndLandingBoxesMatchesCentralDifferences) {
  expect_agreement(scene("box_on_slope:fraction=0.8", 5), 1e-5);
  expect_agreement(scene("box_on_slope:fraction=1.3", 5), 1e-5);
  expect_agreement(scene("sliding_box:heading=30", 3), 1e-5);
  expect_agreement(scene("spinning_sphere", 3), 1e-5);
  expect_agreement(scene("spinning_sphere", 90), 1e-5);
}

/// In the air, at its first impact, and tumbling on edges and corners.
TEST(StepGradient, OfATumblingBoxMatchesCentralDifferences) {
  for (const int steps : {20, 25, 30, 35}) expect_agreement(scene("tumbling_box", steps), 1e-5);
}

/// Four corners of a face that turns while it slides: what each of them carries is not unique, nor is the velocity
/// after the step. On the central path both are.
TEST(StepGradient, OfASpinningFaceMatchesCentralDifferencesOnTheCentralPath) {
  Case test = scene("tumbling_box", 45);
  test.gradient.smoothing = 1e-6;
  expect_agreement(test, 1e-5, smooth_inputs);
}

TEST(StepGradient, SmoothedMatchesCentralDifferencesOfTheSmoothedStep) {
  for (const double smoothing : {1e-8, 1e-5, 1e-3})
    for (const int steps : {3, 25}) {
      Case test = scene(steps == 3 ? "sliding_box:heading=30" : "tumbling_box", steps);
      test.gradient.smoothing = smoothing;
      test.closer = 0.1;  // a contact that lands is blurred over mm/s only
      expect_agreement(test, 1e-5, smooth_inputs);
    }
}

/// Falling, landing, sliding.
TEST(StepGradient, OfASnakeMatchesCentralDifferences) {
  for (const int steps : {6, 9, 12, 30}) expect_agreement(scene("snake:n=4", steps), 1e-5);
}

/// Standing, crouching, in the air, landed.
TEST(StepGradient, OfTheHopperMatchesCentralDifferences) {
  for (const int steps : {3, 60, 200, 700}) expect_agreement(scene("hopper", steps), 1e-5);
}

TEST(StepGradient, OfTheWalkingQuadrupedMatchesCentralDifferences) {
  for (const int steps : {3, 200, 500}) expect_agreement(scene("quadruped", steps), 1e-5, without_inertia);
}

/// A load on a part of a body that is held together by fixed joints acts at the part's own centre.
TEST(StepGradient, OfMergedBodiesIsTakenByTheBodyThatMoves) {
  Mechanism dumbbell = built_in_scene("free_box");
  Body ball = dumbbell.bodies[0];
  ball.name = "ball";
  ball.position += Vec3(0.7, 0, 0);
  ball.velocity += ball.orientation * dumbbell.bodies[0].angular_velocity.cross(ball.orientation.conjugate() * Vec3(0.7, 0, 0));
  dumbbell.add(ball);
  Joint bar;
  bar.name = "bar";
  bar.parent = {0};
  bar.child = {1};
  bar.parent_point = ball.orientation.conjugate() * Vec3(0.7, 0, 0);
  dumbbell.add(bar);
  const auto spin_after = [&](double turn) {
    Mechanism scene = dumbbell;
    for (Body& body : scene.bodies) {  // the whole turns about its common centre
      const Vec3 centre = 0.5 * (dumbbell.bodies[0].position + dumbbell.bodies[1].position);
      const Quat rotation(Eigen::AngleAxisd(turn, scene.bodies[0].orientation * Vec3::UnitZ()));
      body.position = centre + rotation * (body.position - centre);
      body.velocity = rotation * body.velocity;
      body.orientation = rotation * body.orientation;
    }
    Load load;
    load.body = {1};
    load.force = {3, -20, 8};
    scene.add(load);
    Simulator simulator(scene);
    EXPECT_TRUE(simulator.step().ok());
    StepGradient gradient(simulator);
    EXPECT_EQ(gradient.evaluate(), GradientStatus::ready);
    EXPECT_EQ(gradient.moving_bodies(), 1);
    EXPECT_EQ(gradient.moving_body({1}), 0);
    EXPECT_EQ(gradient.moving_body(world), -1);
    Eigen::Matrix<double, 12, 12> jacobian;
    gradient.jacobian(StepInput::state, {jacobian.data(), 144});
    return std::pair(Vec3(Vec3::Map(gradient.velocity(0).data() + 3)), Vec3(jacobian.block<3, 1>(9, 5)));
  };
  const Vec3 by_turn = spin_after(0).second, difference = (spin_after(1e-5).first - spin_after(-1e-5).first) / 2e-5;
  EXPECT_GT(difference.norm(), 0.01) << "the test shows nothing";
  // Turning the state also turns its velocity v, which no rotation of a free body feels.
  EXPECT_LE((by_turn - difference).norm(), 1e-6 * difference.norm());
}

/// docs/gradients.md: the velocities that the joints allow are what the first step is given.
TEST(StepGradient, OfAFirstStepIsByTheCorrectedVelocities) {
  Mechanism given = built_in_scene("pendulum:n=2,joint=revolute");
  given.start = Start::standard;
  given.bodies[1].velocity = Vec3(0.3, -0.7, 0.4);
  Mechanism corrected = given;
  StepRecord start;
  Simulator(given).write_record(start);
  for (std::size_t b = 0; b < given.bodies.size(); ++b) {
    corrected.bodies[b].velocity = start.bodies[b].velocity;
    corrected.bodies[b].angular_velocity = start.bodies[b].angular_velocity;
  }
  const auto next_velocity = [](const Mechanism& scene, StepInput input, Eigen::MatrixXd& jacobian) {
    Simulator simulator(scene);
    EXPECT_TRUE(simulator.step().ok());
    StepGradient gradient(simulator);
    EXPECT_EQ(gradient.evaluate(), GradientStatus::ready);
    jacobian.resize(gradient.state_size(), gradient.columns(input));
    gradient.jacobian(input, {jacobian.data(), static_cast<std::size_t>(jacobian.size())});
    return Vec3(gradient.velocity(1).data());
  };
  Eigen::MatrixXd of_given, of_corrected, unused;
  for (const StepInput input : {StepInput::state, StepInput::mass, StepInput::inertia}) {
    (void)next_velocity(given, input, of_given);
    (void)next_velocity(corrected, input, of_corrected);
    EXPECT_LE((of_given - of_corrected).norm(), 1e-9 * of_corrected.norm()) << name_of(input);
  }
  // Not the derivative through the description, where the correction depends on masses.
  (void)next_velocity(given, StepInput::mass, of_given);
  Mechanism heavier = given;
  heavier.bodies[1].mass += 1e-6;
  const Vec3 difference = (next_velocity(heavier, StepInput::mass, unused) - next_velocity(given, StepInput::mass, unused)) / 1e-6;
  EXPECT_GT((difference - of_given.col(1).segment<3>(18)).norm(), 0.01);
}

TEST(StepGradient, SaysWhyThereIsNone) {
  Simulator simulator(built_in_scene("sliding_box"));
  StepGradient gradient(simulator);
  std::vector<double> adjoint(gradient.state_size()), out(gradient.gradient_size());
  EXPECT_EQ(gradient.evaluate(), GradientStatus::no_step);
  EXPECT_THROW(gradient.vector_jacobian(adjoint, out), std::logic_error);
  ASSERT_TRUE(simulator.step().ok());
  EXPECT_EQ(gradient.evaluate(), GradientStatus::ready);
  StepRecord record;
  simulator.write_record(record);
  simulator.restart_from(record);
  EXPECT_EQ(gradient.evaluate(), GradientStatus::no_step);

  Mechanism torn = built_in_scene("free_box");
  Load load;
  load.body = {0};
  load.torque = {0, 1e6, 0};  // no turn within a step takes up this much
  torn.add(load);
  Simulator failing(torn);
  ASSERT_FALSE(failing.step().ok());
  EXPECT_EQ(StepGradient(failing).evaluate(), GradientStatus::no_step);
  EXPECT_FALSE(explanation(GradientStatus::no_step).empty());

  Simulator divided(built_in_scene("free_top:spin=300"));
  const StepResult result = divided.step();
  ASSERT_TRUE(result.ok());
  ASSERT_GT(result.substeps, 1);
  EXPECT_EQ(StepGradient(divided).evaluate(), GradientStatus::substeps);
}

TEST(StepGradient, RejectsWrongSizesAndNumbersThatAreNotFinite) {
  Simulator simulator(built_in_scene("sliding_box"));
  EXPECT_THROW(StepGradient(simulator, {.smoothing = -1}), std::invalid_argument);
  EXPECT_THROW(StepGradient(simulator, {.smoothing = std::nan("")}), std::invalid_argument);
  ASSERT_TRUE(simulator.step().ok());
  StepGradient gradient(simulator);
  ASSERT_EQ(gradient.evaluate(), GradientStatus::ready);
  std::vector<double> adjoint(gradient.state_size()), out(gradient.gradient_size());
  EXPECT_THROW(gradient.vector_jacobian(std::span(adjoint).first(3), out), std::invalid_argument);
  EXPECT_THROW(gradient.jacobian(StepInput::load, adjoint), std::invalid_argument);
  EXPECT_THROW(gradient.vector_jacobian(std::span(out).first(adjoint.size()), out), std::invalid_argument) << "overlap";
  adjoint[3] = std::nan("");
  EXPECT_THROW(gradient.vector_jacobian(adjoint, out), std::invalid_argument);
}

/// Taken at two barriers after every step, which moves every private unknown of the contacts for a while.
TEST(StepGradient, LeavesTheSimulatorAsItWasToTheLastBit) {
  for (const char* spec : {"quadruped", "tumbling_box", "snake:n=4"}) {
    Simulator plain(built_in_scene(spec)), watched(built_in_scene(spec));
    StepGradient sharp(watched), smooth(watched, {.smoothing = 1e-5});
    for (int k = 0; k < 60; ++k) {
      ASSERT_TRUE(plain.step().ok());
      ASSERT_TRUE(watched.step().ok());
      ASSERT_EQ(sharp.evaluate(), GradientStatus::ready) << spec << ", step " << k;
      ASSERT_EQ(smooth.evaluate(), GradientStatus::ready) << spec << ", step " << k;
      ASSERT_EQ(plain.smallest_distance(), watched.smallest_distance());
      ASSERT_EQ(plain.largest_joint_error(), watched.largest_joint_error());
      StepRecord a, b;
      plain.write_record(a);
      watched.write_record(b);
      for (std::size_t i = 0; i < a.bodies.size(); ++i) {
        ASSERT_EQ(a.bodies[i].position, b.bodies[i].position) << spec << ", step " << k;
        ASSERT_EQ(a.bodies[i].orientation.coeffs(), b.bodies[i].orientation.coeffs());
        ASSERT_EQ(a.bodies[i].angular_velocity, b.bodies[i].angular_velocity);
      }
      for (std::size_t i = 0; i < a.contacts.size(); ++i)
        ASSERT_EQ(a.contacts[i].facet_forces, b.contacts[i].facet_forces);
      for (std::size_t i = 0; i < a.joints.size(); ++i) ASSERT_EQ(a.joints[i].force, b.joints[i].force);
    }
  }
}

}  // namespace test_gradients
