// Equal binary and equal input give equal bits.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_determinism {

using namespace physics;

/// FNV-1a over the bits of numbers.
class Hash {
 public:
  void add(std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte) value_ = (value_ ^ (bits >> (8 * byte) & 0xff)) * 1099511628211u;
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  void add(const Vec3& vector) {
    for (const double number : vector) add(number);
  }
  void add(const StepRecord& record) {
    for (const BodyRecord& body : record.bodies) {
      add(body.position);
      for (const double number : body.orientation.coeffs()) add(number);
      add(body.velocity);
      add(body.angular_velocity);
    }
    for (const ContactRecord& contact : record.contacts) {
      add(contact.distance);
      add(contact.normal_force);
      add(contact.friction_force);
      for (const double force : contact.facet_forces) add(force);
      if (contact.tangent) add(*contact.tangent);
    }
    for (const JointRecord& joint : record.joints) {
      add(joint.force);
      add(joint.torque);
      add(joint.error);
      if (joint.effort) add(*joint.effort);
    }
    if (record.solver) add(static_cast<std::uint64_t>(record.solver->iterations));
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037u;
};

/// A simulator and the hash of all records it has been through.
class HashedRun {
 public:
  explicit HashedRun(const std::string& spec) : simulator_(built_in_scene(spec)) { note(); }

  void step() {
    EXPECT_TRUE(simulator_.step().ok());
    note();
  }
  void steps(int count) {
    for (int k = 0; k < count; ++k) step();
  }
  [[nodiscard]] std::uint64_t hash() const { return hash_.value(); }
  [[nodiscard]] int index() const { return simulator_.step_index(); }

 private:
  void note() {
    simulator_.write_record(record_);
    hash_.add(record_);
  }

  Simulator simulator_;
  StepRecord record_;
  Hash hash_;
};

const std::vector<std::string>& specs() {
  static const std::vector<std::string> all{"tumbling_box",     "snake:n=20",     "loop",
                                            "four_bar",         "pads:ratio=100", "hopper",
                                            "disc:c=30,spin=6", "quadruped",      "pendulum:n=5,dt=0.002"};
  return all;
}
constexpr int length = 200;

std::uint64_t hash_of(const std::string& spec) {
  HashedRun run(spec);
  run.steps(length);
  return run.hash();
}

TEST(Determinism, TwoRunsOfASceneAgreeInEveryBit) {
  for (const std::string& spec : specs()) {
    const std::uint64_t first = hash_of(spec);
    EXPECT_EQ(hash_of(spec), first) << spec;
    std::printf("             %-24s %016llx\n", spec.c_str(), static_cast<unsigned long long>(first));
  }
}

TEST(Determinism, AnotherSpeedBySmallestAmountGivesAnotherHash) {
  EXPECT_NE(hash_of("sliding_box:speed=2"), hash_of("sliding_box:speed=2.0000000000000004"));
}

TEST(Determinism, SimulatorsThatLiveAndStepBesideItDoNotMatter) {
  std::vector<std::uint64_t> alone;
  for (const std::string& spec : specs()) alone.push_back(hash_of(spec));
  std::vector<HashedRun> runs;  // built in the opposite order, stepped in turn, moved as the list grows
  for (auto spec = specs().rbegin(); spec != specs().rend(); ++spec) runs.emplace_back(*spec);
  for (int k = 0; k < length; ++k)
    for (HashedRun& run : runs) run.step();
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(runs[runs.size() - 1 - i].hash(), alone[i]) << specs()[i];
}

TEST(Determinism, MovingASimulatorInTheMiddleOfARunDoesNotMatter) {
  HashedRun run("quadruped");
  run.steps(length / 2);
  HashedRun moved = std::move(run);
  moved.steps(length - length / 2);
  EXPECT_EQ(moved.hash(), hash_of("quadruped"));
}

/// What a simulator remembers of earlier solves may make it quicker, never different in what it was told to forget.
TEST(Determinism, TwoSimulatorsContinuedFromTheSameRecordAgreeInEveryBit) {
  Simulator source(built_in_scene("snake:n=20"));
  for (int k = 0; k < 30; ++k) ASSERT_TRUE(source.step().ok());
  StepRecord record, first, second;
  source.write_record(record);
  Simulator fresh(built_in_scene("snake:n=20")), used(built_in_scene("snake:n=20"));
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(used.step().ok());
  fresh.restart_from(record);
  used.restart_from(record);
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(fresh.step().ok());
    ASSERT_TRUE(used.step().ok());
    fresh.write_record(first);
    used.write_record(second);
    Hash a, b;
    a.add(first);
    b.add(second);
    ASSERT_EQ(a.value(), b.value()) << "step " << first.step;
  }
}

}  // namespace test_determinism
