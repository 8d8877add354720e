#pragma once

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "program.hpp"

/// `graphsolve rollout`, and the files that it writes.
class Rollout : public Program {
 protected:
  [[nodiscard]] std::vector<nlohmann::json> lines(const std::string& name) const {
    std::vector<nlohmann::json> result;
    std::istringstream in(text(name));
    for (std::string line; std::getline(in, line);) result.push_back(nlohmann::json::parse(line));
    return result;
  }
  /// Exit code; what it prints goes to out_ and err_.
  int run(const std::string& arguments, const std::string& before = "") {
    const Outcome outcome = Program::run("rollout " + arguments, before);
    out_ = outcome.out;
    err_ = outcome.err;
    return outcome.code;
  }

  [[nodiscard]] std::uintmax_t size(const std::string& name) const {
    std::error_code none;
    const auto bytes = std::filesystem::file_size(path(name), none);
    return none ? 0 : bytes;
  }
  /// Sends a signal when the file has some records, and waits for the end.
  [[nodiscard]] int signal_amid(const std::string& arguments, const std::string& file, int signal) const {
    return Program::signal_amid("rollout " + arguments, signal, [&] { return size(file) >= 30000; });
  }

  [[nodiscard]] int times_said(const std::string& words) const {
    int count = 0;
    for (auto at = err_.find(words); at != std::string::npos; at = err_.find(words, at + 1)) ++count;
    return count;
  }
  /// More angular momentum at step 5 than any turn of less than half a circle per step holds, for the lighter tops.
  void write_doomed_tops(const std::string& name) const {
    physics::Mechanism scene = physics::built_in_scene("free_top");
    scene.add(physics::Load{
        .body = {0}, .first_step = 5, .last_step = 5, .force = physics::Vec3::Zero(), .torque = {0, 1e8, 0}});
    physics::write_scene_json(scene, path(name));
  }

  std::string out_, err_;
};

inline const std::string work = "disc:c=4 --copies 23 --steps 30 --vary friction=0.1:0.9 --vary start.velocity.x=-1:1 --seed 7";
