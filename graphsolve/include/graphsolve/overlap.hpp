#pragma once

// For graphsolve and physics themselves; outside the version promise (docs/architecture.md).

#include <functional>
#include <span>
#include <stdexcept>
#include <string>

namespace graphsolve {

/// Do two stretches of memory share a number?
inline bool overlap(std::span<const double> a, std::span<const double> b) {
  const std::less<const double*> before;  // also of pointers into different arrays
  return !a.empty() && !b.empty() && before(a.data(), b.data() + b.size()) && before(b.data(), a.data() + a.size());
}

/// For functions that write `out` before they have read all of `in`. Throws std::invalid_argument.
inline void check_apart(const char* function, std::span<const double> in, std::span<const double> out) {
  if (overlap(in, out)) throw std::invalid_argument(std::string(function) + ": what is read and what is written overlap");
}

}  // namespace graphsolve
