#pragma once

#include <algorithm>
#include <bit>

#include "stepper/stepper.hpp"

namespace physics {

inline constexpr int more_when_turned = 16;  ///< the last resort may take this many times more substeps
inline constexpr int jammed = 3;             ///< so many steps in a row that only the last resort solved

/// The ways to try a step, in the usual order: as a whole, in 2, 4, ... parts, then all of these and more with the
/// force directions at the new configuration.
class Ladder {
 public:
  explicit Ladder(int max_substeps)
      : plain_(std::bit_width(static_cast<unsigned>(max_substeps))),
        rungs_(plain_ + static_cast<int>(std::bit_width(static_cast<unsigned>(max_substeps) * more_when_turned))) {}

  /// f(rung) for all but the first, until it returns true. What solved the step before mostly solves the next one too:
  /// half as many parts are tried first, what was passed over comes last.
  template <class F>
  void climb(const StepResult& before, int turned_in_a_row, F&& f) const {
    int first = 1;
    if (turned_in_a_row >= jammed) {
      if (plain_ > 1 && f(rung(plain_ - 1))) return;
      first = std::max(plain_, plain_ + rung_of(before) - 1);
    } else if (!before.new_force_direction) {
      first = std::max(1, rung_of(before) - 1);
    }
    for (int k = first; k < rungs_; ++k)
      if (f(rung(k))) return;
    for (int k = 1; k < first; ++k)
      if (f(rung(k))) return;
  }

 private:
  [[nodiscard]] Stepper::Rung rung(int k) const {
    return {.parts = 1 << (k < plain_ ? k : k - plain_), .new_direction = k >= plain_, .more_starts = false};
  }
  static int rung_of(const StepResult& result) { return std::bit_width(static_cast<unsigned>(result.substeps)) - 1; }

  int plain_, rungs_;
};

}  // namespace physics
