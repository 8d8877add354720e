#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/status.hpp"
#include "physics/mechanism.hpp"
#include "physics/trajectory.hpp"

namespace physics {

struct SimulatorSettings {
  /// Natural residual at which a step is accepted [m/s]. Where positions x of an island round to more, 8 eps |x| / dt,
  /// that is what its steps are accepted at; StepResult::residual tells. Under gravity neither is more than a hundredth
  /// of what that changes in a step (1e-4 m/s at 1 ms): else things would hover.
  double tolerance = 1e-8;
  std::optional<double> time_step = {};              ///< instead of the scene's [s]
  std::optional<FrictionModel> friction_model = {};   ///< instead of the contacts' own
  std::optional<Start> start = {};                   ///< instead of the scene's
  bool merge_fixed_joints = true;  ///< bodies held by a fixed joint become one (false: keep the joint force)
  bool cull_contacts = true;       ///< leave out contacts that cannot be reached in this step
  bool count_turns = false;        ///< of hinges without a motor too: see Simulator::joint_coordinate
  int max_substeps = 16;           ///< a step that fails is tried again in 2, 4, ... up to this many: 1 .. 2^20
  bool time_phases = false;        ///< fill PhaseTimes: a step of a few bodies takes 3 % longer with the clock read
};

/// The most that the tolerance of this scene's steps is [m/s], |g| dt / 100: what is above is taken as that. Infinite
/// without gravity.
double loosest_tolerance(const Mechanism& mechanism);

/// Time spent in the phases of all steps so far, by the steady clock (asking for CPU time costs as much as a small
/// step) [s]. Zero unless SimulatorSettings::time_phases.
struct PhaseTimes {
  double prepare = 0;     ///< loads, culling, friction basis, start values
  double evaluate = 0;    ///< residuals, Jacobians, condensation
  double factorize = 0;
  double solve = 0;
  double finish = 0;      ///< culling check, new state
  [[nodiscard]] double total() const { return prepare + evaluate + factorize + solve + finish; }
  PhaseTimes& operator+=(const PhaseTimes& other);
};

/// What exists for the solver, and what was left out because the scene does not need it.
struct ProblemSize {
  int body_nodes = 0, joint_nodes = 0, rows = 0;
  int islands = 0;
  int merged_bodies = 0;           ///< bodies that became part of another by a fixed joint
  int frictionless_contacts = 0;   ///< contacts without friction unknowns
  long long culled_contacts = 0;   ///< contact-steps left out as out of reach, summed over all steps
  long long contact_steps = 0;     ///< contact-steps in all
  long long newton_steps = 0;      ///< steps without any contact: no interior point
  long long operations = 0;        ///< multiplications and divisions of one factorization, predicted
  long long fill_blocks = 0;
  long long stored_scalars = 0;
  ProblemSize& operator+=(const ProblemSize& other);  ///< of problems side by side
};

/// What a status means for a step, with advice; empty when solved. Static storage.
std::string_view step_explanation(graphsolve::Status status);

/// Outcome of one step. On failure the state is the one before the step.
struct StepResult {
  graphsolve::Status status = graphsolve::Status::solved;
  std::string_view cause;  ///< step_explanation(status): static text that ends in a zero
  int iterations = 0;      ///< Newton iterations of all substeps
  double residual = 0;     ///< natural residual at the end [m/s]
  int substeps = 1;
  int restarts = 0;        ///< cold restarts and relaxations that were needed
  bool new_force_direction = false;
  int culling_repeats = 0;  ///< times a culled contact had to be put back
  [[nodiscard]] bool ok() const { return status == graphsolve::Status::solved; }
};

/// Rigid bodies in maximal coordinates, stepped by a variational integrator with exact contact (paper, eq. 24).
/// Building one allocates everything; `step` allocates nothing.
class Simulator {
 public:
  /// Throws DescriptionError when the scene or a setting is wrong.
  explicit Simulator(Mechanism mechanism, const SimulatorSettings& settings = {});
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// Advances by one time step, or reports why not and keeps the state.
  [[nodiscard]] StepResult step();

  /// After a failed step: where the solver got stuck, "joint 'knee' (residual 0.02 m/s)".
  [[nodiscard]] std::string failure_place() const;

  /// Continues from a record of this scene (as `standard`; from record 0 as the scene says). Throws DescriptionError when
  /// it is none, or none that a run has written (open or bent joints, a spin without momentum); nothing is changed then.
  /// How often a hinge has turned is told by its coordinate in the record; without one, of a motor by its effort: at its
  /// limit it is taken to lag by less than a turn.
  void restart_from(const StepRecord& record);

  /// Fills a record of the present state; for record 0 forces are zero.
  void write_record(StepRecord& record) const;

  [[nodiscard]] int step_index() const;
  [[nodiscard]] double time() const;
  [[nodiscard]] double time_step() const;
  [[nodiscard]] const Mechanism& mechanism() const;

  // Figures of the present state, without allocation.
  [[nodiscard]] double smallest_distance() const;     ///< over all contacts [m]; +inf without any
  [[nodiscard]] double largest_joint_error() const;   ///< [m, rad]
  /// Of a revolute [rad] or prismatic [m] joint, by its index in the Mechanism. Zero where the child has its
  /// orientation at rest, or the two points meet; grows as the child turns about the axis, or moves along it, from the
  /// parent's view: what motors and start.JOINT.angle count. A revolute joint with a motor, or any with
  /// SimulatorSettings::count_turns, counts full turns from the start, as long as no step turns it by half of one; else
  /// it is told from -pi to pi. Empty for other joints, and for one between bodies that fixed joints hold together.
  /// Throws std::out_of_range.
  [[nodiscard]] std::optional<double> joint_coordinate(int joint) const;
  /// Its change in the last step, or the last substep, over the length of that: what the damping of a motor answers to.
  /// At a half_kick start that of the velocities given.
  [[nodiscard]] std::optional<double> joint_rate(int joint) const;
  /// Energy in the middle of the last step (or substep), where the velocity is that of the step: kinetic and potential
  /// [J]. A free fall keeps it to rounding. At a half_kick start that of the pose. A record tells it as the run does.
  [[nodiscard]] double energy() const;
  [[nodiscard]] Vec3 linear_momentum() const;   ///< [N s]
  [[nodiscard]] Vec3 angular_momentum() const;  ///< about the world origin [N m s]
  /// Velocities of the description that joints forbid become the nearest that they allow, by kinetic energy: what an
  /// impulse of the joints does. The largest rate at which those given would have opened a joint [m/s]; 0 or rounding
  /// where they agree with the joints. After restart_from nothing is changed, and this is left for the next step to do.
  [[nodiscard]] double start_correction() const;
  /// Kinetic energy that this took [J].
  [[nodiscard]] double start_energy_loss() const;

  [[nodiscard]] const PhaseTimes& phase_times() const;
  [[nodiscard]] const ProblemSize& problem_size() const;
  /// Bodies and joints as the solver sees them; contacts are no nodes.
  [[nodiscard]] const graphsolve::BlockGraph& graph() const;
  /// Groups of joint rows that over-constrain the mechanism at the present pose:
  /// "joints 'a', 'b', 'c' over-constrain the mechanism by 3".
  [[nodiscard]] std::vector<std::string> redundancies() const;

 private:
  friend class StepGradient;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics
