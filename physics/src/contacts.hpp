#pragma once

#include <span>
#include <vector>

#include "assembly.hpp"
#include "contact_port.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/port_batch.hpp"
#include "physics/trajectory.hpp"
#include "pyramid_law.hpp"

namespace physics {

/// All contacts of a scene in three batches: four facets, any number of facets, no friction. Decides before
/// each step which of them can be reached, and turns the friction basis of `aligned` ones.
class Contacts {
 public:
  /// island_mass: largest mass of the island of each rigid body.
  Contacts(const Mechanism& mechanism, const Assembly& assembly, Bodies& bodies, std::span<const double> island_mass,
           std::optional<FrictionModel> model);

  void register_with(graphsolve::Problem& problem);
  /// Contacts of bodies that are part of the world are left out altogether.
  [[nodiscard]] int size() const { return static_cast<int>(contacts_.size()); }
  [[nodiscard]] int frictionless() const { return none_.size(); }
  /// Index in Mechanism::contacts of an instance of a batch, as the problem numbers them; -1: none.
  [[nodiscard]] int source(int batch, int instance) const;
  [[nodiscard]] int active() const { return active_count_; }

  /// Before a step: distances, culling, tangents, force directions, lists of the solver.
  /// velocity: the unknowns (v, w) of the last step. cull: leave out what cannot be reached.
  void prepare(std::span<const double> velocity, double dt, const Vec3& gravity, bool cull,
               graphsolve::InteriorPoint& solver);
  /// After a solve: puts back culled contacts that the step broke through. Returns how many.
  int put_back(graphsolve::InteriorPoint& solver);

  [[nodiscard]] double smallest_distance() const;  ///< at `now`
  void write_record(std::span<ContactRecord> records, double impulse_time) const;
  /// After the state was set from outside: no contact remembers a force.
  void clear();
  /// Takes up forces and friction bases of a record; impulse_time: of the step that made them [s].
  void load_record(std::span<const ContactRecord> records, double impulse_time);

 private:
  enum class Batch { four, any, none };
  struct Entry {
    int source;  ///< in Mechanism::contacts
    Batch batch;
    int index;
    bool aligned;
    bool active = false;
    bool loaded = false;  ///< its law remembers forces of the step before
  };
  template <class F>
  auto visit(const Entry& entry, F&& f);
  template <class F>
  auto visit(const Entry& entry, F&& f) const;
  void activate(graphsolve::InteriorPoint& solver);
  template <class PortType, class Law>
  void align(PortType& port, Law& law, std::span<const double> velocity, const Vec3& gravity, double dt, bool loaded);

  Bodies& bodies_;
  graphsolve::PortLawBatch<ContactPort<3>, PyramidLaw<4>> four_;
  graphsolve::PortLawBatch<ContactPort<3>, PyramidLaw<0>> any_;
  graphsolve::PortLawBatch<ContactPort<1>, graphsolve::Nonnegative> none_;
  std::vector<Entry> contacts_;
  std::vector<int> world_contacts_;  ///< sources of contacts of bodies that cannot move
  std::vector<double> world_distance_;
  std::vector<int> list_[3];
  int batch_number_[3] = {-1, -1, -1};
  std::vector<double> facet_impulses_;  ///< scratch of load_record
  int active_count_ = 0;
};

}  // namespace physics
