#include <algorithm>
#include <filesystem>
#include <string>

#include "physics/scene_io.hpp"
#include "program.hpp"

namespace test_wrong_input {

// Options and scenes that are refused, in one line.

namespace fs = std::filesystem;

class WrongInput : public Program {};

TEST_F(WrongInput, WrongOptionsAreRefusedInOneLine) {
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
  EXPECT_EQ(refused("simulate disc -- --steps"), "graphsolve: '--steps' is one word too many (see 'graphsolve simulate --help')\n");
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
  // A name that was forgotten: the next option would be the file, and be missing.
  EXPECT_EQ(refused("solve a.mtx --out --transposed"),
            "graphsolve: --out: needs a file name, not --transposed (./--transposed is one) (see 'graphsolve solve --help')\n");
  for (const char* command : {"simulate disc --summary --steps 3", "analyze disc --json --svg a.svg", "study scaling --out --quick",
                              "rollout --merge --out a.jsonl", "solve a.mtx --blocks --transposed"})
    EXPECT_NE(refused(command).find(": needs a file name, not --"), std::string::npos) << command;
  EXPECT_NE(refused("simulate " + std::string(5000, 'a')).find("there is no built-in scene 'aaa"), std::string::npos);
  EXPECT_NE(refused("simulate disc --steps 3 --duration 1").find("excludes"), std::string::npos);
  EXPECT_NE(refused("simulate disc --from 3 --time-step 1").find("excludes"), std::string::npos);
  EXPECT_NE(refused("simulate disc --friction-model cone").find("must be pyramid or aligned, not cone"),
            std::string::npos);
  EXPECT_NE(refused("simulate disc --tolerance nan").find("must be a number > 0, not nan"), std::string::npos);
  EXPECT_NE(refused("simulate disc --fast").find("there is no option '--fast'; there are: "), std::string::npos);
}

TEST_F(WrongInput, WrongScenesAreRefusedInOneLine) {
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

TEST_F(WrongInput, EmptySceneFilesAreSaidToBeEmpty) {
  for (const std::string name : {"empty.json", "empty.toml"}) {
    write(name, "");
    EXPECT_EQ(refused("simulate " + name),
              "graphsolve: " + name + ": is empty; a scene has at least the keys format, version, time_step and bodies\n");
  }
}

TEST_F(WrongInput, AWrongValueOfARecordIsNamedWithItsLine) {
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

/// What only the simulator looks at, with the line of the record.
TEST_F(WrongInput, ARecordThatNoRunHasWrittenIsNamedWithItsFileAndLine) {
  ASSERT_EQ(run("simulate pendulum:n=2 --steps 2 --out t.json").code, 0);
  physics::Trajectory trajectory = physics::read_scene(path("t.json"));
  trajectory.steps[1].bodies[1].position.z() += 2;
  physics::write_trajectory_json(trajectory, path("t.json"));
  const std::string line = std::to_string(physics::line_in_scene(path("t.json"), "steps[1]"));
  EXPECT_EQ(refused("simulate t.json --from 1 --steps 1"),
            "graphsolve: t.json:" + line + ": record 1: the points of joint 'joint 1' are 2 m apart\n");
}

TEST_F(WrongInput, TextsOfFilesAreQuotedInOneLineWithoutWhatATerminalObeys) {
  write("a.json", R"({"format": "graphsolve-scene\nand\u001b[31m"})");
  EXPECT_EQ(refused("simulate a.json"),
            "graphsolve: a.json:1: format: is 'graphsolve-scene\\nand\\x1b[31m', expected 'graphsolve-scene'\n");
  write("m.json", R"({"format": "graphsolve-blocks", "version": 1, "blocks": [1], "edges": [{"from": "a\nb", "to": "c"}]})");
  write("m.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
  EXPECT_EQ(refused("solve m.mtx --blocks m.json"), "graphsolve: m.json:1: edges[0].from: there is no block 'a\\nb'\n");
}

TEST_F(WrongInput, RecordsThatAreNotThereAreRefused) {
  EXPECT_EQ(refused("simulate disc --from 3"), "graphsolve: disc: holds no records, so it cannot be continued\n");
  ASSERT_EQ(run("simulate disc --steps 3 --out t.json").code, 0);
  EXPECT_EQ(refused("simulate t.json --from 4"), "graphsolve: t.json: has no record 4 (it holds 4 between 0 and 3)\n");
}

TEST_F(WrongInput, AnInstructionSetThatIsNoneIsRefused) {
  for (const char* command : {"simulate disc --steps 1", "rollout disc --copies 3 --steps 1 --threads 2"}) {
    const Outcome wrong = run(command, "GRAPHSOLVE_SIMD=avx1024");
    EXPECT_EQ(wrong.code, 2);
    EXPECT_EQ(wrong.err, "graphsolve: GRAPHSOLVE_SIMD is 'avx1024'; there are: plain, avx2, avx512\n");
    for (const char* right : {"GRAPHSOLVE_SIMD=plain", "GRAPHSOLVE_SIMD=avx512", "GRAPHSOLVE_SIMD="})
      EXPECT_EQ(run(command, right).code, 0) << right;
  }
}

}  // namespace test_wrong_input
