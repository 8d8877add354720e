#pragma once

#include <functional>
#include <string>
#include <vector>

#include "physics/batch_simulator.hpp"

/// Runs of many copies of a scene: through the lanes of batches, one batch per thread.
namespace physics {

/// What became of one copy.
struct CopyResult {
  long long copy = 0;
  StepResult last;        ///< of the last step tried
  int steps = 0;          ///< solved
  std::string place;      ///< where the solver got stuck, empty when all steps were solved
  long long iterations = 0;
  int most_iterations = 0;                       ///< in one step
  int substepped_steps = 0, restarted_steps = 0, turned_steps = 0;  ///< as in RunSummary
  double start_correction = 0;   ///< that made the start velocities agree with the joints [m/s]; 0 when they did
  int start_contact = -1;        ///< the one that starts deepest inside its plane; -1: none does by more than rounding
  double start_depth = 0;        ///< of that contact [m]
  double residual = 0;           ///< largest [m/s]
  double smallest_distance = 0;  ///< over all contacts and states, start included [m]; +inf without contacts
  double joint_error = 0;        ///< at the end [m, rad]
  double energy_start = 0, energy_end = 0;  ///< [J]
  std::vector<BodyRecord> bodies;           ///< at the end
  [[nodiscard]] bool ok() const { return last.ok(); }
};

struct BatchRun {
  long long first = 0, last = 0;  ///< copies first .. last - 1; none where last <= first
  int steps = 0;                  ///< of each copy
  int threads = 1;                ///< each has a batch of its own; less than 1 counts as 1
  int lanes = 16;                 ///< of each batch; less than 1 counts as 1
  SimulatorSettings settings;
  /// The copy of this number. Called by several threads at once. Required.
  std::function<Mechanism(long long copy)> make;
  /// Asked by every thread before every step; true ends the run. May be unset.
  std::function<bool()> stop;
  /// One at a time, in order of the copies, by whichever thread has finished one. False ends the run: no further copy
  /// is begun or handed out. Required.
  std::function<bool(CopyResult&&)> on_result;
};

/// A copy that is wrong or does not fit the scene: "copy 17: ...".
class CopyError : public DescriptionError {
 public:
  CopyError(long long copy, const DescriptionError& error);
  [[nodiscard]] long long copy() const { return copy_; }
  [[nodiscard]] const std::string& reason() const { return reason_; }  ///< without the number

 private:
  long long copy_;
  std::string reason_;
};

/// Makes every copy's steps until they are done or one fails; its lane then takes the next copy. A copy's result does
/// not depend on lanes or threads, to the bit. Throws std::invalid_argument when `make` or `on_result` is unset, CopyError
/// when a copy is wrong or does not fit the scene; results of copies before it may have been handed out.
void run_batch(const Mechanism& scene, const BatchRun& run);

}  // namespace physics
