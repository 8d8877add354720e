#pragma once

#include <span>
#include <vector>

#include "graphsolve/symbolic.hpp"

namespace physics {

/// An item that is to have a lane of an octet: only items of one kind share octets.
struct Placed {
  int kind;
  graphsolve::BlockHandle block;  ///< of the matrix, that the item writes
};

/// A place for each item, so that items whose blocks lie side by side in the matrix lie in the same lanes here: what
/// eight of them add is added at once. Several items of one block get one octet after the other, in their order.
std::vector<int> places_in_octets(std::span<const Placed> items);

}  // namespace physics
