#pragma once

#include <limits>
#include <span>
#include <vector>

#include "mechanism/assembly.hpp"
#include "terms/contact_port.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/port_batch.hpp"
#include "stepper/interleaving.hpp"
#include "physics/trajectory.hpp"
#include "terms/pyramid_contacts.hpp"
#include "terms/pyramid_law.hpp"

namespace physics {

/// All contacts of equal scenes side by side (lanes), in three batches: four facets, any number of facets, no
/// friction. Decides before each step which of them can be reached, and turns the friction basis of `aligned` ones.
class Contacts {
 public:
  /// Numbers are given by set(), for each lane.
  Contacts(Bodies& bodies, const Interleaving& side_by_side, const Mechanism& mechanism, const Assembly& assembly);
  /// What the scene of a lane says of its contacts.
  void set(int lane, const Mechanism& mechanism, const Assembly& assembly);

  void register_with(graphsolve::Problem& problem);
  /// Contacts of bodies that are part of the world are left out altogether.
  [[nodiscard]] int size_of_lane() const { return per_lane_; }
  [[nodiscard]] int frictionless() const { return none_.size(); }
  /// Index in Mechanism::contacts of an instance of a batch, as the problem numbers them; -1: not one of this lane.
  [[nodiscard]] int source(int lane, int batch, int instance) const;

  struct Step {
    double dt = 0;
    Vec3 gravity = Vec3::Zero();
    double force_factor = 1;  ///< impulses of this step over those of the last, at equal forces
    bool cull = true;         ///< leave out what cannot be reached
  };
  struct Reach {
    int active = 0;
    double smallest_distance = std::numeric_limits<double>::infinity();  ///< [m]
  };
  /// Before a step, of all lanes: distances and velocities. velocity: the unknowns (v, w) of the last step.
  void look(std::span<const double> velocity) { four_.look(velocity); }
  /// After that: culling, tangents, force directions.
  Reach prepare(int lane, std::span<const double> velocity, const Step& step);
  /// After a solve: puts back culled contacts that the step broke through. Returns how many.
  int put_back(int lane);
  /// Tells the solver which contacts exist. After prepare and put_back.
  void activate(graphsolve::InteriorPoint& solver);

  /// At the solution x of a step: derivatives of the residual by what the step was given, after those of the bodies.
  /// basis_follows: friction bases that were kept count as turned; stiffness: bound on z/s over the island's mass.
  void differentiate(int lane, std::span<const double> x, bool basis_follows, double stiffness,
                     Sensitivity& out);

  [[nodiscard]] double smallest_distance(int lane) const;  ///< at `now`
  void write_record(int lane, std::span<ContactRecord> records, double impulse_time) const;
  /// After the state was set from outside, and before a failed step is tried again: no contact remembers a force.
  void clear(int lane);
  /// Keeps forces and friction bases of these lanes (the others' are lost), or goes back to those that were kept.
  void save(std::span<const int> lanes);
  void recall(int lane);
  /// Takes up forces and friction bases of a record; impulse_time: of the step that made them [s].
  void load_record(int lane, std::span<const ContactRecord> records, double impulse_time);

 private:
  enum class Batch { four, any, none };
  struct Entry {
    int source;  ///< in Mechanism::contacts
    Batch batch;
    int index;
    bool aligned;
    bool active = false;
    bool loaded = false;  ///< its law remembers forces of the step before
    bool turned = false;  ///< its basis turned to the slip before this step
    int saved = -1;  ///< place in saved_: tangent, impulses along the normal and the facets; four facets keep their own
    bool saved_active = false;
    /// Then, and before steps whose slip kept the basis: |u| and what friction stops in a step [m/s], as Contacts::align
    /// adds them. 0: the basis does not follow the slip.
    double slip_speed = 0;
    double turn_by_mass = 0;  ///< likewise: angle by which that of the body turns t1, against t2 [rad/kg]
  };
  template <class F>
  auto visit(const Entry& entry, F&& f);
  template <class F>
  auto visit(const Entry& entry, F&& f) const;
  template <class F>
  void each_entry(int lane, F&& f);
  template <class F>
  void each_entry(int lane, F&& f) const;
  void add(const Contact& contact, int source, int body);
  void sum_presses(int lane);
  template <class PortType, class Law>
  void prepare_entry(int lane, Entry& entry, PortType& port, Law& law, const Approach& approach, const Step& step);
  template <class PortType, class Law>
  void align(int lane, Entry& entry, PortType& port, Law& law, double u1, double u2);

  Bodies& bodies_;
  Interleaving side_by_side_;
  int per_lane_ = 0;
  PyramidContacts four_;
  graphsolve::PortLawBatch<ContactPort<3>, PyramidLaw<0>> any_;
  graphsolve::PortLawBatch<ContactPort<1>, graphsolve::Nonnegative> none_;
  std::vector<Entry> contacts_;
  std::vector<int> world_contacts_;     ///< sources of contacts of bodies that cannot move
  std::vector<double> world_distance_;  ///< of these, lane by lane
  std::vector<int> list_[3];
  int batch_number_[3] = {-1, -1, -1};
  std::vector<double> saved_;
  bool presses_summed_ = false;        ///< in this step
  std::vector<double> pressed_;           ///< by body: normal impulses of its contacts with friction in the last step [N s]
  std::vector<double> facet_impulses_;  ///< scratch of load_record
};

template <class F>
auto Contacts::visit(const Entry& entry, F&& f) {
  switch (entry.batch) {
    case Batch::four: return f(four_.port(entry.index), four_.law(entry.index));
    case Batch::any: return f(any_.port(entry.index), any_.law(entry.index));
    case Batch::none: break;
  }
  return f(none_.port(entry.index), none_.law(entry.index));
}

template <class F>
auto Contacts::visit(const Entry& entry, F&& f) const {
  return const_cast<Contacts*>(this)->visit(
      entry, [&](const auto& port, const auto& law) { return f(port, law); });
}

template <class F>
void Contacts::each_entry(int lane, F&& f) {
  for (int i = 0; i < per_lane_; ++i) f(contacts_[side_by_side_.index(lane, i)]);
}

template <class F>
void Contacts::each_entry(int lane, F&& f) const {
  for (int i = 0; i < per_lane_; ++i) f(contacts_[side_by_side_.index(lane, i)]);
}

}  // namespace physics
