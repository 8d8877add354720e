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

namespace test_rollout_files {

// `graphsolve rollout`: files that it goes on with or merges, and those that it refuses to.

namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(Rollout, MergingTakesNoMemoryForTheRecords) {
  ASSERT_EQ(run("disc:c=4 --copies 2 --steps 1 --out two.jsonl"), 0) << err_;
  nlohmann::ordered_json header = nlohmann::ordered_json::parse(text("two.jsonl").substr(0, text("two.jsonl").find('\n')));
  constexpr int copies = 800, shards = 2;
  const std::string long_text(100000, 'x');  // 80 MB in all
  header["copies"] = copies;
  for (int shard = 0; shard < shards; ++shard) {
    header["shard"] = std::to_string(shard) + "/" + std::to_string(shards);
    std::ofstream out(path("part" + std::to_string(shard)));
    out << header.dump() << '\n';
    for (int copy = shard * copies / shards; copy < (shard + 1) * copies / shards; ++copy)
      out << R"({"copy":)" << copy << R"(,"status":"solved","steps":1,"start_correction_m_per_s":0.0,"x":")" << long_text
          << "\"}\n";
  }
  ASSERT_EQ(run("--merge part0 part1 --out all.jsonl", "ulimit -v 90000 &&"), 0) << err_;
  EXPECT_EQ(size("all.jsonl") + header.dump().size() + 1, size("part0") + size("part1"));
}

TEST_F(Rollout, RefusesToGoOnWithAnotherRolloutsFile) {
  ASSERT_EQ(run("disc --copies 2 --steps 3 --out a.jsonl"), 0) << err_;
  const std::string before = text("a.jsonl");
  EXPECT_EQ(run("disc --copies 2 --steps 4 --out a.jsonl"), 2);
  EXPECT_EQ(err_, "graphsolve: a.jsonl: holds a rollout with steps 3, not 4\n");
  EXPECT_EQ(run("disc --copies 2 --steps 3 --seed 9 --out a.jsonl"), 2);
  EXPECT_EQ(err_, "graphsolve: a.jsonl: holds a rollout with seed 0, not 9\n");
  EXPECT_EQ(text("a.jsonl"), before);
  std::ofstream(path("letter.txt")) << "Dear all,\n";
  EXPECT_EQ(run("disc --copies 2 --steps 3 --out letter.txt"), 2);
  EXPECT_EQ(text("letter.txt"), "Dear all,\n");
}

TEST_F(Rollout, TheInstructionSetIsPartOfTheHeader) {
  if (graphsolve::simd::instruction_sets().size() < 2) GTEST_SKIP() << "this machine has one instruction set";
  const std::string other = "GRAPHSOLVE_SIMD=avx2", arguments = "disc --copies 4 --steps 3 --out ";
  ASSERT_EQ(run(arguments + "whole", other), 0) << err_;
  EXPECT_EQ(lines("whole")[0]["instruction_set"], "avx2");
  const std::string whole = text("whole"), begun = whole.substr(0, whole.find("{\"copy\":2,"));
  write("begun", begun);
  EXPECT_EQ(run(arguments + "begun", "GRAPHSOLVE_SIMD=plain"), 2);
  EXPECT_EQ(err_,
            "graphsolve: begun: was computed by the instruction set avx2, not plain, and last digits differ: "
            "GRAPHSOLVE_SIMD=avx2 goes on with it where the processor can, another file begins anew\n");
  EXPECT_EQ(text("begun"), begun);
  ASSERT_EQ(run(arguments + "begun", other), 0) << err_;
  EXPECT_EQ(text("begun"), whole);

  ASSERT_EQ(run(arguments + "part0 --shard 0/2", "GRAPHSOLVE_SIMD=plain"), 0) << err_;
  ASSERT_EQ(run(arguments + "part1 --shard 1/2", other), 0) << err_;
  EXPECT_EQ(run("--merge part0 part1 --out merged"), 2);
  EXPECT_EQ(err_,
            "graphsolve: part1: was computed by the instruction set avx2, not plain, and last digits differ: compute all "
            "shards by one, such as GRAPHSOLVE_SIMD=plain everywhere\n");
  EXPECT_FALSE(fs::exists(path("merged")));
}

TEST_F(Rollout, AFileThatAnotherRunWritesIsLeftAlone) {
  ASSERT_EQ(run("disc --copies 2 --steps 3 --out a.jsonl"), 0) << err_;
  const std::string before = text("a.jsonl");
  const int other = open(path("a.jsonl").c_str(), O_RDWR);
  ASSERT_EQ(flock(other, LOCK_EX | LOCK_NB), 0);
  EXPECT_EQ(run("disc --copies 2 --steps 3 --out a.jsonl"), 2);
  EXPECT_EQ(err_, "graphsolve: a.jsonl: another rollout is writing this file; wait for it, or give --out another name\n");
  EXPECT_EQ(text("a.jsonl"), before);
  close(other);
  EXPECT_EQ(run("disc --copies 2 --steps 3 --out a.jsonl"), 0) << err_;
}

TEST_F(Rollout, LinesWithValuesOfAnotherTypeAreRefused) {
  ASSERT_EQ(run("disc --copies 2 --steps 3 --out a.jsonl"), 0) << err_;
  const std::string header = text("a.jsonl").substr(0, text("a.jsonl").find('\n') + 1);
  for (const char* record : {R"({"copy":0,"steps":"x","status":"solved"})", R"({"copy":0,"steps":3,"status":5})",
                             R"({"copy":0,"steps":3})", R"({"copy":0,"steps":3,"status":"solved","place":[]})",
                             R"({"copy":0,"steps":-3,"status":"solved"})", R"({"copy":0,"steps":5000000000,"status":"solved"})",
                             R"({"copy":0,"steps":18446744073709551615,"status":"solved"})"}) {
    write("bad.jsonl", header + record + "\n");
    EXPECT_TRUE(Program::refused("rollout disc --copies 2 --steps 3 --out bad.jsonl")
                    .starts_with("graphsolve: bad.jsonl:2: is not a line of a rollout (its key '"))
        << record;
  }
  for (const char* first : {R"({"format":"graphsolve-rollout","shard":5})", R"({"format":"graphsolve-rollout"})",
                            R"({"shard":"0/1","copies":"x"})", R"({"shard":"0/1"})",
                            R"({"shard":"0/1","instruction_set":"plain","copies":-1})"}) {
    write("bad.jsonl", std::string(first) + "\n");
    EXPECT_TRUE(Program::refused("rollout --merge bad.jsonl --out b")
                    .starts_with("graphsolve: bad.jsonl:1: is not a line of a rollout (its key '"))
        << first;
  }
}

TEST_F(Rollout, LinesNestedDeeperThanAStackIsAreRefusedAndLeftAlone) {
  const std::string deep = R"({"format":)" + std::string(1000000, '[') + std::string(1000000, ']') + "}\n";
  write("deep.jsonl", deep);
  EXPECT_EQ(Program::refused("rollout disc --copies 2 --steps 3 --out deep.jsonl"),
            "graphsolve: deep.jsonl:1: is not a line of a rollout\n");
  EXPECT_EQ(Program::refused("rollout --merge deep.jsonl --out b"), "graphsolve: deep.jsonl:1: is not a line of a rollout\n");
  EXPECT_EQ(text("deep.jsonl"), deep);
}

TEST_F(Rollout, MergeNamesAShardThatIsMissingOrIncomplete) {
  for (const char* shard : {"0", "1"})
    ASSERT_EQ(run(work + " --shard " + shard + "/2 --out part" + shard), 0) << err_;
  EXPECT_EQ(run("--merge part0 --out a"), 2);
  EXPECT_EQ(err_, "graphsolve: shard 1/2 is missing\n");
  EXPECT_EQ(run("--merge part0 part1 part0 --out a"), 2);
  EXPECT_EQ(err_, "graphsolve: shard 0/2 is there twice: part0 and part0\n");
  EXPECT_EQ(run("--merge part0 part1 --out part1"), 2);
  EXPECT_EQ(err_, "graphsolve: --out would overwrite the input 'part1'\n");
  ASSERT_EQ(run(work + " --shard 1/3 --out third"), 0) << err_;
  EXPECT_EQ(run("--merge part0 third --out a"), 2);
  EXPECT_EQ(err_, "graphsolve: third: is shard 1/3, and part0 is 0/2\n");
  fs::resize_file(path("part1"), fs::file_size(path("part1")) - 5);
  EXPECT_EQ(run("--merge part0 part1 --out a"), 2);
  EXPECT_EQ(err_, "graphsolve: part1: is not complete: copy 22 is due\n");
  EXPECT_FALSE(fs::exists(path("a")));
}

TEST_F(Rollout, MergeTakesNoOtherOptions) {
  for (const char* shard : {"0", "1"})
    ASSERT_EQ(run(work + " --shard " + shard + "/2 --out part" + shard), 0) << err_;
  for (const std::string option : {"--copies", "--steps", "--seed", "--tolerance", "--threads", "--lanes"})
    EXPECT_EQ(Program::refused("rollout --merge part0 part1 --out a " + option + " 3"),
              "graphsolve: --merge takes files of shards and --out, no " + option + "\n");
  EXPECT_NE(Program::refused("rollout --merge part0 part1 --out a --vary mass=1:2").find("no --vary\n"), std::string::npos);
  EXPECT_NE(Program::refused("rollout --merge part0 part1 --out a --shard 0/2").find("no --shard\n"), std::string::npos);
}

TEST_F(Rollout, MergeOverwritesNothingButAFileOfTheSameRollout) {
  for (const char* shard : {"0", "1"})
    ASSERT_EQ(run(work + " --shard " + shard + "/2 --out part" + shard), 0) << err_;
  ASSERT_EQ(run("disc --copies 2 --steps 3 --out other.jsonl"), 0) << err_;
  write("letter.txt", "Dear all,\n");
  write("word.txt", "Dear");
  for (const std::string name : {"other.jsonl", "letter.txt", "word.txt"}) {
    const std::string before = text(name);
    EXPECT_EQ(Program::refused("rollout --merge part0 part1 --out " + name),
              "graphsolve: '" + name + "' is there already and not a file of this rollout: give --out another name, or remove it\n");
    EXPECT_EQ(text(name), before);
  }
  write("empty", "");
  ASSERT_EQ(run("--merge part0 part1 --out empty"), 0) << err_;
  const std::string merged = text("empty");
  write("begun", merged.substr(0, merged.find("{\"copy\":3,")));
  ASSERT_EQ(run("--merge part0 part1 --out begun"), 0) << err_;
  EXPECT_EQ(text("begun"), merged);
  ASSERT_EQ(run("--merge part0 part1 --out begun"), 0) << "again";
}

}  // namespace test_rollout_files
