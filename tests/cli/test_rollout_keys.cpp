#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "physics/batch_variation.hpp"
#include "physics/scene_io.hpp"
#include "physics/simulator.hpp"
#include "rollout_program.hpp"

namespace test_rollout_keys {

// `graphsolve rollout --vary`: loads, motors, joints and orientations at the start.

namespace fs = std::filesystem;
using nlohmann::json;

const std::string trot =
    "quadruped --copies 19 --steps 12 --seed 4 --vary trunk.force.y@3-8=-60:60 --vary trunk.torque.x=-1:1 "
    "--vary 'front left hip joint.target=-0.2:0.2' --vary 'front left hip joint.limit=5:40' "
    "--vary 'rear left thigh joint.target.phase=-1:1' --vary start.trunk.rotation.z=-3:3 "
    "--vary 'start.rear left hip joint.angle=-0.3:0.3' --vary 'start.rear left calf joint.rate=-2:2' ";

TEST_F(Rollout, KeysOfLoadsMotorsAndJointsGiveTheSameBytesByAnyWay) {
  ASSERT_EQ(run(trot + "--out one.jsonl"), 0) << err_;
  const std::string expected = text("one.jsonl");
  ASSERT_EQ(run(trot + "--threads 3 --lanes 5 --out other.jsonl"), 0) << err_;
  EXPECT_EQ(text("other.jsonl"), expected);
  for (const char* shard : {"0", "1", "2"}) ASSERT_EQ(run(trot + "--out part" + shard + " --shard " + shard + "/3"), 0) << err_;
  ASSERT_EQ(run("--merge part2 part0 part1 --out merged"), 0) << err_;
  EXPECT_EQ(text("merged"), expected);
  fs::resize_file(path("other.jsonl"), expected.size() / 2);
  ASSERT_EQ(run(trot + "--threads 2 --out other.jsonl"), 0) << err_;
  EXPECT_EQ(text("other.jsonl"), expected) << "gone on with";
  EXPECT_NE(out_.find("done before"), std::string::npos) << out_;
}

TEST_F(Rollout, EachOfTheseKeysChangesTheMotion) {
  const auto bodies = [&](const std::string& keys) {
    fs::remove(path("a.jsonl"));
    EXPECT_EQ(run("quadruped --copies 1 --steps 4 --out a.jsonl " + keys), 0) << err_;
    return lines("a.jsonl")[1]["bodies"];
  };
  const json before = bodies("");
  for (const std::string key :
       {"trunk.force.y=5", "trunk.torque.z@2-2=5", "front left hip joint.target=0.1", "front left calf joint.limit=0.01",
        "front left thigh joint.target.offset=0.7", "start.trunk.rotation.y=0.05", "start.front left calf joint.angle=-1.7",
        "start.front left calf joint.rate=1"}) {
    const std::string value = key.substr(key.find('=') + 1);
    EXPECT_NE(bodies("--vary '" + key + ":" + value + "'"), before) << key;
  }
  EXPECT_EQ(bodies("--vary trunk.force.y@5-9=5:5"), before) << "a push after the last step";
}

TEST_F(Rollout, AStartThatItsAnglesLeaveClosedAndItsVelocitiesDoNotIsCorrectedAndRecorded) {
  const std::string turn = "start.joint 0.angle.y", speed = "start.link 1.velocity.x";
  const std::string command = "snake:n=3 --copies 3 --steps 2 --vary '" + turn + "=-0.5:0.5' --vary '" + speed + "=1:2' --out a.jsonl";
  ASSERT_EQ(run(command), 0) << err_;
  for (int copy = 0; copy < 3; ++copy) {
    const json record = lines("a.jsonl")[copy + 1];
    physics::Mechanism scene = physics::built_in_scene("snake:n=3");
    physics::set_value(scene, turn, record["vary"][turn]);
    EXPECT_LT(physics::Simulator(scene).start_correction(), 1e-12);
    physics::set_value(scene, speed, record["vary"][speed]);
    const double expected = physics::Simulator(scene).start_correction();  // what `simulate` says of this scene
    EXPECT_GT(expected, 0.1);
    EXPECT_EQ(record["start_correction_m_per_s"], expected);
    EXPECT_LT(record["joint_error"].get<double>(), 1e-8);
  }
  EXPECT_NE(out_.find("start correction"), std::string::npos) << out_;
}

TEST_F(Rollout, CorrectionsThatOnlyRoundingMakesAreNotNamed) {
  ASSERT_EQ(run("quadruped --copies 3 --steps 2 --vary 'start.rear left calf joint.rate=1:2' --out a.jsonl"), 0) << err_;
  double largest = 0;
  for (int copy = 1; copy <= 3; ++copy) largest = std::max<double>(largest, lines("a.jsonl")[copy]["start_correction_m_per_s"]);
  EXPECT_LT(largest, 1e-12);
  EXPECT_GT(largest, 0) << "the test shows nothing";
  EXPECT_EQ(out_.find("start correction"), std::string::npos) << out_;
  const Outcome outcome = Program::run("simulate four_bar --steps 1");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out.find("start correction"), std::string::npos) << outcome.out;
}

TEST_F(Rollout, KeysThatMakeNoSenseAreRefusedBeforeAnyCopy) {
  const auto refused = [&](const std::string& scene, const std::string& vary) {
    return Program::refused("rollout " + scene + " --copies 99 --steps 3 --out a.jsonl --vary '" + vary + "'");
  };
  EXPECT_EQ(refused("snake", "joint 0.target=0:1"), "graphsolve: vary 'joint 0.target': joint 'joint 0' has no motor\n");
  EXPECT_EQ(refused("disc", "wheel.force.x=0:1"), "graphsolve: vary 'wheel.force.x': the scene has no body 'wheel'\n");
  EXPECT_EQ(refused("disc", "disc.force.x@0-5=0:1"),
            "graphsolve: vary 'disc.force.x@0-5': '@0-5' is not @FIRST-LAST with steps 1 <= FIRST <= LAST\n");
  EXPECT_EQ(refused("quadruped", "front left hip joint.limit=0:1"),
            "graphsolve: vary 'front left hip joint.limit': the bound 0 will not do: revolute joint 'front left hip "
            "joint': motor limit 0 is not > 0\n");
  EXPECT_EQ(refused("quadruped", "start.front left hip joint.angle=0:4"),
            "graphsolve: vary 'start.front left hip joint.angle': the bound 4 will not do: joint 'front left hip joint': "
            "start angle 4 rad is not from -pi to pi\n");
  EXPECT_NE(refused("four_bar", "start.four_bar.angle=0:1").find("the scene has no joint 'four_bar'\n"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("a.jsonl")));
}

/// Each bound will do by itself, and copy 0 has no such spin: what is wrong comes up on the way.
TEST_F(Rollout, ACopyThatIsWrongIsNamedWithItsKeyAndValue) {
  const std::string x = "start.box.angular_velocity.x", y = "start.box.angular_velocity.y";
  const auto vary = [&] { return "free_box:dt=0.01 --copies 99 --steps 3 --vary " + x + "=0:180 --vary mass=1:2 --vary " + y + "=0:180"; };
  EXPECT_EQ(run(vary() + " --out a.jsonl"), 2);
  const auto number = [&](const char* before) { return std::stod(err_.substr(err_.find(before) + std::strlen(before))); };
  const auto copy = static_cast<long long>(number("copy "));
  const auto drawn = [&](const std::string& key, double high) { return high * physics::uniform(0, copy, key); };
  EXPECT_EQ(number("the value "), drawn(y, 180));
  EXPECT_EQ(number((x + " = ").c_str()), drawn(x, 180));
  EXPECT_TRUE(err_.starts_with("graphsolve: copy " + std::to_string(copy) + ": vary '" + y + "': the value ")) << err_;
  EXPECT_NE(err_.find(" will not do beside " + x + " = "), std::string::npos) << err_;
  EXPECT_NE(err_.find(": body 'box': spins at "), std::string::npos) << err_;
}

TEST_F(Rollout, StartPositionsThatOpenAJointAreRefusedBeforeAnyCopy) {
  const auto refused = [&](const std::string& arguments) {
    return Program::refused("rollout " + arguments + " --copies 99 --steps 3 --out a.jsonl");
  };
  EXPECT_EQ(refused("snake:n=3 --vary friction=0.1:0.2 --vary 'start.link 1.position.z=5:5'"),
            "graphsolve: vary 'start.link 1.position.z': joint 'joint 0' holds body 'link 1' at body 'link 0', and their points "
            "would start 4.94 m apart: vary start.joint 0.angle.x, .y or .z\n");
  EXPECT_EQ(refused("pendulum:n=2,joint=revolute --vary start.position.y=0.5:0.5"),
            "graphsolve: vary 'start.position.y': joint 'joint 0' holds body 'link 0' at the world, and their points would start "
            "0.5 m apart: vary start.joint 0.angle\n");
  physics::Mechanism open = physics::built_in_scene("pendulum:n=2");
  open.bodies[1].position.y() += 0.25;
  physics::write_scene_json(open, path("open.json"));
  // The line of the joint, as `simulate` names it.
  const std::string line = std::to_string(physics::line_in_scene(path("open.json"), "joints[1]"));
  EXPECT_EQ(refused("open.json"), "graphsolve: open.json:" + line + ": joint 'joint 1': its points start 0.25 m apart\n");
  EXPECT_EQ(Program::refused("simulate open.json"), refused("open.json"));
  // A body that a fixed joint holds goes where that says: its own position may be left out, and moving it is refused.
  write("bolted.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n"
                       "[[bodies]]\nname = \"box\"\nmass = 1\ninertia = [1, 1, 1]\n"
                       "[[bodies]]\nname = \"lid\"\nmass = 1\ninertia = [1, 1, 1]\n"
                       "[[joints]]\nname = \"bolt\"\ntype = \"fixed\"\nparent = \"box\"\nchild = \"lid\"\nparent_point = [0, 0, 1]\n");
  EXPECT_EQ(run("bolted.toml --copies 3 --steps 1 --vary start.position.x=0:1"), 0) << err_;
  EXPECT_EQ(refused("bolted.toml --vary start.lid.position.x=2:2"),
            "graphsolve: vary 'start.lid.position.x': joint 'bolt' holds body 'lid' at body 'box', and their points would "
            "start 2.24 m apart\n");
  // What stays together: all of it, or each by as much, in any order.
  EXPECT_EQ(run("snake:n=3 --copies 3 --steps 1 --vary start.position.z=1:2"), 0) << err_;
  physics::Mechanism snake = physics::built_in_scene("snake:n=2");
  std::string both;
  for (const physics::Body& link : snake.bodies) {
    const std::string y = std::to_string(link.position.y() + 1);
    both += " --vary 'start." + link.name + ".position.y=" + y + ":" + y + "'";
  }
  EXPECT_EQ(run("snake:n=2 --copies 3 --steps 1" + both), 0) << err_;
}

TEST_F(Rollout, CopiesThatStartInsideAPlaneAreCountedAndTheFirstIsNamed) {
  // A sphere of 0.1 m on its plane when z is 0.1.
  write("ball.toml", "format = \"graphsolve-scene\"\nversion = 1\ntime_step = 0.01\n[[bodies]]\nname = \"ball\"\nmass = 1\n"
                     "shape = {type = \"sphere\", radius = 0.1}\nposition = [0, 0, 0.1]\n"
                     "[[contacts]]\nname = \"skin\"\nbody = \"ball\"\nradius = 0.1\n"
                     "[[contacts]]\nname = \"roof\"\nbody = \"ball\"\nradius = 0.1\nnormal = [0, 0, -1]\n"
                     "plane_point = [0, 0, 9]\n");
  const std::string command = "ball.toml --copies 40 --steps 2 --seed 3 --vary start.ball.position.z=0.0:0.2 --out ";
  ASSERT_EQ(run(command + "a.jsonl"), 0) << err_;
  int inside = 0;
  std::string first;
  const auto records = lines("a.jsonl");
  for (std::size_t i = 1; i < records.size(); ++i) {
    const double depth = 0.1 - records[i]["vary"]["start.ball.position.z"].get<double>();
    ASSERT_EQ(records[i].contains("start_inside"), depth > 1e-6) << i;
    if (depth <= 1e-6) continue;
    EXPECT_EQ(records[i]["start_inside"]["body"], "ball");
    EXPECT_EQ(records[i]["start_inside"]["contact"], "skin");
    EXPECT_NEAR(records[i]["start_inside"]["depth_m"].get<double>(), depth, 1e-15);
    char text[100];
    std::snprintf(text, sizeof text, "copy %zu: body 'ball' by %.3g m at contact 'skin'\n", i - 1, depth);
    if (inside++ == 0) first = text;
  }
  ASSERT_GT(inside, 5);
  const std::string sentence = "starts inside          " + std::to_string(inside) +
                               " copies begin inside a plane, which the first step has to undo; the first is " + first;
  const auto said = [&] { return out_.find(sentence) != std::string::npos; };
  EXPECT_TRUE(said()) << out_;
  ASSERT_EQ(run(command + "a.jsonl"), 0) << "read from the file";
  EXPECT_TRUE(said()) << out_;
  for (const char* shard : {"0", "1"}) ASSERT_EQ(run(command + "part" + shard + " --shard " + shard + "/2"), 0) << err_;
  ASSERT_EQ(run("--merge part1 part0 --out merged"), 0) << err_;
  EXPECT_TRUE(said()) << out_;
  EXPECT_EQ(text("merged"), text("a.jsonl"));
  ASSERT_EQ(run("ball.toml --copies 3 --steps 2"), 0) << "it only touches";
  EXPECT_EQ(out_.find("starts inside"), std::string::npos) << out_;
}

}  // namespace test_rollout_keys
