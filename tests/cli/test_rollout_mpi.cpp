#include <csignal>
#include <string>

#include "graphsolve/simd/lanes.hpp"
#include "rollout_program.hpp"

namespace test_rollout_mpi {

// `graphsolve rollout` under mpirun: the bytes of one process, and an end for all when one ends.

#ifdef GRAPHSOLVE_MPIRUN

namespace fs = std::filesystem;

class RolloutMpi : public Rollout {
 protected:
  /// By two processes, which are killed when they wait for each other for ever: that is code 137. `before` runs in each
  /// process before the program, and knows its $OMPI_COMM_WORLD_RANK.
  int mpirun(const std::string& arguments, const std::string& before = "") { return processes(2, arguments, before); }
  int processes(int count, const std::string& arguments, const std::string& before = "") {
    return run(arguments, environment_ + "timeout -s KILL 60 '" GRAPHSOLVE_MPIRUN "' --oversubscribe -np " +
                              std::to_string(count) + " sh -c '" + before + R"( exec "$@"' sh)");
  }
  [[nodiscard]] bool says(const std::string& sentence) const { return err_.find(sentence) != std::string::npos; }

  const std::string environment_ = "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 ";
  const std::string in_process_1_ = "test $OMPI_COMM_WORLD_RANK = 1 && ";
};

TEST_F(RolloutMpi, TwoProcessesWriteTheSameBytes) {
  ASSERT_EQ(run(work + " --out one.jsonl"), 0) << err_;
  ASSERT_EQ(mpirun(work + " --out two.jsonl"), 0) << err_;
  EXPECT_EQ(text("two.jsonl"), text("one.jsonl"));
  EXPECT_FALSE(fs::exists(path("two.jsonl.0-of-2"))) << "the parts are gone";
  EXPECT_NE(out_.find("by 2 processes"), std::string::npos) << out_;
}

TEST_F(RolloutMpi, ACompleteFileStaysAsItIs) {
  ASSERT_EQ(mpirun(work + " --out two.jsonl"), 0) << err_;
  const std::string expected = text("two.jsonl");
  ASSERT_EQ(mpirun(work + " --out two.jsonl"), 0) << err_;
  EXPECT_NE(out_.find("done before            23 copies"), std::string::npos) << out_;
  EXPECT_EQ(text("two.jsonl"), expected);
  EXPECT_EQ(entries().size(), 1u) << "no parts";
  EXPECT_EQ(mpirun(work + "1 --out two.jsonl"), 2);
  EXPECT_EQ(times_said("graphsolve: two.jsonl: holds a rollout with seed 7, not 71\n"), 1) << err_;
  write("two.jsonl", expected.substr(0, expected.size() - 5));
  EXPECT_EQ(mpirun(work + " --out two.jsonl"), 2);
  EXPECT_TRUE(says("graphsolve: two.jsonl: holds 22 of 23 copies, of a run without mpirun")) << err_;
}

TEST_F(RolloutMpi, WrongInputOfAllIsSaidOnce) {
  EXPECT_EQ(mpirun(work + " --shard 0/2 --out x"), 2);
  EXPECT_EQ(times_said("each process is a shard"), 1) << err_;
  EXPECT_EQ(mpirun("disc --copies 2 --steps 3 --vary wheel.mass=1:2"), 2);
  EXPECT_EQ(times_said("the scene has no body 'wheel'"), 1) << err_;
}

TEST_F(RolloutMpi, OneProcessThatCannotWriteEndsAll) {
  fs::create_directory(path("a.jsonl.1-of-2"));
  EXPECT_EQ(mpirun(work + " --out a.jsonl"), 2);
  EXPECT_TRUE(says("graphsolve: process 1 of 2: cannot write 'a.jsonl.1-of-2': Is a directory\n")) << err_;
}

TEST_F(RolloutMpi, AnExceptionOfTheLibraryInOneProcessEndsAll) {
  EXPECT_EQ(mpirun(work + " --out a.jsonl", in_process_1_ + "export GRAPHSOLVE_SIMD=none;"), 2);
  EXPECT_TRUE(says("GRAPHSOLVE_SIMD is 'none'; there are: plain, avx2, avx512\n")) << err_;
  EXPECT_FALSE(fs::exists(path("a.jsonl")));
}

TEST_F(RolloutMpi, OneProcessWithTooLittleMemoryEndsAllAmidTheWork) {
  EXPECT_EQ(mpirun("snake:n=3000 --copies 32 --steps 1 --out a.jsonl", in_process_1_ + "ulimit -v 300000;"), 2);
  EXPECT_TRUE(says("graphsolve: process 1 of 2: not enough memory for this scene or matrix\n")) << err_;
}

TEST_F(RolloutMpi, ProcessesOfDifferentInstructionSetsDoNotBegin) {
  if (graphsolve::simd::instruction_sets().size() < 2) GTEST_SKIP() << "this machine has one instruction set";
  EXPECT_EQ(mpirun(work + " --out a.jsonl", "export GRAPHSOLVE_SIMD=avx2;" + in_process_1_ + "export GRAPHSOLVE_SIMD=plain;"), 2);
  EXPECT_EQ(times_said("graphsolve: the processes compute by different instruction sets, 1 by plain, 1 by avx2, and last "
                       "digits differ: set GRAPHSOLVE_SIMD=plain for all of them\n"),
            1)
      << err_;
  EXPECT_TRUE(entries().empty());
}

TEST_F(RolloutMpi, FailuresAreNamedAsByOneProcess) {
  write_doomed_tops("doomed.json");
  const std::string command = "doomed.json --copies 17 --steps 10 --vary mass=0.01:0.02";
  ASSERT_EQ(run(command), 1);
  const std::string expected = err_;
  EXPECT_EQ(times_said("graphsolve: and 7 more copies failed\n"), 1) << err_;
  EXPECT_EQ(mpirun(command), 1);
  EXPECT_TRUE(says(expected)) << err_;
  EXPECT_EQ(times_said(": step 5 failed, "), 10) << err_;
}

TEST_F(RolloutMpi, WhatIsSaidOfCopiesIsSaidOnceForAll) {
  const std::string command = "disc:height=0 --copies 17 --steps 2 --tolerance 1 --vary start.position.z=-0.02:0.02";
  ASSERT_EQ(run(command), 0) << err_;
  const auto line = [&] {
    const auto begin = out_.find("starts inside ");
    return begin == std::string::npos ? std::string() : out_.substr(begin, out_.find('\n', begin) - begin);
  };
  const std::string expected = line();
  EXPECT_NE(expected.find(" copies begin inside a plane"), std::string::npos) << out_;
  ASSERT_EQ(mpirun(command), 0) << err_;
  EXPECT_EQ(line(), expected);
  EXPECT_EQ(times_said("graphsolve: note: a tolerance of 1 m/s"), 1) << err_;
}

TEST_F(RolloutMpi, StoppedItNamesThePartsAndWhatIsLeftAndGoesOn) {
  const std::string long_work = "disc:c=8 --copies 1500 --steps 60 --vary friction=0.1:0.9 --out cut.jsonl";
  // Each process is stopped when one of the files has some records.
  const std::string stop =
      "(for i in $(seq 3000); do test -n \"$(find cut.jsonl.1-of-2 -size +29k)\" && break; sleep 0.01; done; "
      "kill -TERM $$) >/dev/null 2>&1 &";
  EXPECT_EQ(mpirun(long_work, stop), 143) << err_;
  EXPECT_EQ(times_said("stopped by signal 15; the same command goes on from there"), 1) << err_;
  EXPECT_NE(out_.find("files                  cut.jsonl.*-of-2; cut.jsonl is made of them when all are complete\n"),
            std::string::npos)
      << out_;
  EXPECT_NE(out_.find("not done yet           "), std::string::npos) << out_;
  EXPECT_FALSE(fs::exists(path("cut.jsonl")));
  ASSERT_EQ(processes(3, long_work), 0) << err_;
  EXPECT_EQ(times_said("graphsolve: 'cut.jsonl.0-of-2' is of a run by 2 processes: this one, by 3, begins anew and leaves "
                       "it alone; mpirun -np 2 would go on with it\n"),
            1)
      << err_;
  const std::string anew = text("cut.jsonl");
  fs::remove(path("cut.jsonl"));
  ASSERT_EQ(mpirun(long_work), 0) << err_;
  EXPECT_NE(out_.find("done before"), std::string::npos) << out_;
  EXPECT_EQ(text("cut.jsonl"), anew);
  EXPECT_EQ(entries().size(), 1u) << "no parts";
}

#endif

}  // namespace test_rollout_mpi
