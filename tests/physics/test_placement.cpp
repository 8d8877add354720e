// Items in octets: those whose blocks lie side by side in the matrix share lanes with them.

#include <gtest/gtest.h>

#include <vector>

#include "simd/octet.hpp"
#include "simd/placement.hpp"

namespace test_placement {

using namespace physics;

graphsolve::BlockHandle lane_of_pack(std::int64_t pack, int stride, int lane) { return {pack + lane, 6, 6, stride}; }

TEST(Placement, ItemsTakeTheLanesOfTheirBlocks) {
  std::vector<Placed> items;
  for (int l = 0; l < 4; ++l) items.push_back({0, lane_of_pack(512, 4, l)});
  for (int l = 7; l >= 0; --l) items.push_back({0, lane_of_pack(1024, 8, l)});
  for (int l = 0; l < 4; ++l) items.push_back({0, lane_of_pack(768, 4, l)});
  items.push_back({0, lane_of_pack(2048, 1, 0)});
  const std::vector<int> place = places_in_octets(items);
  for (int l = 0; l < 8; ++l) EXPECT_EQ(place[11 - l], l) << "eight lanes are an octet";
  for (int l = 0; l < 4; ++l) {
    EXPECT_EQ(place[l], 8 + l) << "two times four lanes are one too";
    EXPECT_EQ(place[12 + l], 12 + l);
  }
  EXPECT_EQ(octet_of(place[16]), 2);
}

TEST(Placement, ItemsOfOneBlockComeOneAfterTheOtherAndKindsDoNotMix) {
  std::vector<Placed> items;
  for (int round = 0; round < 3; ++round)
    for (int l = 0; l < 8; ++l) items.push_back({0, lane_of_pack(64, 8, l)});
  items.push_back({1, lane_of_pack(256, 1, 0)});
  const std::vector<int> place = places_in_octets(items);
  for (int round = 0; round < 3; ++round)
    for (int l = 0; l < 8; ++l) EXPECT_EQ(place[8 * round + l], 8 * round + l);
  EXPECT_EQ(lane_of(place[24]), 0);
  EXPECT_EQ(octet_of(place[24]), 3);
}

}  // namespace test_placement
