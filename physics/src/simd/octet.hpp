#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "graphsolve/simd/lanes.hpp"

namespace physics {

/// One number of each of eight bodies, joints or contacts, side by side in memory as registers take it up.
struct alignas(64) Octet {
  double lane[graphsolve::simd::lanes] = {};
  double& operator[](int i) { return lane[i]; }
  double operator[](int i) const { return lane[i]; }
};

/// Items lie at places: place p is lane p % 8 of octet p / 8.
constexpr int octet_of(int place) { return place / graphsolve::simd::lanes; }
constexpr int lane_of(int place) { return place % graphsolve::simd::lanes; }
constexpr int octets_for(int places) { return octet_of(places + graphsolve::simd::lanes - 1); }
/// As many as have these places; none where nothing has one.
inline int octets_with(std::span<const int> places) {
  return places.empty() ? 0 : octets_for(1 + *std::max_element(places.begin(), places.end()));
}

/// All numbers of one lane of a structure of octets.
template <class T>
void copy_lane(const T& from, int from_lane, T& to, int to_lane) {
  static_assert(sizeof(T) % sizeof(Octet) == 0 && std::is_trivially_copyable_v<T>);
  const auto* source = reinterpret_cast<const Octet*>(&from);
  auto* target = reinterpret_cast<Octet*>(&to);
  for (std::size_t i = 0; i < sizeof(T) / sizeof(Octet); ++i) target[i][to_lane] = source[i][from_lane];
}

/// Takes a list of items octet by octet.
class OctetGroups {
 public:
  void resize(int octets) {
    used_.assign(octets, 0);
    groups_.reserve(octets);
    version_ = 0;
  }
  /// f(octet, used) with a bit per lane, in ascending order whatever the order of the list, so that sums do not depend
  /// on it. place(item): where it lies. A list of the same version as the last (but 0) is not looked at again.
  template <class Place, class F>
  void each(std::span<const int> items, std::uint64_t version, Place&& place, F&& f) {
    (void)take(items, version, place);
    each_again(f);
  }
  /// Takes up a list. True when it may be another one than the last.
  template <class Place>
  bool take(std::span<const int> items, std::uint64_t version, Place&& place) {
    if (version != 0 && version == version_) return false;
    sort(items, place);
    version_ = version;
    return true;
  }
  /// Those of the last call.
  template <class F>
  void each_again(F&& f) const {
    for (const auto& [octet, used] : groups_) f(octet, used);
  }

 private:
  template <class Place>
  void sort(std::span<const int> items, Place&& place) {
    groups_.clear();
    for (const int i : items) {
      const int p = place(i);
      unsigned& used = used_[octet_of(p)];
      if (used == 0) groups_.push_back({octet_of(p), 0});
      used |= 1u << lane_of(p);
    }
    if (!std::ranges::is_sorted(groups_, {}, &Group::octet)) std::ranges::sort(groups_, {}, &Group::octet);
    for (auto& [octet, used] : groups_) used = std::exchange(used_[octet], 0u);
  }

  struct Group {
    int octet;
    unsigned used;
  };
  std::vector<unsigned> used_;
  std::vector<Group> groups_;
  std::uint64_t version_ = 0;
};

/// The octets of all items of some copies of a scene, where items are numbered as Interleaving does.
class OctetsOfCopies {
 public:
  explicit OctetsOfCopies(int copies) : takes_part_(copies, 0) { chosen_.reserve(copies); }
  /// item_at: by place, -1 where there is none.
  void wire(std::vector<int> item_at) {
    item_at_ = std::move(item_at);
    groups_.reserve(item_at_.size() / graphsolve::simd::lanes);
    groups_.clear();
    chosen_.clear();
  }
  /// f(octet, used), ascending. The same copies as the last time are not looked for again.
  template <class F>
  void each(std::span<const int> copies, F&& f) {
    if (!std::ranges::equal(copies, chosen_)) choose(copies);
    for (const auto& [octet, used] : groups_) f(octet, used);
  }

 private:
  void choose(std::span<const int> copies) {
    chosen_.assign(copies.begin(), copies.end());
    groups_.clear();
    std::ranges::fill(takes_part_, 0);
    for (const int copy : copies) takes_part_[copy] = 1;
    for (int place = 0; place < static_cast<int>(item_at_.size()); ++place) {
      const int item = item_at_[place];
      if (item < 0 || !takes_part_[item % takes_part_.size()]) continue;
      if (groups_.empty() || groups_.back().octet != octet_of(place)) groups_.push_back({octet_of(place), 0});
      groups_.back().used |= 1u << lane_of(place);
    }
  }

  struct Group {
    int octet;
    unsigned used;
  };
  std::vector<char> takes_part_;  ///< by copy
  std::vector<int> item_at_, chosen_;
  std::vector<Group> groups_;
};

/// f(lane, place) for all eight lanes; those that are not used stand in for the first that is.
template <class F>
void each_lane(int octet, unsigned used, F&& f) {
  const int first = std::countr_zero(used);
  for (int l = 0; l < graphsolve::simd::lanes; ++l)
    f(l, octet * graphsolve::simd::lanes + (used >> l & 1u ? l : first));
}

}  // namespace physics
