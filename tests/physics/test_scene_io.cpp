#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "everything_scene.hpp"
#include "physics/run.hpp"
#include "physics/scene_io.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"
#include "support/reference_files.hpp"

namespace test_scene_io {

// Reading and writing scenes and trajectories: nothing is lost or changed, in either spelling.

using namespace physics;
using nlohmann::json;

std::string reference_path(const std::string& name) {
  return std::string(GRAPHSOLVE_SOURCE_DIR) + "/tests/data/reference/" + name + ".json";
}

std::string written(const Trajectory& trajectory) {
  std::ostringstream out;
  write_trajectory_json(trajectory, out);
  return out.str();
}

std::string written(const Mechanism& mechanism) {
  std::ostringstream out;
  write_scene_json(mechanism, out);
  return out.str();
}

bool same_bits(const Vec3& a, const Vec3& b) { return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0; }
bool same_bits(const Quat& a, const Quat& b) {
  return std::memcmp(a.coeffs().data(), b.coeffs().data(), 4 * sizeof(double)) == 0;
}

TEST(SceneIo, EveryReferenceFileKeepsAllItSays) {
  for (const std::string& name : reference::names()) {
    std::ifstream file(reference_path(name));
    json expected = json::parse(file);
    json found = json::parse(written(read_scene(reference_path(name))));
    EXPECT_EQ(found, expected) << name;
  }
}

TEST(SceneIo, ReadsTheReferenceFilesAsTheTestsOwnReaderDoes) {
  for (const std::string& name : reference::names()) {
    const Trajectory ours = read_scene(reference_path(name)), other = reference::read(name);
    EXPECT_EQ(written(ours.mechanism).size(), written(read_scene(reference_path(name)).mechanism).size());
    ASSERT_EQ(ours.steps.size(), other.steps.size());
    for (std::size_t i = 0; i < ours.steps.size(); ++i) {
      EXPECT_EQ(ours.steps[i].step, other.steps[i].step);
      for (std::size_t b = 0; b < ours.steps[i].bodies.size(); ++b) {
        EXPECT_TRUE(same_bits(ours.steps[i].bodies[b].position, other.steps[i].bodies[b].position));
        EXPECT_TRUE(same_bits(ours.steps[i].bodies[b].orientation, other.steps[i].bodies[b].orientation));
      }
    }
    ASSERT_EQ(ours.mechanism.contacts.size(), other.mechanism.contacts.size());
    for (std::size_t c = 0; c < ours.mechanism.contacts.size(); ++c) {
      EXPECT_EQ(ours.mechanism.contacts[c].body, other.mechanism.contacts[c].body);
      EXPECT_EQ(ours.mechanism.contacts[c].friction, other.mechanism.contacts[c].friction);
    }
  }
}

TEST(SceneIo, EveryBuiltInSceneReadsBackAsItWasWritten) {
  for (const SceneInfo& info : built_in_scenes()) {
    const Mechanism scene = built_in_scene(info.name);
    const std::string text = written(scene);
    const Trajectory back = parse_scene_json(text);
    EXPECT_TRUE(back.steps.empty());
    EXPECT_EQ(written(back.mechanism), text) << info.name;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      EXPECT_TRUE(same_bits(back.mechanism.bodies[i].position, scene.bodies[i].position));
      EXPECT_TRUE(same_bits(back.mechanism.bodies[i].orientation, scene.bodies[i].orientation));
      EXPECT_EQ(back.mechanism.bodies[i].inertia, scene.bodies[i].inertia);
    }
  }
}

TEST(SceneIo, DoublesReadBackAsTheSameBits) {
  std::mt19937_64 random(7);
  Mechanism scene = built_in_scene("free_box");
  scene.bodies[0].position = Vec3(-0.0, 5e-324, 1.7976931348623157e308);
  scene.bodies[0].velocity = Vec3(1.0 / 3, 0.1 + 0.2, 9007199254740993.0);
  for (int i = 0; i < 2000; ++i) {
    const Mechanism back = parse_scene_json(written(scene)).mechanism;
    ASSERT_TRUE(same_bits(back.bodies[0].position, scene.bodies[0].position)) << scene.bodies[0].position;
    ASSERT_TRUE(same_bits(back.bodies[0].velocity, scene.bodies[0].velocity)) << scene.bodies[0].velocity;
    for (Vec3* v : {&scene.bodies[0].position, &scene.bodies[0].velocity}) {
      for (double& x : *v) {
        do x = std::bit_cast<double>(random());
        while (!std::isfinite(x));
      }
    }
  }
}

TEST(SceneIo, TomlAndJsonOfOneSceneReadAsTheSame) {
  Trajectory from_json = parse_scene_json(everything_json);
  from_json.mechanism.joints[3].extras.clear();  // TOML has no null
  EXPECT_EQ(written(parse_scene_toml(everything_toml)), written(from_json));
}

TEST(SceneIo, AllThatASceneCanSayReadsBack) {
  const Trajectory scene = parse_scene_json(everything_json);
  EXPECT_EQ(written(parse_scene_json(written(scene))), written(scene));
  const Mechanism& m = scene.mechanism;
  EXPECT_EQ(m.name, "all \"of it\" é");
  EXPECT_EQ(m.start, Start::standard);
  EXPECT_EQ(m.bodies[0].inertia, shape_inertia(m.bodies[0].shape, 2)) << "default inertia";
  EXPECT_EQ(m.bodies[1].inertia(1, 0), 0.1);
  EXPECT_EQ(m.bodies[4].shape.file, "cow.obj");
  EXPECT_TRUE(m.joints[0].parent.is_world());
  EXPECT_EQ(m.joints[1].motor->limit, 3);
  EXPECT_EQ(std::get<double>(m.joints[1].motor->target), 0.25);
  EXPECT_EQ(std::get<SineTarget>(m.joints[2].motor->target).phase, 4);
  EXPECT_EQ(std::get<TableTarget>(m.joints[4].motor->target)[1].second, 2);
  EXPECT_FALSE(m.contacts[0].friction.has_value());
  EXPECT_EQ(m.contacts[1].directions, 6);
  EXPECT_EQ(m.loads[0].last_step, 5);
}

TEST(SceneIo, WhatIsLeftOutHasTheDocumentedDefault) {
  const Mechanism m = parse_scene_json(R"({"format": "graphsolve-scene", "version": 1, "time_step": 0.01,
    "bodies": [{"name": "a", "mass": 1, "inertia": [1, 1, 1]}],
    "contacts": [{"name": "c", "body": "a", "friction": 1}]})")
                          .mechanism;
  EXPECT_EQ(m.start, Start::half_kick);
  EXPECT_EQ(m.gravity, Vec3(0, 0, -9.81));
  EXPECT_EQ(m.bodies[0].position, Vec3::Zero());
  EXPECT_EQ(m.bodies[0].orientation.w(), 1);
  EXPECT_EQ(m.contacts[0].friction_model, FrictionModel::aligned);
  EXPECT_EQ(m.contacts[0].normal, Vec3::UnitZ());
  EXPECT_EQ(m.contacts[0].directions, 4);
}

TEST(SceneIo, KeysThatStartWithXAreKept) {
  const Mechanism m = parse_scene_json(everything_json).mechanism;
  EXPECT_EQ(m.extras, (Extras{{"x_author", R"({"name":"me","year":2024})"}}));
  EXPECT_EQ(m.bodies[0].extras, (Extras{{"x_color", "\"red\""}}));
  EXPECT_EQ(m.joints[3].extras, (Extras{{"x_note", "null"}}));
  EXPECT_EQ(m.contacts[1].extras, (Extras{{"x_id", "17"}}));
  const Trajectory reference = read_scene(reference_path("box_4contacts"));
  EXPECT_EQ(reference.mechanism.extras, (Extras{{"x_first_nonunique", "31"}}));
  EXPECT_EQ(reference.steps[0].extras, (Extras{{"x_unique", "true"}}));
}

TEST(SceneIo, ATrajectoryOfASimulationReadsBackAndRunsAgainToTheSameBits) {
  const auto simulate = [](Mechanism scene, int steps) {
    Simulator simulator(std::move(scene));
    Trajectory trajectory{simulator.mechanism(), {}};
    simulator.write_record(trajectory.steps.emplace_back());
    for (int i = 0; i < steps; ++i) {
      EXPECT_TRUE(simulator.step().ok());
      simulator.write_record(trajectory.steps.emplace_back());
    }
    return written(trajectory);
  };
  for (const char* spec : {"snake:n=3", "disc:model=pyramid", "four_bar", "hopper"}) {
    const std::string first = simulate(built_in_scene(spec), 30);
    const Trajectory back = parse_scene_json(first);
    EXPECT_EQ(written(back), first) << spec;
    EXPECT_EQ(simulate(back.mechanism, 30), first) << spec;
  }
}

TEST(SceneIo, WhatJsonCannotSayIsRefusedBeforeAnythingIsWritten) {
  const Trajectory good{built_in_scene("pendulum:n=2"), {}};
  const auto message = [&](auto&& spoil) {
    Trajectory trajectory = good;
    trajectory.steps.resize(1);
    trajectory.steps[0].step = 4;
    trajectory.steps[0].bodies.resize(2);
    spoil(trajectory);
    std::ostringstream out;
    try {
      write_trajectory_json(trajectory, out);
    } catch (const DescriptionError& error) {
      EXPECT_EQ(out.str(), "");
      return std::string(error.what());
    }
    (void)parse_scene_json(out.str());
    return std::string();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message([&](Trajectory&) {}), "");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.bodies[1].mass = nan; }),
            "cannot write bodies[1].mass: nan is not finite");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.time_step = -INFINITY; }),
            "cannot write time_step: -inf is not finite");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.gravity.z() = nan; }),
            "cannot write gravity[2]: nan is not finite");
  EXPECT_EQ(message([&](Trajectory& t) { t.steps[0].bodies[1].velocity.x() = nan; }),
            "cannot write record 4.bodies[1].velocity[0]: nan is not finite");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.joints[0].name = "kn\xff"; }),
            "cannot write joints[0].name: \"kn\\ufffd\" is not UTF-8");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.name = "\xc3"; }), "cannot write name: \"\\ufffd\" is not UTF-8");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.bodies[0].extras = {{"x_\xff", "1"}}; }),
            "cannot write a key: \"x_\\ufffd\" is not UTF-8");
  EXPECT_EQ(message([&](Trajectory& t) { t.mechanism.joints[1].child = {7}; }),
            "cannot write body 7: the scene has 2, counted from 0");
}

TEST(SceneIo, ATrajectorySaysWhereAndWhyItsRunFailed) {
  Mechanism scene = built_in_scene("pendulum:n=2");
  scene.add(Load{.body = {0}, .first_step = 3, .last_step = 3, .torque = Vec3(0, 0, 1e9)});
  Trajectory trajectory{scene, {}};
  Simulator simulator(scene);
  trajectory.failure = run(simulator, 9, {.on_step = {}, .record = [&](const StepRecord& r) { trajectory.steps.push_back(r); }}).failure;
  ASSERT_TRUE(trajectory.failure);
  const std::string text = written(trajectory);
  const Trajectory read = parse_scene_json(text);
  ASSERT_TRUE(read.failure);
  EXPECT_EQ(read.failure->step, 3);
  EXPECT_EQ(read.failure->status, trajectory.failure->status);
  EXPECT_EQ(read.failure->place, trajectory.failure->place);
  EXPECT_EQ(read.failure->cause, trajectory.failure->cause);
  EXPECT_EQ(written(read), text);
  json other = json::parse(text);
  other["failure"]["step"] = 2;
  try {
    (void)parse_scene_json(other.dump(), "t.json");
    ADD_FAILURE();
  } catch (const DescriptionError& error) {
    EXPECT_STREQ(error.what(), "t.json:1: failure: step 2 is not after the last record, 2");
  }
  std::ostringstream csv;
  write_trajectory_csv(trajectory, csv);
  std::istringstream rows(csv.str());
  std::string header, row;
  std::getline(rows, header);
  for (std::string next; std::getline(rows, next);) row = next;
  EXPECT_TRUE(row.starts_with("3,,")) << row;
  EXPECT_TRUE(row.ends_with("," + read.failure->status + ",,,")) << row;
  EXPECT_EQ(std::count(row.begin(), row.end(), ','), std::count(header.begin(), header.end(), ','));
}

TEST(SceneIo, CsvHasOneRowPerRecordAndEqualNumbersOfCells) {
  Trajectory trajectory = read_scene(reference_path("chain_n2_c3"));
  trajectory.mechanism.bodies[0].name = "a, \"b\"";
  std::ostringstream out;
  write_trajectory_csv(trajectory, out);
  std::istringstream in(out.str());
  std::string header, row;
  std::getline(in, header);
  EXPECT_TRUE(header.starts_with(R"(step,time,"a, ""b"".x","a, ""b"".y")")) << header;
  const auto commas = [](const std::string& text) { return std::count(text.begin(), text.end(), ','); };
  const auto columns = commas(header) - 13;  // those inside the quotes
  std::size_t rows = 0;
  while (std::getline(in, row)) {
    EXPECT_EQ(commas(row), columns) << row;
    ++rows;
  }
  EXPECT_EQ(rows, trajectory.steps.size());
}

}  // namespace test_scene_io
