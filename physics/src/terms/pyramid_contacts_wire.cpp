#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "terms/pyramid_contacts.hpp"
#include "simd/placement.hpp"

/// Where contacts and their numbers lie, and what they write to.
namespace physics {

void PyramidContacts::wire(const graphsolve::Wiring& wiring) {
  if (seats_.empty()) return;
  seats_.shrink_to_fit();
  std::vector<Placed> placed;
  for (const Seat& seat : seats_) placed.push_back({0, wiring.block(seat.node, seat.node)});
  place_ = places_in_octets(placed);
  const int octets = octets_with(place_);
  octets_.assign(octets, {});
  groups_.resize(octets);
  blocks_.assign(octets, {});
  one_body_.assign(octets, 1);
  displaced_.assign(octets, 0);
  contact_at_.assign(octets * graphsolve::simd::lanes, -1);
  product_.assign(seats_.size(), 0.0);
  kernels_ = contact_kernels();
  std::vector<int> body(octets, -1);
  for (int i = 0; i < size(); ++i) {
    const int octet = octet_of(place_[i]);
    contact_at_[place_[i]] = i;
    blocks_[octet].set(lane_of(place_[i]), placed[i].block);
    if (body[octet] >= 0 && body[octet] != seats_[i].body) one_body_[octet] = 0;
    body[octet] = seats_[i].body;
  }
  find_lane_places(wiring);
  for (auto& blocks : blocks_) blocks.finish();
  beside_.clear();
  for (int octet = 0; octet < octets; ++octet) {
    constexpr int lanes = graphsolve::simd::lanes;
    std::array<int, lanes> of_lane;
    for (int l = 0; l < lanes; ++l) {
      const int i = contact_at_[octet * lanes + l];
      of_lane[l] = i < 0 ? Bodies::nothing : seats_[i].body;
    }
    beside_.push_back(bodies_.octet_of_all(of_lane));
  }
}

/// Lanes without a contact stand in for one that has.
void PyramidContacts::find_lane_places(const graphsolve::Wiring& wiring) {
  lane_places_.assign(octets_.size(), {});
  std::map<int, int> last;  // contact, by component
  in_order_ = true;
  for (const int i : contact_at_)
    if (i >= 0 && std::exchange(last.try_emplace(wiring.component(seats_[i].node), -1).first->second, i) > i)
      in_order_ = false;
  for (int octet = 0; octet < static_cast<int>(octets_.size()); ++octet) {
    LanePlaces& places = lane_places_[octet];
    unsigned used = 0;
    for (int l = 0; l < graphsolve::simd::lanes; ++l)
      if (contact_at_[octet * graphsolve::simd::lanes + l] >= 0) used |= 1u << l;
    each_lane(octet, used, [&](int lane, int place) {
      const int i = contact_at_[place];
      places.row[lane] = wiring.row(seats_[i].node);
      places.body[lane] = bodies_.place_of(seats_[i].body);
      places.component[lane] = wiring.component(seats_[i].node);
    });
    places.used = used;
    places.side_by_side = used == 0xffu;
    for (int l = 1; l < graphsolve::simd::lanes; ++l)
      if (places.component[l] != places.component[0] + l) places.side_by_side = false;
  }
}

}  // namespace physics
