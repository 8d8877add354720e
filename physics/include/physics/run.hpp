#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/simulator.hpp"

/// The loop around a Simulator, shared by the program, the tests and the study.
namespace physics {

struct RunOptions {
  /// Called after every solved step; returning false ends the run there.
  std::function<bool(const Simulator&, const StepResult&)> on_step;
  /// Called with the record the run starts from and with that of every solved step. Unset: nothing is recorded.
  std::function<void(const StepRecord&)> record;
};

/// A start that is further inside a plane did not get there by rounding [m].
inline constexpr double inside_a_plane = 1e-6;

/// A largest or smallest value and the step it was met in.
struct Extreme {
  double value = 0;
  int step = 0;
};

/// What a run was like.
struct RunSummary {
  int first_step = 0;                                        ///< state the run started from
  int steps = 0;                                             ///< solved
  std::vector<std::pair<graphsolve::Status, int>> statuses;  ///< how often each was met, no zeros

  long long iterations = 0;  ///< of all solved steps
  int most_iterations = 0;   ///< in one step
  int substepped_steps = 0;  ///< needed shorter steps
  int restarted_steps = 0;   ///< needed another start or a relaxation
  int turned_steps = 0;      ///< used the force direction at the new configuration
  int culling_repeats = 0;   ///< times a culled contact had to be put back

  Extreme residual;                         ///< largest [m/s]
  Extreme distance;                         ///< smallest, start included [m]; +inf without contacts
  Extreme joint_error;                      ///< largest, start included [m, rad]
  double energy_start = 0, energy_end = 0;  ///< [J]
  Vec3 momentum_start = Vec3::Zero(), momentum_end = Vec3::Zero();                  ///< [N s]
  Vec3 angular_momentum_start = Vec3::Zero(), angular_momentum_end = Vec3::Zero();  ///< about the origin [N m s]

  double simulated_time = 0;  ///< [s]
  double wall_time = 0;       ///< all of the loop, callbacks included [s]
  PhaseTimes phases;          ///< of this run [s]
  ProblemSize size;
  double start_correction = 0;            ///< [m/s], and
  double start_energy_loss = 0;           ///< [J]: see Simulator
  std::vector<std::string> redundancies;  ///< at the start
};

struct RunResult {
  StepResult last;       ///< of the last step tried
  std::optional<FailureRecord> failure;  ///< why the run ended, where that step failed
  bool stopped = false;  ///< by `on_step`
  RunSummary summary;
  [[nodiscard]] bool ok() const { return last.ok(); }
};

/// Makes up to this many steps; ends at the first that fails. The simulator keeps the last good state.
RunResult run(Simulator& simulator, int steps, const RunOptions& options = {});

}  // namespace physics
