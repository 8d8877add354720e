#pragma once

#include <memory>
#include <optional>
#include <string>

#include "physics/simulator.hpp"

namespace physics {

/// Many copies of one scene, stepped together: the same bodies, joints and contacts with other numbers (states, masses,
/// inertias, geometry, friction, gravity, motors, loads). Each lane holds one copy.
///
/// k equal scenes are one graph of k components, so this is a Simulator on the union: equal operations of neighbouring
/// lanes are done by one vector. What happens in a lane depends on nothing in the others: it converges on its own, and
/// a step that fails is tried again alone, in shorter steps. A copy's motion is therefore the same in bits in any lane
/// and any company, and what a Simulator makes of that scene. Where its gravity is so small that it bounds the
/// tolerance (loosest_tolerance), or no longer does, it is stepped by itself to be so, without neighbours to share
/// vectors with.
///
/// One per thread. Building one allocates everything; `step` allocates nothing, `load` does. A lane that is not there
/// throws std::out_of_range. Units as in Simulator: m, rad, s, kg, J.
class BatchSimulator {
 public:
  /// lanes: how many copies there is room for, >= 1; multiples of 8 fill the vectors. Every lane starts as a copy of
  /// the scene. Throws DescriptionError when the scene is wrong, lanes < 1, or so many are certain not to fit into this
  /// machine's memory.
  BatchSimulator(const Mechanism& scene, int lanes, const SimulatorSettings& settings = {});
  ~BatchSimulator();
  BatchSimulator(BatchSimulator&&) noexcept;
  BatchSimulator& operator=(BatchSimulator&&) noexcept;

  [[nodiscard]] int lanes() const;

  /// Puts a copy into a lane, at its start and at step 0, whatever was there before. It has to have the structure of
  /// the scene: the same time step, joint types, motors present or not, bodies of joints and contacts, contacts with
  /// friction or without, facets. Throws DescriptionError when it is wrong or does not fit; the lane is then empty.
  void load(int lane, Mechanism copy);
  /// Empties a lane; steps leave it out.
  void unload(int lane);
  /// Does the next step move this lane? Not when it is empty, or when its last step failed.
  [[nodiscard]] bool running(int lane) const;

  /// Advances every running lane by one time step. A lane that fails keeps its state and no longer runs.
  void step();
  /// Of the lane's last step.
  [[nodiscard]] const StepResult& result(int lane) const;
  /// After a failed step: where the solver got stuck, "joint 'knee' (residual 0.02 m/s)".
  [[nodiscard]] std::string failure_place(int lane) const;

  void write_record(int lane, StepRecord& record) const;
  [[nodiscard]] const Mechanism& mechanism(int lane) const;
  [[nodiscard]] int step_index(int lane) const;
  [[nodiscard]] double time(int lane) const;

  // As in Simulator.
  [[nodiscard]] double smallest_distance(int lane) const;
  /// The same where the last step began, which that step has looked at anyway.
  [[nodiscard]] double smallest_distance_before(int lane) const;
  [[nodiscard]] double largest_joint_error(int lane) const;
  [[nodiscard]] std::optional<double> joint_coordinate(int lane, int joint) const;
  [[nodiscard]] std::optional<double> joint_rate(int lane, int joint) const;
  [[nodiscard]] double energy(int lane) const;
  [[nodiscard]] double start_correction(int lane) const;
  [[nodiscard]] Vec3 linear_momentum(int lane) const;
  [[nodiscard]] Vec3 angular_momentum(int lane) const;

  [[nodiscard]] const PhaseTimes& phase_times() const;    ///< of all lanes together
  [[nodiscard]] const ProblemSize& problem_size() const;  ///< of all lanes together

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics
