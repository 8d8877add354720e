#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// The program as a shell sees it: exit codes, what it prints, what it leaves behind. Every test works in an empty
/// folder of its own.
class Program : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("graphsolve_") + test.test_suite_name() + "_" + test.name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::string text(const std::string& name) const {
    std::ostringstream out;
    out << std::ifstream(path(name), std::ios::binary).rdbuf();
    return out.str();
  }
  void write(const std::string& name, const std::string& content) const { std::ofstream(path(name)) << content; }
  [[nodiscard]] std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) names.push_back(entry.path().filename());
    return names;
  }

  /// `before` stands in front of the program: variables of its environment, mpirun.
  [[nodiscard]] Outcome run(const std::string& arguments, const std::string& before = "") const {
    const std::string command =
        "cd '" + folder_.string() + "' && " + before + " '" GRAPHSOLVE_CLI "' " + arguments + " >.out 2>.err";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, text(".out"), text(".err")};
    std::filesystem::remove(path(".out"));
    std::filesystem::remove(path(".err"));
    return outcome;
  }

  /// Wrong input: exit code 2, one line on stderr, nothing on stdout, nothing new in the folder.
  [[nodiscard]] std::string refused(const std::string& arguments) const {
    const auto before = entries();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(entries(), before) << arguments;
    return outcome.err;
  }

  /// Starts the program, sends the signal once `ready` (or after two minutes) and returns the status of `waitpid`.
  /// What it printed stays in .out and .err.
  [[nodiscard]] int signal_amid(const std::string& arguments, int signal, const std::function<bool()>& ready) const {
    const pid_t child = fork();
    if (child == 0) {
      ::signal(signal, SIG_DFL);  // nohup around the tests would have it ignored
      if (chdir(folder_.c_str()) != 0 || !freopen(".out", "w", stdout) || !freopen(".err", "w", stderr)) _exit(99);
      execl("/bin/sh", "sh", "-c", ("exec '" GRAPHSOLVE_CLI "' " + arguments).c_str(), nullptr);
      _exit(99);
    }
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (!ready() && std::chrono::steady_clock::now() < give_up)
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }

  std::filesystem::path folder_;
};
