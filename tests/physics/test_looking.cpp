// Whoever looks at a simulator changes nothing: neither what it tells of the last step nor the steps to come.

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "physics/run.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_looking {

using namespace physics;

/// Every number of a record but those that only the solver knows.
std::vector<std::uint64_t> bits(const StepRecord& record) {
  std::vector<std::uint64_t> all;
  const auto add = [&](double number) { all.push_back(std::bit_cast<std::uint64_t>(number)); };
  const auto add_all = [&](const auto& numbers) {
    for (Eigen::Index k = 0; k < numbers.size(); ++k) add(numbers[k]);
  };
  add(record.step), add(record.time);
  for (const BodyRecord& body : record.bodies) {
    add_all(body.position), add_all(body.orientation.coeffs());
    add_all(body.velocity), add_all(body.angular_velocity);
  }
  for (const ContactRecord& contact : record.contacts) {
    add(contact.distance), add(contact.normal_force), add_all(contact.friction_force);
    for (const double force : contact.facet_forces) add(force);
    if (contact.tangent) add_all(*contact.tangent);
  }
  for (const JointRecord& joint : record.joints) {
    add_all(joint.force), add_all(joint.torque), add(joint.error);
    for (const auto& number : {joint.effort, joint.coordinate, joint.rate}) add(number.value_or(0));
  }
  return all;
}

std::vector<std::uint64_t> bits(const Simulator& simulator) {
  StepRecord record;
  simulator.write_record(record);
  return bits(record);
}

class LookingAtScenes : public testing::TestWithParam<const char*> {};

TEST_P(LookingAtScenes, ForRedundanciesChangesNeitherRecordsNorSteps) {
  Mechanism scene = built_in_scene(GetParam());
  scene.bodies[0].angular_velocity += Vec3(0.3, 0.4, 0.5);
  Simulator looked_at(scene), left_alone(scene);
  bool turns = false;
  for (int k = 0; k < 60; ++k) {
    const auto before = bits(looked_at);
    const auto sentences = looked_at.redundancies();
    ASSERT_EQ(bits(looked_at), before) << "step " << k;
    ASSERT_EQ(looked_at.redundancies(), sentences) << "step " << k;
    const StepResult a = looked_at.step(), b = left_alone.step();
    ASSERT_TRUE(a.ok() && b.ok());
    ASSERT_EQ(a.iterations, b.iterations) << "step " << k;
    ASSERT_EQ(bits(looked_at), bits(left_alone)) << "step " << k;
    StepRecord record;
    looked_at.write_record(record);
    for (const BodyRecord& body : record.bodies) turns |= body.angular_velocity.norm() > 0.01;
  }
  EXPECT_TRUE(turns) << "the scene shows nothing";
}

std::string case_name(const testing::TestParamInfo<const char*>& info) {
  const std::string name = info.param;
  return name.substr(0, name.find(':'));
}
// Contacts, motors and merged bodies, a redundant loop, substeps and forces at the new configuration.
INSTANTIATE_TEST_SUITE_P(BuiltIn, LookingAtScenes,
                         testing::Values("snake:n=4", "quadruped", "hopper", "four_bar", "hanging_bob:n=4"), case_name);

TEST(Looking, ASecondRunBeginsWithTheLastRecordOfTheFirst) {
  for (const char* spec : {"snake:n=4", "quadruped", "four_bar"}) {
    Simulator simulator(built_in_scene(spec));
    std::vector<std::uint64_t> last;
    RunOptions options;
    options.record = [&](const StepRecord& record) { last = bits(record); };
    ASSERT_TRUE(run(simulator, 30, options).ok());
    const auto end_of_first = last;
    ASSERT_TRUE(run(simulator, 0, options).ok());
    EXPECT_EQ(last, end_of_first) << spec;
  }
}

}  // namespace test_looking
