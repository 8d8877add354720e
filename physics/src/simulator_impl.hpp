#pragma once

#include <memory>
#include <vector>

#include "assembly.hpp"
#include "bodies.hpp"
#include "contacts.hpp"
#include "graphsolve/interior_point.hpp"
#include "joints.hpp"
#include "physics/simulator.hpp"

namespace physics {

/// Configuration and velocity of all rigid bodies between two steps. The time step that made the velocity
/// belongs to it: it defines the momentum (algorithm.md 1).
struct State {
  std::vector<Vec3> x, v, w;
  std::vector<Quat> q;
  double time_step = 0;
  bool half_kick = false;  ///< v, w are the velocity at this pose, not that of a step
  double kinetic_energy = 0, previous_kinetic_energy = 0, potential_energy = 0;  ///< potential: at the previous pose
};

struct Simulator::Impl {
  Impl(Mechanism scene, const SimulatorSettings& options);

  struct Attempt {
    graphsolve::Status status = graphsolve::Status::solved;
    int iterations = 0, restarts = 0, culling_repeats = 0;
    double residual = 0;
  };

  void build();
  void set_state(std::span<const BodyRecord> records, bool half_kick);
  void check_start() const;
  Attempt advance(double dt, double end_time);
  Attempt substeps(int count);
  void load_state_into_terms(double dt);
  void apply_loads(double impulse_time);
  Attempt solve();
  void commit(double dt);
  void save();
  void restore();
  [[nodiscard]] double kinetic_energy() const;
  [[nodiscard]] double potential_energy() const;

  Mechanism mechanism;
  SimulatorSettings settings;
  Assembly assembly;
  double dt = 0;
  Bodies bodies;
  Joints joints{bodies};
  std::unique_ptr<Contacts> contacts;
  std::unique_ptr<graphsolve::Problem> problem;
  std::unique_ptr<graphsolve::InteriorPoint> solver;
  std::vector<int> island;            ///< of each rigid body
  std::vector<double> noise;          ///< by island
  std::vector<double> unknowns;       ///< velocities and joint impulses of the last step, start of the next
  State state, saved_state;
  std::vector<double> saved_unknowns;
  double impulse_time = 0;            ///< impulse over force in the last step; 0: none yet
  double end_time = 0;
  int step_index = 0;
  double time = 0;
  double start_correction = 0;
  StepResult last;
  graphsolve::ComponentReport failure;  ///< of the last component that failed
  PhaseTimes times;
  graphsolve::Profile profile;
  ProblemSize size;
};

}  // namespace physics
