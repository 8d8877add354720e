#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mechanism/assembly.hpp"
#include "terms/bodies.hpp"
#include "terms/contacts.hpp"
#include "graphsolve/interior_point.hpp"
#include "stepper/interleaving.hpp"
#include "terms/joints.hpp"
#include "physics/gradients.hpp"
#include "physics/simulator.hpp"

namespace physics {

/// What belongs to the state of one copy as a whole; the rest is in Bodies. The time step that made the velocity
/// defines the momentum.
struct LaneState {
  double time_step = 0;
  bool half_kick = false;   ///< v, w are the velocity at this pose, not that of a step
  double impulse_time = 0;  ///< impulse over force in the last step; 0: none yet
  bool solved_for = false;  ///< the unknowns hold the velocities
};

/// One copy of the scene: its own numbers on the common structure.
struct Lane {
  struct Attempt {
    graphsolve::Status status = graphsolve::Status::solved;
    int iterations = 0, restarts = 0, culling_repeats = 0;
    double residual = 0;
  };

  Mechanism mechanism;
  std::vector<Placement> placement;  ///< of the described bodies in the rigid ones; empty where each is one by itself
  std::vector<int> islands;  ///< components of the graph
  LaneState state, saved_state;
  int step_index = 0;
  int counted_from = 0;  ///< step that had time_there; times are told from it, not summed up, so that they do not drift
  double time_there = 0;  ///< [s]
  double start_correction = 0;
  double start_energy_loss = 0;
  double most_noise = 0;  ///< largest residual that rounding excuses: the loosest tolerance [m/s]
  double smallest_distance = 0;  ///< over all contacts, where the last step began
  Attempt attempt;
  StepResult last;
  StepResult before;  ///< of the last step that was solved
  int turned_in_a_row = 0;  ///< steps up to there that took the new force direction
  graphsolve::ComponentReport failure;  ///< of the last component that failed

  /// After so many more steps, or parts of one [s].
  [[nodiscard]] double time(double more = 0) const {
    return time_there + (step_index - counted_from + more) * mechanism.time_step;
  }
  /// A step that lies where it would had the run begun at 0 is told from there, as in the run that led to it.
  void set_time(int step, double there) {
    const bool from_start = there == step * mechanism.time_step;
    step_index = step;
    counted_from = from_start ? 0 : step;
    time_there = from_start ? 0 : there;
  }
  [[nodiscard]] Placement place(int body) const {
    return placement.empty() ? Placement{.body = body, .leads = true} : placement[body];
  }
};

/// What Simulator and BatchSimulator stand on: equal scenes with numbers of their own (lanes) side by side in one
/// graph. They step together, but nothing of one lane depends on another: components of the graph converge on their
/// own, and a lane that fails its step is tried again alone, in shorter steps.
struct Stepper {
  /// Every lane starts as a copy of the scene. same: one of as many lanes of a scene of the same structure, whose plan
  /// this one shares; may be null. Throws DescriptionError when the scene is wrong.
  Stepper(Mechanism scene, int lanes, const SimulatorSettings& options, const Stepper* same = nullptr);

  /// Puts another scene of the same structure into a lane, at its start. Throws DescriptionError when the scene is
  /// wrong or does not fit; the lane is then in no state to step.
  void load(int lane, Mechanism scene);
  /// One step of each of these lanes; outcomes in Lane::last. A lane that fails keeps its state.
  void step(std::span<const int> lanes);
  /// state: what is known of the step that led there.
  void set_state(int lane, std::span<const BodyRecord> records, const LaneState& state);
  /// Momenta of lanes at the start of a step of length h, and their velocities as its first unknowns.
  void begin(std::span<const int> begun, double h);

  /// Of a lane's scene, made anew: nothing keeps it.
  [[nodiscard]] Assembly assembly(int lane) const;
  [[nodiscard]] int body(int lane, int item) const { return side_by_side.index(lane, item); }
  [[nodiscard]] int joint(int lane, int item) const { return side_by_side.index(lane, item); }
  // Nodes and rows of a lane follow those of the lane before.
  [[nodiscard]] graphsolve::NodeId body_node(int lane, int item) const {
    return {lane * (bodies_per_lane + joints_per_lane) + item};
  }
  [[nodiscard]] graphsolve::NodeId joint_node(int lane, int item) const {
    return body_node(lane, bodies_per_lane + item);
  }
  [[nodiscard]] int rows_per_lane() const { return static_cast<int>(unknowns.size()) / count(); }
  [[nodiscard]] int count() const { return side_by_side.copies(); }
  /// Of a lane's joints, among the unknowns: they follow the velocities.
  [[nodiscard]] std::span<double> impulses(int lane) {
    const int rows = rows_per_lane(), velocities = 6 * bodies_per_lane;
    return std::span(unknowns).subspan(lane * rows + velocities, rows - velocities);
  }

  // Reports on one lane.
  [[nodiscard]] double energy(int lane) const;
  [[nodiscard]] double largest_joint_error(int lane) const;
  [[nodiscard]] std::optional<double> joint_coordinate(int lane, int described) const;
  [[nodiscard]] std::optional<double> joint_rate(int lane, int described) const;
  [[nodiscard]] Vec3 linear_momentum(int lane) const;
  [[nodiscard]] Vec3 angular_momentum(int lane) const;
  [[nodiscard]] std::string failure_place(int lane) const;
  [[nodiscard]] bool misses(int body) const;
  void write_bodies(int lane, std::span<BodyRecord> records) const;
  void write_joints(int lane, std::span<JointRecord> records) const;
  void write_record(int lane, StepRecord& record) const;

  /// How a step is tried: in how many parts, with force directions of which configuration.
  struct Rung {
    int parts;
    bool new_direction;
    bool more_starts;  ///< of every solve
  };

  SimulatorSettings settings;
  double dt = 0;
  Interleaving side_by_side;
  int bodies_per_lane = 0, joints_per_lane = 0;
  std::vector<Lane> lanes;
  Bodies bodies{side_by_side.copies()};
  Joints joints{bodies, side_by_side.copies()};
  std::unique_ptr<Contacts> contacts;
  std::unique_ptr<graphsolve::Problem> problem;
  std::shared_ptr<const graphsolve::Symbolic> plan;
  std::unique_ptr<graphsolve::InteriorPoint> solver;
  std::vector<int> island;      ///< of each rigid body
  std::vector<double> noise;    ///< by island
  std::vector<double> unknowns; ///< velocities and joint impulses of the last step, start of the next
  std::vector<double> saved_impulses;  ///< of joints, lane by lane; velocities are saved with the bodies
  PhaseTimes times;
  graphsolve::Profile profile;
  ProblemSize size;

 private:
  friend class StepGradient;
  [[nodiscard]] Assembly describe(int lane, Mechanism scene);
  void build(const Assembly& assembly);
  void make_solver(const Assembly& assembly, const Stepper* same);
  [[nodiscard]] std::shared_ptr<const graphsolve::Symbolic> make_plan(const Assembly& assembly) const;
  void weigh_islands(int lane, Assembly& assembly) const;
  void set_parameters(int lane, Assembly& assembly);
  void set_row_scales(int lane, const Assembly& assembly);
  void start(int lane, Assembly& assembly);
  void check_start(int lane) const;
  void agree_with_joints(int lane);
  [[nodiscard]] double opening(int lane, std::span<const double> x) const;
  void put_velocities(int lane, std::span<double> x) const;
  [[nodiscard]] bool led_by_a_step(int lane) const;
  [[nodiscard]] double slack_of_members(int lane) const;
  void join_members(int lane);
  [[nodiscard]] bool project(int lane, std::span<double> v);
  void check_structure(const Mechanism& scene, const Assembly& assembly) const;
  [[nodiscard]] std::optional<int> find_coordinate(int lane, int described) const;
  [[nodiscard]] double step_before(int lane) const;
  [[nodiscard]] JointGeometry on_lane(int lane, JointGeometry geometry) const;

  void attempt(std::span<const int> tried, const Rung& rung);
  template <class Again>
  void start_anywhere(int lane, Again&& again);
  void advance(std::span<const int> moved, int part, int parts);
  double prepare(int lane, double h, double end_time);
  void solve(std::span<const int> solved);
  void select(std::span<const int> selected);
  bool take_reports(Lane& lane);
  void begin_with_velocities(int lane);
  void note_distances(int lane);
  void apply_loads(int lane, double impulse_time);
  void commit(std::span<const int> moved, double h);
  void refuse_without_energy(int lane);
  void save(std::span<const int> saved);
  void restore(int lane);
  void recall(int lane);

  std::vector<int> going_, solving_, solved_, components_;  ///< scratch
};

/// [rad/s] at the start of a step of length h
inline double most_spin(double h) { return 0.95 * Bodies::largest_turn / h; }

/// The motor that drives a joint, null where there is none.
const Motor* motor_of(const Mechanism& mechanism, const JointGeometry& geometry);

struct Simulator::Impl : Stepper {
  Impl(Mechanism scene, const SimulatorSettings& options) : Stepper(std::move(scene), 1, options) {}
};

}  // namespace physics
