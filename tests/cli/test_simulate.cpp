#include <nlohmann/json.hpp>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "program.hpp"

namespace test_simulate {

// What `simulate` prints and writes.

namespace fs = std::filesystem;
using physics::read_scene;

constexpr const char* failing_scene = R"(
format = "graphsolve-scene"
version = 1
time_step = 0.01
[[bodies]]
name = "box"
mass = 1
shape = { type = "box", size = [1, 1, 1] }
[[loads]]
body = "box"
steps = [5, 5]
torque = [0, 0, 1e9]
)";

class Simulate : public Program {};

TEST_F(Simulate, SimulatesABuiltInSceneAndSaysHowItWent) {
  const Outcome outcome = run("simulate disc --steps 50");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* word :
       {"50 of 50 solved", "iterations", "smallest distance", "energy", "momentum", "left out", "us"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word << "\n" << outcome.out;
  EXPECT_TRUE(entries().empty());
}

// The hopper's jump has a full turn, and the box on its slope stays.
TEST_F(Simulate, SaysHowFarTheFirstBodyWent) {
  ASSERT_EQ(run("simulate hopper --summary hopper.json").code, 0);
  const nlohmann::json hopper = nlohmann::json::parse(text("hopper.json")).at("first_body");
  EXPECT_NEAR(hopper.at("turned_rad").get<double>(), 2 * std::numbers::pi, 0.1);
  const Outcome outcome = run("simulate box_on_slope --summary box.json");
  EXPECT_NE(outcome.out.find("first body             'box' moved ("), std::string::npos) << outcome.out;
  for (const double moved : nlohmann::json::parse(text("box.json")).at("first_body").at("moved_m")) EXPECT_LT(std::abs(moved), 1e-9);
}

TEST_F(Simulate, SaysWhereRoundingKeptStepsFromTheTolerance) {
  for (const auto& [x, far] : {std::pair("0", false), std::pair("1000000000", true)}) {  // [m] from where it hangs
    write("box.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"box\"\nmass = 1\n"
                      "inertia = [1, 1, 1]\nposition = [" + std::string(x) + ".0, 0, 0]\n[[joints]]\nname = \"pin\"\n"
                      "type = \"spherical\"\nparent = \"world\"\nchild = \"box\"\nchild_point = [0.5, 0, 0]\n"
                      "parent_point = [" + std::string(x) + ".5, 0, 0]\n");
    const Outcome outcome = run("simulate box.toml --steps 3");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out.find("above the tolerance: rounding this far from the origin") != std::string::npos, far) << outcome.out;
  }
}

/// A whip of 20 rods turns by more than a radian in steps of 10 ms.
TEST_F(Simulate, SaysThatATooLooseToleranceIsNotTaken) {
  const std::string note = "graphsolve: note: a tolerance of 1 m/s would let things hover; |g| dt / 100 = 0.000981 m/s is taken "
                           "instead\n";
  const Outcome loose = run("simulate disc --steps 3 --tolerance 1 --summary s.json");
  EXPECT_EQ(loose.code, 0);
  EXPECT_EQ(loose.err, note);
  EXPECT_NEAR(nlohmann::json::parse(text("s.json")).at("tolerance_m_per_s").get<double>(), 9.81e-4, 1e-12);
  EXPECT_EQ(run("simulate disc --steps 3 --tolerance 0.0009").err, "");
  EXPECT_EQ(run("rollout disc --steps 3 --copies 2 --tolerance 1").err, note);
}

TEST_F(Simulate, SaysWhereEnergyCameFromNowhere) {
  for (const auto& [dt, gains] : {std::pair("0.01", true), std::pair("0.001", false)}) {
    const Outcome outcome = run("simulate pendulum:n=20,joint=revolute,angle=179,dt=" + std::string(dt) + " --duration 5");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out.find("gained without motor or load") != std::string::npos, gains) << outcome.out;
  }
}

TEST_F(Simulate, TakesFilesWhoseNamesAreNotText) {
  const std::string name = "b\xff.json";
  physics::write_scene_json(physics::built_in_scene("disc"), path(name));
  EXPECT_EQ(run("simulate '" + name + "' --steps 2 --out t.json --summary s.json").code, 0);
  EXPECT_EQ(nlohmann::json::parse(text("s.json")).at("steps_solved"), 2);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(run("rollout '" + name + "' --copies 2 --steps 2 --out r.jsonl").code, 0);
}

TEST_F(Simulate, NamesRedundantJoints) {
  const Outcome outcome = run("simulate four_bar --steps 1");
  EXPECT_NE(outcome.out.find("redundant              joints 'ground-crank', "), std::string::npos) << outcome.out;
}

TEST_F(Simulate, WritesATrajectoryAndASummary) {
  ASSERT_EQ(run("simulate snake:n=3 --duration 0.2 --out t.json --summary s.json").code, 0);
  EXPECT_EQ(read_scene(path("t.json")).steps.size(), 21u);
  const auto summary = nlohmann::json::parse(text("s.json"));
  EXPECT_EQ(summary.at("status"), "solved");
  EXPECT_EQ(summary.at("steps_solved"), 20);
  EXPECT_EQ(summary.at("bodies"), 3);
  EXPECT_TRUE(summary.at("wall_time_per_step_us").contains("total"));
  EXPECT_EQ(entries().size(), 2u);
}

TEST_F(Simulate, WritesCsv) {
  ASSERT_EQ(run("simulate disc --steps 3 --out t.csv").code, 0);
  const std::string csv = text("t.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
}

TEST_F(Simulate, WritesJointCoordinatesThatCountTurns) {
  // A wheel on a hinge turns at 10 rad/s for 2 s.
  write("wheel.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"w\"\nmass = 1\n"
                      "inertia = [1, 1, 1]\nangular_velocity = [0, 0, 10]\n"
                      "[[joints]]\nname = \"hub\"\ntype = \"revolute\"\nparent = \"world\"\nchild = \"w\"\naxis = [0, 0, 1]\n");
  ASSERT_EQ(run("simulate wheel.toml --duration 2 --out t.json").code, 0);
  const auto last = read_scene(path("t.json")).steps.back().joints[0];
  EXPECT_NEAR(*last.coordinate, 20, 0.05);
  EXPECT_NEAR(*last.rate, 10, 0.02);
  ASSERT_EQ(run("simulate t.json --from 100 --steps 100 --out u.json").code, 0);
  EXPECT_NEAR(*read_scene(path("u.json")).steps.back().joints[0].coordinate, *last.coordinate, 1e-9);
}

TEST_F(Simulate, SimulatesATrajectoryAgainForItsRecordedLength) {
  ASSERT_EQ(run("simulate snake:n=3 --steps 37 --out a.json").code, 0);
  ASSERT_EQ(run("simulate a.json --out b.json").code, 0);
  EXPECT_EQ(text("a.json"), text("b.json"));
}

TEST_F(Simulate, ContinuesATrajectoryFromARecord) {
  // With `aligned` the friction bases of the record's contacts are not taken up again: near, but not to rounding.
  for (const auto& [model, tolerance] : {std::pair("pyramid", 1e-9), std::pair("aligned", 1e-4)}) {
    ASSERT_EQ(run("simulate snake:n=3,model=" + std::string(model) + " --steps 40 --out whole.json").code, 0);
    ASSERT_EQ(run("simulate whole.json --from 25 --steps 15 --out continued.json").code, 0);
    const auto whole = read_scene(path("whole.json")), continued = read_scene(path("continued.json"));
    ASSERT_EQ(continued.steps.size(), 41u);
    for (std::size_t i = 0; i < 41; ++i) {
      const auto &expected = whole.steps[i], &found = continued.steps[i];
      EXPECT_EQ(found.step, expected.step);
      EXPECT_NEAR(found.time, expected.time, 1e-12);
      for (std::size_t b = 0; b < 3; ++b)
        EXPECT_LE((found.bodies[b].position - expected.bodies[b].position).norm(), i <= 25 ? 0 : tolerance);
    }
  }
}

TEST_F(Simulate, ARunCutInTwoKeepsItsEnergyBalance) {
  // A body falls past z = 0, where its energy is all in the 0.05 m that it fell.
  write("fall.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"b\"\nmass = 1\n"
                     "inertia = [1, 1, 1]\n");
  const auto energy = [&](const char* key) { return nlohmann::json::parse(text("s.json")).at("energy_J").at(key).get<double>(); };
  ASSERT_EQ(run("simulate fall.toml --steps 10 --out t.json --summary s.json").code, 0);
  const double end = energy("end");
  const Outcome outcome = run("simulate t.json --from 10 --steps 1 --summary s.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out.find("gained"), std::string::npos) << outcome.out;
  EXPECT_NEAR(energy("start"), end, 1e-13);
  EXPECT_NEAR(energy("end"), end, 1e-13);
}

TEST_F(Simulate, TakesAnotherTimeStepAndFrictionModel) {
  ASSERT_EQ(run("simulate disc --time-step 0.005 --friction-model pyramid --steps 2 --out t.json").code, 0);
  const auto trajectory = read_scene(path("t.json"));
  EXPECT_EQ(trajectory.mechanism.time_step, 0.005);
  EXPECT_EQ(trajectory.mechanism.contacts[0].friction_model, physics::FrictionModel::pyramid);
  // A trajectory is as long at another time step, not as many steps.
  EXPECT_NE(run("simulate t.json --time-step 0.001").out.find("10 of 10 solved; 0.01 s simulated"), std::string::npos);
}

TEST_F(Simulate, AStartInsideAPlaneIsSaid) {
  write("deep.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"b\"\nmass = 1\n"
                     "shape = {type = \"sphere\", radius = 0.1}\nposition = [0, 0, -0.5]\n"
                     "[[contacts]]\nname = \"c\"\nbody = \"b\"\nradius = 0.1\n");
  const Outcome outcome = run("simulate deep.toml --steps 3");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("the scene begins inside a plane"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("shorter time step"), std::string::npos) << outcome.out;
}

TEST_F(Simulate, ADiskThatFillsUpEndsTheRunAndKeepsWhatFits) {
  const Outcome outcome = run("simulate snake:n=3 --steps 900 --out t.json --summary s.json", "ulimit -f 60;");
  EXPECT_EQ(outcome.code, 2);
  ASSERT_TRUE(fs::exists(path("t.json"))) << outcome.err;
  const int last = read_scene(path("t.json")).steps.back().step;
  const std::string number = std::to_string(last);
  EXPECT_EQ(outcome.err, "graphsolve: cannot write 't.json': File too large; the file ends with record " + number +
                             ", and --from " + number + " continues from there\n");
  EXPECT_GT(last, 5);
  const int solved = nlohmann::json::parse(text("s.json")).at("steps_solved");
  EXPECT_GE(solved, last);
  EXPECT_LT(solved, 900);
  EXPECT_NE(outcome.out.find("of 900 solved, stopped;"), std::string::npos) << outcome.out;
  EXPECT_EQ(run("simulate t.json --steps 3 --from " + number).code, 0);
}

TEST_F(Simulate, AStepThatFailsGivesCodeOneAndKeepsTheTrajectorySoFar) {
  write("spin.toml", failing_scene);
  const Outcome outcome = run("simulate spin.toml --steps 20 --out t.json --summary s.json");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(outcome.err.starts_with("graphsolve: spin.toml: step 5 (at 0.04 s) failed, ")) << outcome.err;
  const physics::Trajectory trajectory = read_scene(path("t.json"));
  EXPECT_EQ(trajectory.steps.size(), 5u);
  ASSERT_TRUE(trajectory.failure);
  EXPECT_EQ(trajectory.failure->step, 5);
  EXPECT_NE(outcome.err.find(trajectory.failure->status + " at " + trajectory.failure->place + ": " +
                             trajectory.failure->cause + "\n"),
            std::string::npos);
  const auto summary = nlohmann::json::parse(text("s.json"));
  EXPECT_EQ(summary.at("failed_step"), 5);
  EXPECT_EQ(summary.at("place"), trajectory.failure->place);
  // From a record before, with a step that is not loaded so: nothing of the failure is left.
  ASSERT_EQ(run("simulate t.json --from 2 --steps 2 --out u.json").code, 0);
  EXPECT_FALSE(read_scene(path("u.json")).failure);
  EXPECT_NE(summary.at("status"), "solved");
}

TEST_F(Simulate, ACoarseTimeStepIsNotedAndTaken) {
  Outcome outcome = run("simulate box_on_slope --time-step 100 --steps 1");
  EXPECT_NE(outcome.code, 2);
  EXPECT_NE(outcome.err.find("graphsolve: note: a time step of 100 s is coarse here: |g| dt^2, what a body falls in it, is "
                             "9.81e+04 m, and no joint or contact is farther than "),
            std::string::npos)
      << outcome.err;
  outcome = run("rollout box_on_slope:dt=1 --copies 1 --steps 1");
  EXPECT_TRUE(outcome.err.starts_with("graphsolve: note: a time step of 1 s is coarse here: ")) << outcome.err;
  // 2 asin(w dt / 2) / 2 pi
  outcome = run("simulate free_top:spin=40,dt=0.02 --steps 1");
  EXPECT_NE(outcome.err.find("coarse here: body 'top' starts at 0.13 turns a step"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("falls"), std::string::npos) << "no gravity";
}

TEST_F(Simulate, NoBuiltInSceneHasACoarseTimeStep) {
  for (const auto& info : physics::built_in_scenes()) {
    const Outcome outcome = run("simulate " + info.name + " --steps 1");
    EXPECT_EQ(outcome.code, 0) << info.name;
    EXPECT_EQ(outcome.err, "") << info.name;
  }
}

TEST_F(Simulate, ContactsThatCannotMoveHaveNoDistance) {
  write("a.toml",
        "format = 'graphsolve-scene'\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = 'post'\nmass = 1\n"
        "inertia = [1, 1, 1]\n[[joints]]\nname = 'bolt'\ntype = 'fixed'\nparent = 'world'\nchild = 'post'\n"
        "[[contacts]]\nname = 'foot'\nbody = 'post'\n");
  const Outcome outcome = run("simulate a.toml --steps 2");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("none: fixed joints hold all bodies with contacts at the world"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("inf"), std::string::npos) << outcome.out;
}

TEST_F(Simulate, EnergyBeyondTheLargestNumberIsRefused) {
  const std::string head = "format = 'graphsolve-scene'\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = 'star'\n"
                           "inertia = [1, 1, 1]\n";
  for (const auto& [rest, refused] :
       {std::pair("mass = 1e200\nposition = [0, 0, 1e200]\n", "a.toml:8: body 'star': its potential energy is inf J, more than 1e+300"),
        {"mass = 1\nvelocity = [0, 1e160, 0]\n", "a.toml:8: body 'star': its kinetic energy is inf J, more than 1e+300"},
        {"mass = 1\nposition = [1e160, 0, 0]\nvelocity = [0, 1e145, 0]\n",
         "a.toml:8: body 'star': its angular momentum about the origin is 1e+305 N m s, more than 1e+300"}}) {
    write("a.toml", head + rest);
    const Outcome outcome = run("simulate a.toml --steps 0");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.err, "graphsolve: " + std::string(refused) + "\n");
  }
}

/// The equations are solved, but nothing could be told of the state that they lead to.
TEST_F(Simulate, AStepToAnEnergyThatIsNoNumberFails) {
  write("a.toml",
        "format = 'graphsolve-scene'\nversion = 1\ntime_step = 0.01\n"
        "[[bodies]]\nname = 'stone'\nmass = 1\ninertia = [1, 1, 1]\n"
        "[[bodies]]\nname = 'star'\nmass = 1\ninertia = [1, 1, 1]\nposition = [1, 0, 0]\n"
        "[[loads]]\nbody = 'star'\nsteps = [3, 9]\nforce = [0, 1e200, 0]\n");
  const Outcome outcome = run("simulate a.toml --steps 9 --out t.json --summary s.json");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err,
            "graphsolve: a.toml: step 3 (at 0.02 s) failed, not_finite at body 'star' (beyond the largest number): a value "
            "became NaN or infinite, or a motion so large that its energy is no number; look for such input, or take a "
            "shorter time step\n");
  EXPECT_EQ(read_scene(path("t.json")).steps.size(), 3u);
  const auto summary = nlohmann::json::parse(text("s.json"));
  EXPECT_EQ(summary["statuses"], (nlohmann::json{{"solved", 2}, {"not_finite", 1}}));
  EXPECT_TRUE(summary["energy_J"]["end"].is_number());
  EXPECT_NEAR(summary["energy_J"]["end"].get<double>(), summary["energy_J"]["start"].get<double>(), 0.01);
}

}  // namespace test_simulate
