#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "graphsolve/simd/lanes.hpp"
#include "physics/batch_variation.hpp"
#include "physics/simulator.hpp"
#include "rollout_program.hpp"

namespace test_rollout {

// `graphsolve rollout`: the same bytes for any threads, lanes and shards, and after a kill.

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(Rollout, WritesOneRecordPerCopyInOrderWithWhatWasVaried) {
  ASSERT_EQ(run(work + " --out a.jsonl"), 0) << err_;
  const std::vector<json> all = lines("a.jsonl");
  ASSERT_EQ(all.size(), 24u);
  EXPECT_EQ(all[0]["format"], "graphsolve-rollout");
  EXPECT_EQ(all[0]["copies"], 23);
  std::set<double> frictions;
  for (int i = 0; i < 23; ++i) {
    const json& record = all[i + 1];
    EXPECT_EQ(record["copy"], i);
    EXPECT_EQ(record["status"], "solved");
    EXPECT_EQ(record["steps"], 30);
    const double friction = record["vary"]["friction"];
    EXPECT_GE(friction, 0.1);
    EXPECT_LE(friction, 0.9);
    frictions.insert(friction);
    EXPECT_GE(record["smallest_distance_m"].get<double>(), -1e-9);
  }
  EXPECT_EQ(frictions.size(), 23u) << "every copy its own";
  EXPECT_NE(out_.find("env-steps/s by 1 process of 1 thread"), std::string::npos);
  ASSERT_EQ(run(work + " --threads 4096"), 0) << err_;
  EXPECT_NE(out_.find("by 1 process of 23 threads"), std::string::npos) << "no more than there are copies";
}

TEST_F(Rollout, BytesDoNotDependOnThreadsLanesOrShards) {
  ASSERT_EQ(run(work + " --out one.jsonl"), 0) << err_;
  const std::string expected = text("one.jsonl");
  for (const char* way : {"--threads 2", "--threads 4 --lanes 3", "--lanes 1", "--lanes 64"}) {
    ASSERT_EQ(run(work + " --out other.jsonl " + way), 0) << err_;
    EXPECT_EQ(text("other.jsonl"), expected) << way;
    fs::remove(path("other.jsonl"));
  }
  for (const char* shard : {"0", "1", "2"})
    ASSERT_EQ(run(work + " --shard " + shard + "/3 --threads 2 --out part" + shard), 0) << err_;
  ASSERT_EQ(run("--merge part1 part0 part2 --out merged.jsonl"), 0) << err_;
  EXPECT_EQ(text("merged.jsonl"), expected);
}

TEST_F(Rollout, AKilledRunGoesOnToTheSameBytes) {
  const std::string long_work = "disc:c=8 --copies 800 --steps 60 --vary friction=0.1:0.9 --threads 2";
  ASSERT_EQ(run(long_work + " --out whole.jsonl"), 0) << err_;
  const std::string expected = text("whole.jsonl");
  const int status = signal_amid(long_work + " --out killed.jsonl", "killed.jsonl", SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(status)) << "it was to be killed before its end";
  ASSERT_LT(size("killed.jsonl"), expected.size());
  // What a kill in the middle of a write leaves: half a line.
  fs::resize_file(path("killed.jsonl"), size("killed.jsonl") - 20);
  ASSERT_EQ(run(long_work + " --out killed.jsonl"), 0) << err_;
  EXPECT_EQ(text("killed.jsonl"), expected);
  EXPECT_NE(out_.find("done before"), std::string::npos) << out_;
  ASSERT_EQ(run(long_work + " --out killed.jsonl"), 0) << "a complete file stays as it is";
  EXPECT_EQ(text("killed.jsonl"), expected);
}

TEST_F(Rollout, AnInterruptedRunEndsCleanlyAndGoesOn) {
  const std::string long_work = "disc:c=8 --copies 1500 --steps 60 --vary friction=0.1:0.9";
  ASSERT_EQ(run(long_work + " --out whole.jsonl"), 0) << err_;
  for (const int signal : {SIGINT, SIGHUP}) {
    fs::remove(path("cut.jsonl"));
    const int status = signal_amid(long_work + " --out cut.jsonl", "cut.jsonl", signal);
    ASSERT_TRUE(WIFEXITED(status)) << signal;
    EXPECT_EQ(WEXITSTATUS(status), 128 + signal);
    ASSERT_EQ(run(long_work + " --out cut.jsonl"), 0) << err_;
    EXPECT_EQ(text("cut.jsonl"), text("whole.jsonl")) << signal;
  }
}

TEST_F(Rollout, TheStepAfterTheMostStepsThereCanBeIsNamed) {
  ASSERT_EQ(run("disc --copies 1 --steps 3 --out a.jsonl"), 0) << err_;
  write("long.jsonl", text("a.jsonl").substr(0, text("a.jsonl").find('\n') + 1) +
                          R"({"copy":0,"steps":2147483647,"status":"max_iterations","start_correction_m_per_s":0})" "\n");
  EXPECT_EQ(run("--merge long.jsonl --out b.jsonl"), 1);
  EXPECT_NE(err_.find("copy 0: step 2147483648 failed"), std::string::npos) << err_;
}

TEST_F(Rollout, ACopyThatFailsIsNamedAndTheOthersAreDone) {
  write_doomed_tops("doomed.json");
  ASSERT_EQ(run("doomed.json --copies 20 --steps 10 --vary mass=0.01:2 --seed 3 --out a.jsonl"), 1) << err_;
  int failed = 0, solved = 0;
  for (const json& record : lines("a.jsonl")) {
    if (!record.contains("copy")) continue;
    if (record["status"] == "solved") {
      ++solved;
      EXPECT_EQ(record["steps"], 10);
      continue;
    }
    ++failed;
    EXPECT_EQ(record["steps"], 4);
    EXPECT_NE(err_.find("copy " + std::to_string(record["copy"].get<int>()) + ": step 5 failed"), std::string::npos) << err_;
  }
  EXPECT_GT(failed, 0) << "the test shows nothing";
  EXPECT_GT(solved, 0) << "the test shows nothing";
}

TEST_F(Rollout, ManyFailuresAreTenNamesACountAndEachCauseOnce) {
  write_doomed_tops("doomed.json");
  const std::string command = "doomed.json --copies 21 --steps 10 --vary mass=0.01:0.02";
  const auto complains = [&] {
    EXPECT_EQ(times_said(": step 5 failed, "), 10) << err_;
    EXPECT_EQ(times_said("graphsolve: and 11 more copies failed\n"), 1) << err_;
    const std::string status = lines("a.jsonl")[1]["status"];
    EXPECT_EQ(times_said("graphsolve: " + status + ": "), 1) << err_;
    EXPECT_EQ(times_said("take a shorter time step or a larger tolerance\n"), 1) << err_;
  };
  ASSERT_EQ(run(command + " --out a.jsonl"), 1) << err_;
  complains();
  ASSERT_EQ(run(command + " --out a.jsonl"), 1) << "nothing is left to do, and the outcome is the same";
  complains();
  ASSERT_EQ(run("--merge a.jsonl --out b.jsonl"), 1) << err_;
  complains();
  ASSERT_EQ(run("doomed.json --copies 11 --steps 10 --vary mass=0.01:0.02"), 1) << err_;
  EXPECT_EQ(times_said("graphsolve: and 1 more copy failed\n"), 1) << err_;
}

TEST_F(Rollout, WrongInputIsOneSentence) {
  const auto refused = [&](const std::string& arguments) { return Program::refused("rollout " + arguments); };
  EXPECT_EQ(refused("disc --steps 3"), "graphsolve: rollout: --copies is required\n");
  EXPECT_EQ(refused("disc --copies 2 --steps 3 --shard 2/2"), "graphsolve: shard '2/2' is not I/N with 0 <= I < N\n");
  EXPECT_EQ(refused("disc --copies 2 --steps 3 --vary friction=1"), "graphsolve: vary 'friction=1' is not KEY=LOW:HIGH\n");
  EXPECT_EQ(refused("disc --copies 2 --steps 3 --vary wheel.mass=1:2"),
            "graphsolve: vary 'wheel.mass': the scene has no body 'wheel'\n");
  // Bounds are tried before any copy: most copies of these would pass.
  EXPECT_EQ(refused("box_on_slope --copies 99 --steps 3 --vary friction=-1e-9:1"),
            "graphsolve: vary 'friction': the bound -1e-09 will not do: contact 'corner 0': friction -1e-09 is not > "
            "0; take a small coefficient, such as 1e-6 (without any, a contact is another law, and all copies share "
            "one)\n");
  EXPECT_EQ(refused("hopper --copies 99 --steps 3 --vary x.stiffness=1:1e999"),
            "graphsolve: vary 'x.stiffness=1:1e999': '1e999' is not a number\n");
  EXPECT_NE(refused("quadruped --copies 99 --steps 3 --vary 'front left hip joint.stiffness=-1e-9:1'")
                .find("the bound -1e-09 will not do: revolute joint 'front left hip joint': "),
            std::string::npos);
  EXPECT_EQ(refused("disc --copies 99 --steps 3 --vary mass=-1e-9:1"),
            "graphsolve: vary 'mass': the bound -1e-09 will not do: body 'disc': mass -1e-09 kg is not > 0\n");
  EXPECT_EQ(refused("disc --copies 99 --steps 3 --vary gravity=-1e-9:1"),
            "graphsolve: vary 'gravity': the bound -1e-09 will not do: scene: gravity -1e-09 m/s^2 is not >= 0\n");
  EXPECT_NE(refused("disc --copies 2 --steps 3 --vary colour=1:2").find("vary 'colour': unknown key; there are: friction"),
            std::string::npos);
  EXPECT_NE(refused("disc --copies 2000000000 --steps 3 --lanes 2147483647 --out x.jsonl")
                .find("a batch of 2000000000 lanes needs "),
            std::string::npos);
  EXPECT_NE(refused("disc --copies 0 --steps 3").find("must be a whole number >= 1, not 0"), std::string::npos);
  // Shards of so many would overlap: copies times shards does not fit.
  EXPECT_NE(refused("disc --copies 9223372036854775807 --steps 3 --shard 2/3").find("must not be above"), std::string::npos);
  for (const std::string seed : {"-1", "a", "1.5", "18446744073709551616"})
    EXPECT_NE(refused("disc --copies 2 --steps 3 --seed " + seed)
                  .find("--seed: must be a whole number from 0 to 18446744073709551615, not " + seed),
              std::string::npos);
  for (const char* tolerance : {"nan", "inf", "1e400", "0", "-1"})
    EXPECT_NE(refused("disc --copies 2 --steps 3 --tolerance " + std::string(tolerance)).find("must be a number > 0"),
              std::string::npos);
  if (fs::exists("/dev/zero")) {
    EXPECT_NE(refused("disc --copies 2 --steps 3 --out /dev/zero").find("only an ordinary file"), std::string::npos);
  }
  EXPECT_EQ(refused("disc --copies 5 --steps 3 --threads 4097"),
            "graphsolve: --threads: must not be above 4096 (see 'graphsolve rollout --help')\n");
  EXPECT_NE(refused("--merge nothing.jsonl --out a").find("nothing.jsonl: cannot be read: No such file or directory"), std::string::npos);
}

TEST_F(Rollout, StartsThatTheJointsCorrectAreRecordedAndTheLargestIsPrinted) {
  const std::string command = "snake:n=3 --copies 3 --steps 2 --vary 'start.link 1.velocity.x=1:2' --out a.jsonl";
  ASSERT_EQ(run(command), 0) << err_;
  double largest = 0;
  for (int copy = 0; copy < 3; ++copy) {
    // What `simulate` says of this scene.
    physics::Mechanism scene = physics::built_in_scene("snake:n=3");
    physics::set_value(scene, "start.link 1.velocity.x", lines("a.jsonl")[copy + 1]["vary"]["start.link 1.velocity.x"]);
    const double expected = physics::Simulator(scene).start_correction();
    ASSERT_GT(expected, 0.1);
    EXPECT_EQ(lines("a.jsonl")[copy + 1]["start_correction_m_per_s"], expected);
    largest = std::max(largest, expected);
  }
  char sentence[100];
  std::snprintf(sentence, sizeof sentence, "start correction       up to %.3g m/s, to agree with the joints\n", largest);
  EXPECT_NE(out_.find(sentence), std::string::npos) << out_;
  ASSERT_EQ(run(command), 0) << "read from the file";
  EXPECT_NE(out_.find(sentence), std::string::npos) << out_;
  ASSERT_EQ(run("snake:n=3 --copies 3 --steps 2 --vary start.velocity.x=1:2"), 0) << err_;
  EXPECT_EQ(out_.find("start correction"), std::string::npos) << "all move alike, so the joints agree: " << out_;
}

TEST_F(Rollout, KeysApplyInTheOrderGiven) {
  const auto start_energy = [&](const std::string& keys) {
    fs::remove(path("a.jsonl"));
    EXPECT_EQ(run("disc --copies 1 --steps 1 --out a.jsonl " + keys), 0) << err_;
    return lines("a.jsonl")[1]["energy_J"]["start"].get<double>();
  };
  const double five = start_energy("--vary disc.mass=5:5"), ten = start_energy("--vary disc.mass=10:10");
  ASSERT_GT(std::abs(ten - five), 1e-3 * std::abs(ten));
  EXPECT_NEAR(start_energy("--vary mass=2:2 --vary disc.mass=5:5"), five, 1e-12 * std::abs(five));
  EXPECT_NEAR(start_energy("--vary disc.mass=5:5 --vary mass=2:2"), ten, 1e-12 * std::abs(ten));
  const double fast = start_energy("--vary start.disc.velocity.x=3:3"), faster = start_energy("--vary start.disc.velocity.x=4:4");
  ASSERT_GT(std::abs(faster - fast), 1e-3 * std::abs(fast));
  EXPECT_NEAR(start_energy("--vary start.velocity.x=1:1 --vary start.disc.velocity.x=3:3"), fast, 1e-12 * std::abs(fast));
  EXPECT_NEAR(start_energy("--vary start.disc.velocity.x=3:3 --vary start.velocity.x=1:1"), faster, 1e-12 * std::abs(faster));
}

}  // namespace test_rollout
