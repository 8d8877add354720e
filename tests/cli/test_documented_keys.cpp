#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "program.hpp"

namespace test_documented_keys {

// Every key of the JSON that commands write is in the documentation.

using nlohmann::json;

class DocumentedKeys : public Program {
 protected:
  [[nodiscard]] static std::string docs(const std::string& name) {
    std::ostringstream text;
    text << std::ifstream(GRAPHSOLVE_SOURCE_DIR "/docs/" + name).rdbuf();
    return text.str();
  }
  static void collect(const json& value, std::set<std::string>& keys) {
    for (const auto& [key, inner] : value.items()) {
      if (value.is_object()) keys.insert(key);
      if (inner.is_structured() && key != "statuses") collect(inner, keys);
    }
  }
  static void expect_all(const json& value, const std::string& text) {
    std::set<std::string> keys;
    collect(value, keys);
    ASSERT_GT(keys.size(), 5u);
    for (const std::string& key : keys) EXPECT_NE(text.find('`' + key + '`'), std::string::npos) << key;
  }
};

TEST_F(DocumentedKeys, OfTheSummaryOfARun) {
  write("spin.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"top\"\nmass = 1\n"
                     "inertia = [0.01, 0.01, 0.02]\n[[loads]]\nbody = \"top\"\nsteps = [5, 5]\ntorque = [0, 0, 1e9]\n");
  const std::string scene_files = docs("scene_files.md");
  const std::string section = scene_files.substr(scene_files.find("## The summary"));
  ASSERT_EQ(run("simulate spin.toml --summary failed.json").code, 1);
  expect_all(json::parse(text("failed.json")), section);
  ASSERT_EQ(run("simulate quadruped --steps 3 --summary solved.json").code, 0);
  expect_all(json::parse(text("solved.json")), section);
  EXPECT_NE(section.find("`stopped_by_signal`"), std::string::npos);
}

TEST_F(DocumentedKeys, OfARollout) {
  ASSERT_EQ(run("rollout disc:height=0 --copies 1 --steps 1 --vary start.position.z=-0.1:-0.1 --out a.jsonl").code, 0);
  std::istringstream lines(text("a.jsonl"));
  for (std::string line; std::getline(lines, line);) {
    json value = json::parse(line);
    if (value.contains("copy")) value.erase("vary");  // keys of the user's own
    expect_all(value, docs("rollouts.md"));
  }
}

}  // namespace test_documented_keys
