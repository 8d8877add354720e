#pragma once

#include <string_view>

namespace graphsolve {

/// Outcome of a numerical solve. Anything but `solved` leaves the caller's data as it was.
enum class [[nodiscard]] Status : char {
  solved,             ///< the natural residual is below the tolerance
  max_iterations,     ///< still moving when the iterations ran out
  stalled,            ///< the step length went to zero: no progress possible from any of the starts tried; linear: too inaccurate
  singular,           ///< a pivot block is singular: an undetermined unknown, contradictions, or an order that errs
  not_finite,         ///< NaN or infinity in the data or on the way
  step_bound,         ///< the solution lies beyond the bound on the step
};

/// A short name, "solved".
std::string_view name(Status status);

/// One sentence: what happened, and what to try.
std::string_view explanation(Status status);

}  // namespace graphsolve
