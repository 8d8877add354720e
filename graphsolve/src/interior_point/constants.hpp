#pragma once

namespace graphsolve {

/// A step shorter than this asks for centring, and ends the polishing of products.
inline constexpr double centre_below = 0.5;

}  // namespace graphsolve
