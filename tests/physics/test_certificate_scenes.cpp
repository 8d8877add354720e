// Every built-in scene, every step of it, judged by code that shares nothing with the solver.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"
#include "support/certificate.hpp"

namespace test_certificate_scenes {

using namespace physics;

constexpr double bar = 1e-8;  // [m/s], the solver's default tolerance: the certificate grants no more

struct Judged {
  certificate::Certificate certificate;
  int steps = 0;
};

/// Runs up to this time and judges step by step, so that only two records are ever held.
Judged judge(const std::string& spec, double duration) {
  const Mechanism scene = built_in_scene(spec);
  Simulator simulator(scene);
  // The simulator's own copy: it has been checked, and quaternions made unit.
  const Mechanism& checked = simulator.mechanism();
  Judged judged;
  StepRecord before, after;
  certificate::Missed missed;
  simulator.write_record(before);
  const int steps = static_cast<int>(std::lround(duration / scene.time_step));
  for (int k = 0; k < steps; ++k) {
    const StepResult result = simulator.step();
    EXPECT_TRUE(result.ok()) << spec << ", step " << k + 1 << ": " << result.cause;
    if (!result.ok()) break;
    simulator.write_record(after);
    judged.certificate.merge(certificate::certify_step(checked, before, after, &missed));
    std::swap(before, after);
    ++judged.steps;
  }
  return judged;
}

void expect_certified(const std::string& spec, double duration) {
  SCOPED_TRACE(spec);
  const Judged judged = judge(spec, duration);
  const certificate::Certificate& c = judged.certificate;
  EXPECT_EQ(c.steps, judged.steps);
  EXPECT_LE(c.residual(), bar) << c;
  EXPECT_EQ(c.flagged, 0) << "steps of which only joints and distances could be judged";
  std::printf("             %-62s %5d steps, worst %.1e (%s)\n", spec.c_str(), c.steps, c.residual(),
              c.worst().what.c_str());
}

/// "name:a=b" and what every scene can be told besides.
std::string with(const std::string& spec, const std::string& model, const std::string& start) {
  return spec + (spec.find(':') == std::string::npos ? ":" : ",") + "model=" + model + ",start=" + start;
}

void expect_certified_in_all_variants(const std::string& spec, double duration) {
  const bool frictional = !built_in_scene(spec).contacts.empty();
  for (const char* start : {"half_kick", "standard"}) {
    expect_certified(with(spec, "aligned", start), duration);
    if (frictional) expect_certified(with(spec, "pyramid", start), duration);
  }
}

class CertificateOfScenes : public testing::TestWithParam<SceneInfo> {};

TEST_P(CertificateOfScenes, EveryStepPassesWithBothFrictionModelsFromBothStarts) {
  std::string spec = GetParam().name;
  double duration = GetParam().duration;
  if (spec == "quadruped") duration = 0.3;  // all of its 3 s below, once
  // A taut light chain has transverse frequencies up to sqrt(12 T / (m l)) = 2450 rad/s here: the integrator can
  // follow these up to dt = 2 / 2450 s and no further.
  if (spec == "hanging_bob") spec += ":dt=0.0005";
  expect_certified_in_all_variants(spec, duration);
}

INSTANTIATE_TEST_SUITE_P(BuiltIn, CertificateOfScenes, testing::ValuesIn(built_in_scenes()),
                         [](const auto& test) { return test.param.name; });

TEST(CertificateOfVariants, EveryStepOfLargerAndOddlyParametrizedScenesPasses) {
  const std::pair<const char*, double> specs[] = {
      {"disc:c=2", 1.5},
      {"disc:c=30,spin=6", 1.5},
      {"disc:mu=0", 0.6},
      {"snake:n=2", 2},
      {"snake:n=40", 1},
      {"pendulum:n=3,dt=0.002", 2},
      {"pendulum:n=5,joint=revolute,dt=0.001", 1},
      {"loop:n=40", 1},
      {"box_on_slope:fraction=0.99", 1},
      {"box_on_slope:fraction=1.3", 1},
      {"sliding_box:heading=30", 1},
      {"sliding_box:heading=45,mu=1.2", 0.5},
      {"tumbling_box:mu=0.9,dt=0.002", 1.5},
      {"spinning_sphere:spin=60,mu=0.5", 1},
      {"free_top:spin=50", 2},
      {"pads:ratio=100,speed=1", 1},
      {"hanging_bob:n=4,ratio=100,dt=0.005", 2},
  };
  for (const auto& [spec, duration] : specs) expect_certified(spec, duration);
}

TEST(CertificateOfVariants, EveryStepOfTheQuadrupedsThreeSecondWalkPasses) { expect_certified("quadruped", 3); }

/// At 10 ms the heavy bob's chain is far beyond what the integrator can follow. Steps may then fail or need
/// substeps, but must say so, and whatever is returned as solved keeps its joints.
TEST(CertificateOfVariants, BeyondTheStabilityLimitOfATautChainStepsAreFlaggedOrReportedAndNeverSilent) {
  Simulator simulator(built_in_scene("hanging_bob"));
  StepRecord before, after, kept;
  simulator.write_record(before);
  certificate::Certificate all;
  certificate::Missed missed;
  int steps = 0;
  StepResult result;
  for (; steps < 500; ++steps) {
    result = simulator.step();
    if (!result.ok()) break;
    simulator.write_record(after);
    const certificate::Certificate c = certificate::certify_step(simulator.mechanism(), before, after, &missed);
    EXPECT_EQ(c.flagged > 0, result.substeps > 1 || result.new_force_direction);
    all.merge(c);
    std::swap(before, after);
  }
  EXPECT_LE(all.residual(), bar) << all;
  if (!result.ok()) {
    EXPECT_FALSE(result.cause.empty());
    simulator.write_record(kept);
    EXPECT_EQ(kept.step, before.step);
    for (std::size_t i = 0; i < kept.bodies.size(); ++i)
      EXPECT_EQ(kept.bodies[i].position, before.bodies[i].position) << "a failed step must keep the state";
  }
  std::printf("             %d of 500 steps solved, %d of them flagged; then: %s\n", steps, all.flagged,
              std::string(graphsolve::name(result.status)).c_str());
}

TEST(CertificateOfVariants, EveryStepOfTheHopperPassesWithPyramidAtTwiceTheTimeStep) {
  expect_certified("hopper:model=pyramid,dt=0.002", 1.2);
}

}  // namespace test_certificate_scenes
