#include "contacts.hpp"

#include <cmath>
#include <limits>

namespace physics {

namespace {

constexpr double slipping = 1e-4;       ///< [m/s] below this a contact counts as not sliding
constexpr double smallest_turn = 0.01;  ///< [rad] a smaller change of the slip direction keeps the basis
constexpr double reach_margin = 0.02;   ///< [m/s]
constexpr double broken_through = -1e-10;  ///< [m] a culled contact below this has to come back

}  // namespace

Contacts::Contacts(const Mechanism& mechanism, const Assembly& assembly, Bodies& bodies,
                   std::span<const double> island_mass, std::optional<FrictionModel> model)
    : bodies_(bodies) {
  for (int k = 0; k < static_cast<int>(mechanism.contacts.size()); ++k) {
    const Contact& c = mechanism.contacts[k];
    const Placement& place = assembly.placement[c.body.index];
    const Vec3 point = place.offset + place.rotation * c.point;
    const double offset = c.normal.dot(c.plane_point);
    if (place.body < 0) {
      world_contacts_.push_back(k);
      world_distance_.push_back(c.normal.dot(point) - offset - c.radius);
      continue;
    }
    const double island = island_mass[place.body];
    const RigidBody& body = assembly.bodies[place.body];
    const double stiffness = largest_stiffness(body.mass, body.smallest_inertia, point.norm());
    Entry entry{.source = k, .batch = Batch::none, .index = -1, .aligned = false};
    if (c.friction.value_or(0) > 0) {
      entry.aligned = model.value_or(c.friction_model) == FrictionModel::aligned;
      entry.batch = c.directions == 4 ? Batch::four : Batch::any;
      ContactPort<3> port(bodies, place.body, point, c.normal, offset, c.radius);
      port.set_tangent(c.tangent.value_or(c.normal.unitOrthogonal()));
      entry.index = entry.batch == Batch::four
                        ? four_.add(port, PyramidLaw<4>(*c.friction, island, stiffness, 4))
                        : any_.add(port, PyramidLaw<0>(*c.friction, island, stiffness, c.directions));
    } else {
      entry.index = none_.add(ContactPort<1>(bodies, place.body, point, c.normal, offset, c.radius),
                              graphsolve::Nonnegative(island, stiffness));
    }
    contacts_.push_back(entry);
  }
  list_[0].reserve(four_.size());
  list_[1].reserve(any_.size());
  list_[2].reserve(none_.size());
}

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

void Contacts::register_with(graphsolve::Problem& problem) {
  if (four_.size() > 0) batch_number_[0] = problem.add(four_);
  if (any_.size() > 0) batch_number_[1] = problem.add(any_);
  if (none_.size() > 0) batch_number_[2] = problem.add(none_);
}

void Contacts::prepare(std::span<const double> velocity, double dt, const Vec3& gravity, bool cull,
                       graphsolve::InteriorPoint& solver) {
  const double fall = 2 * gravity.norm() * dt;
  for (Entry& entry : contacts_) {
    entry.loaded = entry.active;
    visit(entry, [&](auto& port, auto& law) {
      const int body = port.body(), row = bodies_.row[body];
      const Pose& pose = bodies_.now[body];
      const Eigen::Map<const Vec3> v(velocity.data() + row), w(velocity.data() + row + 3);
      const Vec3 point = port.contact_point(pose);
      const double vn = port.normal().dot(v + pose.rotation * w.cross(point));
      // Cannot be reached: even after two steps of free fall and a quarter more speed there is a gap left.
      entry.active =
          !cull || !(port.distance(pose) / dt + vn - fall - 0.25 * std::abs(vn) > reach_margin);
      if (!entry.active) return;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        if (!entry.loaded) law.clear();
        if (entry.aligned) align(port, law, velocity, gravity, dt, entry.loaded);
      } else if (!entry.loaded) {
        law.set_force(0);
      }
      port.prepare();
    });
  }
  activate(solver);
}

/// Turns t1 against the slip, so that sliding friction lies along one facet.
template <class PortType, class Law>
void Contacts::align(PortType& port, Law& law, std::span<const double> velocity, const Vec3& gravity, double dt,
                     bool loaded) {
  const int row = bodies_.row[port.body()];
  const Pose& pose = bodies_.now[port.body()];
  const Eigen::Map<const Vec3> v(velocity.data() + row), w(velocity.data() + row + 3);
  // A contact without a history is expected to slip the way gravity pulls.
  const Vec3 u = v + pose.rotation * w.cross(port.contact_point(pose)) + (loaded ? Vec3::Zero() : Vec3(dt * gravity));
  const double u1 = port.tangent1().dot(u), u2 = port.tangent2().dot(u), speed = std::sqrt(u1 * u1 + u2 * u2);
  double f[2];
  law.friction_impulse(f);
  const double force = std::sqrt(f[0] * f[0] + f[1] * f[1]);
  double t[2];
  if (speed > slipping) {
    t[0] = -u1 / speed;
    t[1] = -u2 / speed;
  } else if (force > 0.5 * law.friction_bound() && force > 0) {
    t[0] = f[0] / force;  // stuck, and near enough to the bound for the corners of the pyramid to matter
    t[1] = f[1] / force;
  } else {
    return;
  }
  if (t[0] > std::cos(smallest_turn)) return;
  const Vec3 tangent = (t[0] * port.tangent1() + t[1] * port.tangent2()).normalized();
  const double rotated[2] = {t[0] * f[0] + t[1] * f[1], -t[1] * f[0] + t[0] * f[1]};
  port.set_tangent(tangent);
  law.split_friction(rotated);
}

void Contacts::activate(graphsolve::InteriorPoint& solver) {
  for (auto& list : list_) list.clear();
  active_count_ = 0;
  for (const Entry& entry : contacts_) {
    if (!entry.active) continue;
    list_[static_cast<int>(entry.batch)].push_back(entry.index);
    ++active_count_;
  }
  for (int b = 0; b < 3; ++b)
    if (batch_number_[b] >= 0) solver.activate(batch_number_[b], list_[b]);
}

int Contacts::put_back(graphsolve::InteriorPoint& solver) {
  int count = 0;
  for (Entry& entry : contacts_) {
    if (entry.active) continue;
    visit(entry, [&](auto& port, auto& law) {
      if (!(port.distance(bodies_.next[port.body()]) < broken_through)) return;
      entry.active = true;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) law.clear();
      else law.set_force(0);
      port.prepare();
      ++count;
    });
  }
  if (count > 0) activate(solver);
  return count;
}

int Contacts::source(int batch, int instance) const {
  for (const Entry& entry : contacts_)
    if (batch_number_[static_cast<int>(entry.batch)] == batch && entry.index == instance) return entry.source;
  return -1;
}

double Contacts::smallest_distance() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Entry& entry : contacts_)
    smallest = std::min(smallest, visit(entry, [&](const auto& port, const auto&) {
                          return port.distance(bodies_.now[port.body()]);
                        }));
  return smallest;
}

void Contacts::clear() {
  for (Entry& entry : contacts_) entry.active = entry.loaded = false;
}

void Contacts::load_record(std::span<const ContactRecord> records, double impulse_time) {
  for (Entry& entry : contacts_) {
    const ContactRecord& record = records[entry.source];
    visit(entry, [&](auto& port, auto& law) {
      entry.active = record.normal_force > 0;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        if (entry.aligned && record.tangent) port.set_tangent(*record.tangent);
        if (static_cast<int>(record.facet_forces.size()) != law.facets()) {
          entry.active = false;
          return;
        }
        facet_impulses_.assign(record.facet_forces.begin(), record.facet_forces.end());
        for (double& impulse : facet_impulses_) impulse *= impulse_time;
        law.set_impulses(record.normal_force * impulse_time, facet_impulses_);
      } else {
        law.set_force(record.normal_force * impulse_time);
      }
    });
  }
}

void Contacts::write_record(std::span<ContactRecord> records, double impulse_time) const {
  for (std::size_t k = 0; k < world_contacts_.size(); ++k) {
    records[world_contacts_[k]] = {};
    records[world_contacts_[k]].distance = world_distance_[k];
  }
  for (const Entry& entry : contacts_) {
    ContactRecord& record = records[entry.source];
    visit(entry, [&](const auto& port, const auto& law) {
      const bool pressed = entry.active && impulse_time > 0;
      record.distance = port.distance(bodies_.now[port.body()]);
      record.normal_force = 0;
      record.friction_force.setZero();
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        record.facet_forces.assign(law.facets(), 0.0);
        if (entry.aligned) record.tangent = port.tangent1();
        if (!pressed) return;
        record.normal_force = law.normal_impulse() / impulse_time;
        double t[2];
        law.friction_impulse(t);
        record.friction_force = (t[0] * port.tangent1() + t[1] * port.tangent2()) / impulse_time;
        for (int i = 0; i < law.facets(); ++i) record.facet_forces[i] = law.facet_impulse(i) / impulse_time;
      } else if (pressed) {
        record.normal_force = law.force() / impulse_time;
      }
    });
  }
}

}  // namespace physics
