#include "simd/placement.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "graphsolve/simd/lanes.hpp"

namespace physics {

namespace {

struct Item {
  int kind, stride;
  std::int64_t pack;  ///< where the blocks of its lanes begin
  int ordinal;        ///< among the items of one block
  int lane, number;
  [[nodiscard]] auto key() const { return std::tuple(kind, -stride, pack, ordinal, lane, number); }
  [[nodiscard]] auto company() const { return std::tuple(kind, stride, pack, ordinal); }
};

}  // namespace

std::vector<int> places_in_octets(std::span<const Placed> items) {
  std::vector<Item> sorted;
  std::map<std::pair<int, std::int64_t>, int> seen;
  for (int i = 0; i < static_cast<int>(items.size()); ++i) {
    const auto& [kind, block] = items[i];
    const int lane = static_cast<int>(block.offset % block.stride);
    sorted.push_back({kind, block.stride, block.offset - lane, seen[{kind, block.offset}]++, lane, i});
  }
  std::sort(sorted.begin(), sorted.end(), [](const Item& a, const Item& b) { return a.key() < b.key(); });
  constexpr int lanes = graphsolve::simd::lanes;
  std::vector<int> place(items.size());
  int next = 0, begin = 0;  // the first place that is free, and where the company of an item begins
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    const Item& item = sorted[k];
    if (k == 0 || item.company() != sorted[k - 1].company()) {
      if (k > 0 && item.kind != sorted[k - 1].kind) next = (next + lanes - 1) / lanes * lanes;
      begin = next;  // strides fall: what is free in an octet is a multiple of them
      next += item.stride;
    }
    place[item.number] = begin + item.lane;
  }
  return place;
}

}  // namespace physics
