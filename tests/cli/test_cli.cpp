#include <nlohmann/json.hpp>
#include <algorithm>
#include <filesystem>
#include <string>

#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "program.hpp"

namespace test_cli {

// What all commands share: help, files, signals.

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
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
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
