#include <nlohmann/json.hpp>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "program.hpp"

namespace test_cli {

// `simulate` and what all commands share.

namespace fs = std::filesystem;
using physics::read_scene;

class Cli : public Program {
 protected:
  /// Sends the signal once the program is stepping, and waits for its end.
  [[nodiscard]] Outcome run_and_signal(const std::string& arguments, int signal) const {
    // The unfinished file appears just before the first step.
    const auto running = [&] {
      for (const std::string& name : entries())
        if (name.ends_with(".part")) {
          std::this_thread::sleep_for(std::chrono::milliseconds(200));
          return true;
        }
      return false;
    };
    const int status = signal_amid(arguments, signal, running);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text(".out"), text(".err")};
  }
};

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

TEST_F(Cli, SaysItsVersion) {
  const Outcome outcome = run("--version");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(outcome.out.starts_with("graphsolve ")) << outcome.out;
}

TEST_F(Cli, HelpOfEveryCommandHasExamplesOrScenes) {
  EXPECT_EQ(run("--help").code, 0);
  const Outcome help = run("simulate --help");
  EXPECT_EQ(help.code, 0);
  for (const char* word : {"Examples:", "--duration", "[s]", "[m/s]", "1e-08", "Exit code:"})
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  const Outcome scenes = run("scenes");
  EXPECT_EQ(scenes.code, 0);
  for (const auto& info : physics::built_in_scenes()) EXPECT_NE(scenes.out.find(info.name), std::string::npos);
}

TEST_F(Cli, SimulatesABuiltInSceneAndSaysHowItWent) {
  const Outcome outcome = run("simulate disc --steps 50");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* word :
       {"50 of 50 solved", "iterations", "smallest distance", "energy", "momentum", "left out", "us"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word << "\n" << outcome.out;
  EXPECT_TRUE(entries().empty());
}

// The hopper's jump has a full turn, and the box on its slope stays.
TEST_F(Cli, SaysHowFarTheFirstBodyWent) {
  ASSERT_EQ(run("simulate hopper --summary hopper.json").code, 0);
  const nlohmann::json hopper = nlohmann::json::parse(text("hopper.json")).at("first_body");
  EXPECT_NEAR(hopper.at("turned_rad").get<double>(), 2 * std::numbers::pi, 0.1);
  const Outcome outcome = run("simulate box_on_slope --summary box.json");
  EXPECT_NE(outcome.out.find("first body             'box' moved ("), std::string::npos) << outcome.out;
  for (const double moved : nlohmann::json::parse(text("box.json")).at("first_body").at("moved_m")) EXPECT_LT(std::abs(moved), 1e-9);
}

TEST_F(Cli, SaysWhereRoundingKeptStepsFromTheTolerance) {
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
TEST_F(Cli, SaysThatATooLooseToleranceIsNotTaken) {
  const std::string note = "graphsolve: note: a tolerance of 1 m/s would let things hover; |g| dt / 100 = 0.000981 m/s is taken "
                           "instead\n";
  const Outcome loose = run("simulate disc --steps 3 --tolerance 1 --summary s.json");
  EXPECT_EQ(loose.code, 0);
  EXPECT_EQ(loose.err, note);
  EXPECT_NEAR(nlohmann::json::parse(text("s.json")).at("tolerance_m_per_s").get<double>(), 9.81e-4, 1e-12);
  EXPECT_EQ(run("simulate disc --steps 3 --tolerance 0.0009").err, "");
  EXPECT_EQ(run("rollout disc --steps 3 --copies 2 --tolerance 1").err, note);
}

TEST_F(Cli, SaysWhereEnergyCameFromNowhere) {
  for (const auto& [dt, gains] : {std::pair("0.01", true), std::pair("0.001", false)}) {
    const Outcome outcome = run("simulate pendulum:n=20,joint=revolute,angle=179,dt=" + std::string(dt) + " --duration 5");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out.find("gained without motor or load") != std::string::npos, gains) << outcome.out;
  }
}

TEST_F(Cli, TakesFilesWhoseNamesAreNotText) {
  const std::string name = "b\xff.json";
  physics::write_scene_json(physics::built_in_scene("disc"), path(name));
  EXPECT_EQ(run("simulate '" + name + "' --steps 2 --out t.json --summary s.json").code, 0);
  EXPECT_EQ(nlohmann::json::parse(text("s.json")).at("steps_solved"), 2);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(run("rollout '" + name + "' --copies 2 --steps 2 --out r.jsonl").code, 0);
}

TEST_F(Cli, NamesRedundantJoints) {
  const Outcome outcome = run("simulate four_bar --steps 1");
  EXPECT_NE(outcome.out.find("redundant              joints 'ground-crank', "), std::string::npos) << outcome.out;
}

TEST_F(Cli, WritesATrajectoryAndASummary) {
  ASSERT_EQ(run("simulate snake:n=3 --duration 0.2 --out t.json --summary s.json").code, 0);
  EXPECT_EQ(read_scene(path("t.json")).steps.size(), 21u);
  const auto summary = nlohmann::json::parse(text("s.json"));
  EXPECT_EQ(summary.at("status"), "solved");
  EXPECT_EQ(summary.at("steps_solved"), 20);
  EXPECT_EQ(summary.at("bodies"), 3);
  EXPECT_TRUE(summary.at("wall_time_per_step_us").contains("total"));
  EXPECT_EQ(entries().size(), 2u);
}

TEST_F(Cli, WritesCsv) {
  ASSERT_EQ(run("simulate disc --steps 3 --out t.csv").code, 0);
  const std::string csv = text("t.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
}

TEST_F(Cli, WritesJointCoordinatesThatCountTurns) {
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

TEST_F(Cli, SimulatesATrajectoryAgainForItsRecordedLength) {
  ASSERT_EQ(run("simulate snake:n=3 --steps 37 --out a.json").code, 0);
  ASSERT_EQ(run("simulate a.json --out b.json").code, 0);
  EXPECT_EQ(text("a.json"), text("b.json"));
}

TEST_F(Cli, ContinuesATrajectoryFromARecord) {
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

TEST_F(Cli, TakesAnotherTimeStepAndFrictionModel) {
  ASSERT_EQ(run("simulate disc --time-step 0.005 --friction-model pyramid --steps 2 --out t.json").code, 0);
  const auto trajectory = read_scene(path("t.json"));
  EXPECT_EQ(trajectory.mechanism.time_step, 0.005);
  EXPECT_EQ(trajectory.mechanism.contacts[0].friction_model, physics::FrictionModel::pyramid);
  // A trajectory is as long at another time step, not as many steps.
  EXPECT_NE(run("simulate t.json --time-step 0.001").out.find("10 of 10 solved; 0.01 s simulated"), std::string::npos);
}

TEST_F(Cli, AStartInsideAPlaneIsSaid) {
  write("deep.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"b\"\nmass = 1\n"
                     "shape = {type = \"sphere\", radius = 0.1}\nposition = [0, 0, -0.5]\n"
                     "[[contacts]]\nname = \"c\"\nbody = \"b\"\nradius = 0.1\n");
  const Outcome outcome = run("simulate deep.toml --steps 3");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("the scene begins inside a plane"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("shorter time step"), std::string::npos) << outcome.out;
}

TEST_F(Cli, AStepThatFailsGivesCodeOneAndKeepsTheTrajectorySoFar) {
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

TEST_F(Cli, WrongOptionsAreRefusedInOneLine) {
  EXPECT_EQ(refused(""), "graphsolve: a command is missing; there are: simulate, rollout, scenes, study, "
                         "analyze, solve (see 'graphsolve --help')\n");
  EXPECT_EQ(refused("--fast"), "graphsolve: there is no option '--fast'; there are: --help, --version (see 'graphsolve "
                               "--help')\n");
  EXPECT_EQ(refused("simulte disc"),
            "graphsolve: there is no command 'simulte'; there are: simulate, rollout, scenes, study, analyze, solve\n");
  EXPECT_EQ(refused("simulate disc --out a.json --summary a.json"),
            "graphsolve: --out and --summary are the same file 'a.json'\n");
  EXPECT_EQ(refused("simulate disc --steps -3"),
            "graphsolve: --steps: must be a whole number >= 0, not -3 (see 'graphsolve simulate --help')\n");
  EXPECT_NE(refused("simulate disc --steps 1e3").find("must be a whole number >= 0, not 1e3"), std::string::npos);
  EXPECT_NE(refused("simulate disc --steps 99999999999").find("must not be above 2147483647"), std::string::npos);
  EXPECT_EQ(refused("simulate"), "graphsolve: SCENE is missing: A .json or .toml file, or a built-in scene with parameters, "
                                 "as 'graphsolve scenes' lists them (see 'graphsolve simulate --help')\n");
  EXPECT_EQ(refused("study --quick"),
            "graphsolve: NAME is missing: One or more of: scaling, precision (see 'graphsolve study --help')\n");
  for (const char* options : {"--quik", "--quik=3", "--quik 3"})
    EXPECT_EQ(refused(std::string("study scaling ") + options),
              "graphsolve: there is no option '--quik'; there are: --help, --quick, --out (see 'graphsolve study --help')\n");
  EXPECT_EQ(refused("study scaling --quick=3"), "graphsolve: --quick takes no value (see 'graphsolve study --help')\n");
  EXPECT_EQ(refused("scenes disc"), "graphsolve: 'disc' is one word too many (see 'graphsolve scenes --help')\n");
  for (const char* options : {"--steps", "--steps="})
    EXPECT_EQ(refused(std::string("simulate disc ") + options),
              "graphsolve: --steps needs a value, N: Number of steps (see 'graphsolve simulate --help')\n");
  EXPECT_EQ(refused("simulate disc --steps 1 --steps 2"),
            "graphsolve: --steps is given more than once (see 'graphsolve simulate --help')\n");
  // What a shell makes of a variable that is not set.
  for (const char* command : {"simulate disc --out ''", "simulate disc --summary ''", "solve a.mtx --out ''",
                              "analyze disc --json ''", "rollout disc --copies 1 --steps 1 --out ''", "study scaling --out ''"})
    EXPECT_NE(refused(command).find(": needs a file name"), std::string::npos) << command;
  EXPECT_NE(refused("simulate disc --steps 3 --duration 1").find("excludes"), std::string::npos);
  EXPECT_NE(refused("simulate disc --from 3 --time-step 1").find("excludes"), std::string::npos);
  EXPECT_NE(refused("simulate disc --friction-model cone").find("must be pyramid or aligned, not cone"),
            std::string::npos);
  EXPECT_NE(refused("simulate disc --tolerance nan").find("must be a number > 0, not nan"), std::string::npos);
  EXPECT_NE(refused("simulate disc --fast").find("there is no option '--fast'; there are: "), std::string::npos);
}

TEST_F(Cli, WrongScenesAreRefusedInOneLine) {
  EXPECT_NE(refused("simulate nosuch --out t.json").find("no built-in scene 'nosuch'"), std::string::npos);
  EXPECT_NE(refused("simulate nosuch.json").find("nosuch.json: cannot be read: No such"), std::string::npos);
  write("robot.urdf", "<robot/>");
  for (const char* name : {"robot.urdf", "nosuch.yaml"})  // not a list of built-in scenes
    EXPECT_NE(refused(std::string("simulate ") + name).find("a scene file ends in .json or .toml"), std::string::npos) << name;
  if (fs::exists("/dev/zero")) {
    fs::create_symlink("/dev/zero", path("zero.toml"));
    EXPECT_EQ(refused("simulate zero.toml"), "graphsolve: zero.toml:1: holds a zero byte: this is no text\n");
  }
  write("a.json", "{\n  \"format\": 3\n}");
  EXPECT_EQ(refused("simulate a.json --out t.json"), "graphsolve: a.json:2: format: is a number, expected text\n");
  write("b.toml",
        "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n"
        "[[bodies]]\nname = \"disc\"\nmass = -1\ninertia = [1, 1, 1]\n");
  EXPECT_EQ(refused("simulate b.toml --out t.json"), "graphsolve: b.toml:6: body 'disc': mass -1 kg is not > 0\n");
  EXPECT_EQ(refused("rollout b.toml --copies 2 --steps 1"), "graphsolve: b.toml:6: body 'disc': mass -1 kg is not > 0\n");
  EXPECT_EQ(refused("analyze b.toml"), "graphsolve: b.toml:6: body 'disc': mass -1 kg is not > 0\n");
}

TEST_F(Cli, ACoarseTimeStepIsNotedAndTaken) {
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

TEST_F(Cli, NoBuiltInSceneHasACoarseTimeStep) {
  for (const auto& info : physics::built_in_scenes()) {
    const Outcome outcome = run("simulate " + info.name + " --steps 1");
    EXPECT_EQ(outcome.code, 0) << info.name;
    EXPECT_EQ(outcome.err, "") << info.name;
  }
}

TEST_F(Cli, EmptySceneFilesAreSaidToBeEmpty) {
  for (const std::string name : {"empty.json", "empty.toml"}) {
    write(name, "");
    EXPECT_EQ(refused("simulate " + name),
              "graphsolve: " + name + ": is empty; a scene has at least the keys format, version, time_step and bodies\n");
  }
}

TEST_F(Cli, AWrongValueOfARecordIsNamedWithItsLine) {
  ASSERT_EQ(run("simulate box_on_slope --steps 2 --out t.json").code, 0);
  std::string trajectory = text("t.json");
  const auto last = trajectory.rfind("\"orientation\"");
  ASSERT_NE(last, trajectory.npos);
  const auto open = trajectory.find('[', last);
  trajectory.replace(open, trajectory.find(']', last) - open, "[9, 0, 0, 0");
  const auto line = 1 + std::count(trajectory.begin(), trajectory.begin() + static_cast<std::ptrdiff_t>(last), '\n');
  write("t.json", trajectory);
  const std::string error = refused("simulate t.json --from 2 --steps 1");
  EXPECT_TRUE(error.starts_with("graphsolve: t.json:" + std::to_string(line) + ": record 2: body ")) << error;
}

TEST_F(Cli, TextsOfFilesAreQuotedInOneLineWithoutWhatATerminalObeys) {
  write("a.json", R"({"format": "graphsolve-scene\nand\u001b[31m"})");
  EXPECT_EQ(refused("simulate a.json"),
            "graphsolve: a.json:1: format: is 'graphsolve-scene\\nand\\x1b[31m', expected 'graphsolve-scene'\n");
  write("m.json", R"({"format": "graphsolve-blocks", "version": 1, "blocks": [1], "edges": [{"from": "a\nb", "to": "c"}]})");
  write("m.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
  EXPECT_EQ(refused("solve m.mtx --blocks m.json"), "graphsolve: m.json:1: edges[0].from: there is no block 'a\\nb'\n");
}

TEST_F(Cli, ContactsThatCannotMoveHaveNoDistance) {
  write("a.toml",
        "format = 'graphsolve-scene'\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = 'post'\nmass = 1\n"
        "inertia = [1, 1, 1]\n[[joints]]\nname = 'bolt'\ntype = 'fixed'\nparent = 'world'\nchild = 'post'\n"
        "[[contacts]]\nname = 'foot'\nbody = 'post'\n");
  const Outcome outcome = run("simulate a.toml --steps 2");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("none: fixed joints hold all bodies with contacts at the world"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("inf"), std::string::npos) << outcome.out;
}

TEST_F(Cli, EnergyBeyondTheLargestNumberIsSaidAndNotPrinted) {
  write("a.toml",
        "format = 'graphsolve-scene'\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = 'star'\nmass = 1e200\n"
        "inertia = [1, 1, 1]\nposition = [0, 0, 1e200]\n");
  const Outcome outcome = run("simulate a.toml --steps 0 --summary s.json");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("beyond the largest number"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("nan"), std::string::npos) << outcome.out;
  EXPECT_NE(text("s.json").find("\"end\": null"), std::string::npos) << text("s.json");
}

TEST_F(Cli, RecordsThatAreNotThereAreRefused) {
  EXPECT_EQ(refused("simulate disc --from 3"), "graphsolve: disc: holds no records, so it cannot be continued\n");
  ASSERT_EQ(run("simulate disc --steps 3 --out t.json").code, 0);
  EXPECT_EQ(refused("simulate t.json --from 4"), "graphsolve: t.json: has no record 4 (it holds 4 between 0 and 3)\n");
}

TEST_F(Cli, PathsThatCannotBeWrittenAreRefusedBeforeSimulating) {
  EXPECT_EQ(refused("simulate disc --out no/t.json"), "graphsolve: cannot write 'no/t.json': No such directory\n");
  EXPECT_EQ(refused("simulate disc --out t.json --summary no/s.json"),
            "graphsolve: cannot write 'no/s.json': No such directory\n");
  EXPECT_NE(refused("simulate disc --out t.txt").find("ends in .json or .csv"), std::string::npos);
}

TEST_F(Cli, OutputsInOneFileAreRefusedHoweverItIsSpelled) {
  EXPECT_EQ(refused("simulate disc --out t.json --summary ./t.json"),
            "graphsolve: --out and --summary are the same file './t.json'\n");
  EXPECT_EQ(refused("analyze disc --json x --dot x"), "graphsolve: --json and --dot are the same file 'x'\n");
  EXPECT_EQ(refused("analyze disc --svg " + path("x") + " --json x"),
            "graphsolve: --json and --svg are the same file '" + path("x") + "'\n");
  EXPECT_EQ(refused("analyze disc --svg x-tree.dot --dot x.dot"),
            "graphsolve: --svg and the tree of --dot are the same file 'x-tree.dot'\n");
}

TEST_F(Cli, WhatIsReadIsNeverOverwrittenWhateverItIsCalled) {
  ASSERT_EQ(run("simulate disc --steps 3 --out t.json").code, 0);
  const std::string before = text("t.json");
  fs::create_symlink("t.json", path("link.json"));
  fs::create_hard_link(path("t.json"), path("twin.json"));
  EXPECT_EQ(refused("simulate t.json --out t.json"), "graphsolve: --out would overwrite the input 't.json'\n");
  EXPECT_EQ(refused("simulate t.json --from 1 --steps 1 --out ./t.json"),
            "graphsolve: --out would overwrite the input 't.json'\n");
  EXPECT_EQ(refused("simulate t.json --summary link.json"), "graphsolve: --summary would overwrite the input 't.json'\n");
  EXPECT_EQ(refused("simulate twin.json --out t.json"), "graphsolve: --out would overwrite the input 'twin.json'\n");
  EXPECT_EQ(refused("analyze t.json --svg t.json"), "graphsolve: --svg would overwrite the input 't.json'\n");
  EXPECT_EQ(text("t.json"), before);
  write("disc", "a file that is not the scene");
  EXPECT_EQ(run("analyze disc --json disc").code, 0);
}

TEST_F(Cli, AnInstructionSetThatIsNoneIsRefused) {
  for (const char* command : {"simulate disc --steps 1", "rollout disc --copies 3 --steps 1 --threads 2"}) {
    const Outcome wrong = run(command, "GRAPHSOLVE_SIMD=avx1024");
    EXPECT_EQ(wrong.code, 2);
    EXPECT_EQ(wrong.err, "graphsolve: GRAPHSOLVE_SIMD is 'avx1024'; there are: plain, avx2, avx512\n");
    for (const char* right : {"GRAPHSOLVE_SIMD=plain", "GRAPHSOLVE_SIMD=avx512", "GRAPHSOLVE_SIMD="})
      EXPECT_EQ(run(command, right).code, 0) << right;
  }
}

TEST_F(Cli, AFullDiskIsSaidAndGivesCodeTwo) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  fs::create_symlink("/dev/full", path("t.json"));
  const Outcome outcome = run("simulate snake:n=20 --out t.json");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err, "graphsolve: cannot write 't.json': No space left on device\n");
  for (const char* command : {"--help", "scenes", "simulate disc --steps 1", "analyze disc"}) {
    const Outcome full = run(std::string(command) + " >/dev/full)", "(");
    EXPECT_EQ(full.code, 2) << command;
    EXPECT_TRUE(full.err.starts_with("graphsolve: cannot write to ")) << command << full.err;
    EXPECT_EQ(std::count(full.err.begin(), full.err.end(), '\n'), 1) << full.err;
  }
}

TEST_F(Cli, AReaderThatHasGoneCostsNoFile) {
  for (const char* command : {"analyze snake:n=2000 --json out", "simulate disc --steps 2 --summary out"}) {
    fs::remove(path("out"));
    static_cast<void>(run(std::string(command) + " | true)", "("));
    EXPECT_TRUE(nlohmann::json::accept(text("out"))) << command;
  }
}

TEST_F(Cli, AnInterruptedRunKeepsWhatItHasAndSaysSo) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome outcome =
        run_and_signal("simulate snake:n=50 --duration 100000 --out t.json", signal);
    EXPECT_EQ(outcome.code, 128 + signal);
    EXPECT_NE(outcome.err.find("stopped after step"), std::string::npos) << outcome.err;
    const auto trajectory = read_scene(path("t.json"));
    EXPECT_GT(trajectory.steps.size(), 1u);
    EXPECT_EQ(trajectory.steps.back().step + 1, static_cast<int>(trajectory.steps.size()));
    for (const std::string& name : entries()) EXPECT_FALSE(name.ends_with(".part")) << name;
    fs::remove(path("t.json"));
  }
}

}  // namespace test_cli
