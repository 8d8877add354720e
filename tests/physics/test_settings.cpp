// Settings that mean nothing are refused in a sentence that names them, by a simulator and by a batch.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "physics/batch_simulator.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"

namespace test_settings {

using namespace physics;

std::string refusal(const std::function<void(SimulatorSettings&)>& change) {
  SimulatorSettings settings;
  change(settings);
  const auto said = [](auto&& make) {
    try {
      make();
    } catch (const DescriptionError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string by_one = said([&] { const Simulator simulator(built_in_scene("disc"), settings); });
  EXPECT_EQ(said([&] { const BatchSimulator batch(built_in_scene("disc"), 2, settings); }), by_one);
  return by_one;
}

TEST(Settings, AToleranceThatIsNoNumberAboveZeroIsRefused) {
  for (const auto& [value, text] : {std::pair(0.0, "0"), {-1e-8, "-1e-08"}, {NAN, "nan"}, {INFINITY, "inf"}})
    EXPECT_EQ(refusal([&](SimulatorSettings& s) { s.tolerance = value; }),
              "tolerance " + std::string(text) + " is not a number > 0");
}

TEST(Settings, ATimeStepThatIsNoNumberAboveZeroIsRefused) {
  EXPECT_EQ(refusal([](SimulatorSettings& s) { s.time_step = 0; }), "scene: time step 0 s is not > 0");
  EXPECT_EQ(refusal([](SimulatorSettings& s) { s.time_step = -1; }), "scene: time step -1 s is not > 0");
  EXPECT_EQ(refusal([](SimulatorSettings& s) { s.time_step = NAN; }), "scene: time step nan s is not > 0");
  EXPECT_EQ(refusal([](SimulatorSettings& s) { s.time_step = INFINITY; }), "scene: time step inf s is not finite");
}

TEST(Settings, NumbersOfSubstepsThatNoLadderReachesAreRefused) {
  for (const int number : {0, -1, std::numeric_limits<int>::min(), (1 << 20) + 1, std::numeric_limits<int>::max()})
    EXPECT_EQ(refusal([&](SimulatorSettings& s) { s.max_substeps = number; }),
              "max_substeps " + std::to_string(number) + " is not a number from 1 to 1048576");
  EXPECT_EQ(refusal([](SimulatorSettings& s) { s.max_substeps = 1; }), "");
  EXPECT_EQ(refusal([](SimulatorSettings& s) { s.max_substeps = 1 << 20; }), "");
}

}  // namespace test_settings
