#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_scene_files {

// Files appear complete or not at all.

using namespace physics;
namespace fs = std::filesystem;

class SceneFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("graphsolve_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
    return names;
  }
  std::string text(const std::string& name) const {
    std::ostringstream out;
    out << std::ifstream(path(name)).rdbuf();
    return out.str();
  }
  static std::string error(const std::function<void()>& action) {
    try {
      action();
    } catch (const DescriptionError& e) {
      return e.what();
    }
    return "";
  }

  fs::path folder_;
  const Mechanism scene_ = built_in_scene("free_box");
};

TEST_F(SceneFiles, AWriterLeavesNothingWithoutCommit) {
  {
    TrajectoryWriter writer(path("t.json"), scene_);
    EXPECT_FALSE(fs::exists(path("t.json")));
  }
  EXPECT_TRUE(entries().empty());
}

TEST_F(SceneFiles, AWriterThatIsGivenUpLeavesTheOldFile) {
  write_text_file("old", path("t.json"));
  { TrajectoryWriter writer(path("t.json"), scene_); }
  EXPECT_EQ(text("t.json"), "old");
  EXPECT_EQ(entries().size(), 1u);
}

TEST_F(SceneFiles, AWriterMakesTheFileThatWritingAtOnceMakes) {
  Trajectory trajectory{scene_, {}};
  for (int i = 0; i < 3; ++i) {
    StepRecord record;
    record.step = i;
    record.bodies.resize(1);
    trajectory.steps.push_back(record);
  }
  for (const char* name : {"t.json", "t.csv"}) {
    TrajectoryWriter writer(path(name), scene_);
    for (const StepRecord& record : trajectory.steps) writer.add(record);
    writer.commit();
  }
  write_trajectory_json(trajectory, path("other.json"));
  write_trajectory_csv(trajectory, path("other.csv"));
  EXPECT_EQ(text("t.json"), text("other.json"));
  EXPECT_EQ(text("t.csv"), text("other.csv"));
  EXPECT_EQ(read_scene(path("t.json")).steps.size(), 3u);
  EXPECT_EQ(entries().size(), 4u);
}

/// A file may grow to so many bytes, as on a disk that fills up.
class Limit {
 public:
  explicit Limit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit now = before_;
    now.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~Limit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = std::signal(SIGXFSZ, SIG_IGN);
};

TEST_F(SceneFiles, WhatFitsOnADiskThatFillsUpIsKept) {
  Simulator simulator(scene_);
  for (const char* name : {"t.json", "t.csv", "none.json"}) {
    const Limit limit(name == std::string("none.json") ? 100 : 20'000);
    TrajectoryWriter writer(path(name), scene_);
    StepRecord record;
    int given = 0;
    const std::string refused = error([&] {
      for (; given < 1000; ++given) {
        simulator.write_record(record);
        record.step = given;
        writer.add(record);
      }
      writer.commit();
    });
    EXPECT_EQ(refused, "cannot write '" + path(name) + "': File too large");
    const std::optional<int> last = writer.commit_what_is_there();
    if (name == std::string("none.json")) {
      EXPECT_FALSE(last);
      continue;
    }
    ASSERT_TRUE(last);
    EXPECT_GT(*last, given / 2) << "of what was written before the disk was full";
    EXPECT_LT(*last, given);
    const std::string written = text(name);
    EXPECT_GT(written.size(), 19'000u);
    if (name == std::string("t.json")) EXPECT_EQ(read_scene(path(name)).steps.back().step, *last);
    else EXPECT_EQ(std::ranges::count(written, '\n'), *last + 2) << "with the names of the columns";
  }
  EXPECT_EQ(entries().size(), 2u);
}

TEST_F(SceneFiles, ATrajectoryWithoutStepsIsValid) {
  TrajectoryWriter writer(path("t.json"), scene_);
  writer.commit();
  EXPECT_TRUE(read_scene(path("t.json")).steps.empty());
}

TEST_F(SceneFiles, CheckingLeavesNothingBehind) {
  check_writable(path("new.json"));
  EXPECT_TRUE(entries().empty());
  write_text_file("old", path("t.json"));
  check_writable(path("t.json"));
  EXPECT_EQ(text("t.json"), "old");
}

TEST_F(SceneFiles, PathsThatCannotBeWrittenAreNamed) {
  const auto check = [this](const std::string& name) { return error([&] { check_writable(path(name)); }); };
  EXPECT_EQ(check("no/t.json"), "cannot write '" + path("no/t.json") + "': No such directory");
  EXPECT_EQ(error([] { check_writable("no_such_folder/t.json"); }),
            "cannot write 'no_such_folder/t.json': No such directory");
  EXPECT_EQ(error([] { check_writable(""); }), "cannot write '': No file name");
  fs::create_directories(path("folder.json"));
  EXPECT_EQ(check("folder.json"), "cannot write '" + path("folder.json") + "': Is a directory");
  write_text_file("old", path("file"));
  EXPECT_EQ(check("file/t.json"), "cannot write '" + path("file/t.json") + "': No such directory");
  EXPECT_EQ(error([this] { TrajectoryWriter(path("t.txt"), scene_); }),
            "cannot write '" + path("t.txt") + "': a trajectory file ends in .json or .csv");
  EXPECT_EQ(entries().size(), 2u);
}

TEST_F(SceneFiles, AFullDiskIsAnErrorThatSaysSo) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  fs::create_symlink("/dev/full", path("t.json"));
  EXPECT_EQ(error([this] { write_scene_json(scene_, path("t.json")); }),
            "cannot write '" + path("t.json") + "': No space left on device");
}

TEST_F(SceneFiles, ALinkIsFollowedAndStaysALink) {
  write_text_file("old", path("target.json"));
  fs::create_symlink(path("target.json"), path("link.json"));
  write_text_file("new", path("link.json"));
  EXPECT_TRUE(fs::is_symlink(path("link.json")));
  EXPECT_EQ(text("target.json"), "new");
}

}  // namespace test_scene_files
