#include "contacts.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

namespace physics {

namespace {

constexpr double slipping = 1e-4;       ///< [m/s] below this a contact counts as not sliding
constexpr double smallest_turn = 0.01;  ///< [rad] a smaller change of the slip direction keeps the basis
constexpr double reach_margin = 0.02;   ///< [m/s]
constexpr double broken_through = -1e-10;  ///< [m] a culled contact below this has to come back

}  // namespace

Contacts::Contacts(Bodies& bodies, const Interleaving& side_by_side, const Mechanism& mechanism,
                   const Assembly& assembly)
    : bodies_(bodies), side_by_side_(side_by_side), four_(bodies) {
  std::vector<int> sources;
  const auto rigid = [&](int k) { return assembly.placement[mechanism.contacts[k].body.index].body; };
  for (int k = 0; k < static_cast<int>(mechanism.contacts.size()); ++k)
    (rigid(k) < 0 ? world_contacts_ : sources).push_back(k);
  per_lane_ = static_cast<int>(sources.size());
  world_distance_.resize(world_contacts_.size() * side_by_side_.copies());
  contacts_.reserve(sources.size() * side_by_side_.copies());
  side_by_side_.each(per_lane_, [&](int lane, int i) {
    const int k = sources[i];
    add(mechanism.contacts[k], k, side_by_side_.index(lane, rigid(k)));
  });
  list_[0].reserve(four_.size());
  list_[1].reserve(any_.size());
  list_[2].reserve(none_.size());
}

void Contacts::add(const Contact& contact, int source, int body) {
  const auto port = [&]<int Rows>(std::integral_constant<int, Rows>) {
    return ContactPort<Rows>(bodies_, body, contact.point, contact.normal, 0, 0);
  };
  Entry entry{.source = source, .batch = Batch::none, .index = -1, .aligned = false};
  if (!(contact.friction.value_or(0) > 0)) {
    entry.index = none_.add(port(std::integral_constant<int, 1>{}), graphsolve::Nonnegative());
  } else if (contact.directions == 4) {
    entry.batch = Batch::four;
    entry.index = four_.add(body);
  } else {
    entry.batch = Batch::any;
    entry.index = any_.add(port(std::integral_constant<int, 3>{}), PyramidLaw<0>(1, 1, 1, contact.directions));
  }
  entry.saved = static_cast<int>(saved_.size());
  saved_.resize(saved_.size() + (entry.batch == Batch::none ? 1 : 1 + contact.directions));
  contacts_.push_back(entry);
}

void Contacts::set(int lane, const Mechanism& mechanism, const Assembly& assembly) {
  const auto placed_point = [&](const Contact& c) {
    const Placement& place = assembly.placement[c.body.index];
    return Vec3(place.offset + place.rotation * c.point);
  };
  for (std::size_t i = 0; i < world_contacts_.size(); ++i) {
    const Contact& c = mechanism.contacts[world_contacts_[i]];
    world_distance_[lane * world_contacts_.size() + i] =
        c.normal.dot(placed_point(c)) - c.normal.dot(c.plane_point) - c.radius;
  }
  each_entry(lane, [&](Entry& entry) {
    const Contact& c = mechanism.contacts[entry.source];
    const RigidBody& body = assembly.bodies[assembly.placement[c.body.index].body];
    const Vec3 point = placed_point(c);
    const double stiffness = largest_stiffness(body.mass, body.smallest_inertia, point.norm());
    entry.aligned = entry.batch != Batch::none && c.friction_model == FrictionModel::aligned;
    visit(entry, [&](auto&& port, auto&& law) {
      port.place(point, c.normal, c.normal.dot(c.plane_point), c.radius);
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        port.set_tangent(c.tangent.value_or(c.normal.unitOrthogonal()));
        law.describe(*c.friction, body.island_mass, stiffness, c.directions);
      } else {
        law = graphsolve::Nonnegative(body.island_mass, stiffness);
      }
    });
  });
}

void Contacts::register_with(graphsolve::Problem& problem) {
  if (four_.size() > 0) batch_number_[0] = problem.add(four_);
  if (any_.size() > 0) batch_number_[1] = problem.add(any_);
  if (none_.size() > 0) batch_number_[2] = problem.add(none_);
}

Contacts::Reach Contacts::prepare(int lane, std::span<const double> velocity, const Step& step) {
  Reach reach;
  const double fall = 2 * step.gravity.norm() * step.dt;
  int body = -1;
  Vec3 v = Vec3::Zero(), w = Vec3::Zero();  // of the body, world
  each_entry(lane, [&](Entry& entry) {
    entry.loaded = entry.active;
    entry.turned = false;
    entry.slip_speed = 0;
    visit(entry, [&](auto&& port, auto&& law) {
      const Pose& pose = bodies_.now[port.body()];
      if (port.body() != body) {
        body = port.body();
        const double* x = velocity.data() + bodies_.row[body];
        v = Eigen::Map<const Vec3>(x);
        w = pose.rotation * Eigen::Map<const Vec3>(x + 3);
      }
      const Vec3 arm = port.world_arm(pose), u = v + w.cross(arm);  // of the material point
      const double vn = port.normal().dot(u);
      const double distance = port.normal().dot(pose.x + arm) - port.plane_offset();
      reach.smallest_distance = std::min(reach.smallest_distance, distance);
      // Cannot be reached: even after two steps of free fall and a quarter more speed there is a gap left.
      entry.active = !step.cull || !(distance / step.dt + vn - fall - 0.25 * std::abs(vn) > reach_margin);
      if (entry.active) prepare_entry(entry, port, law, u, step);
    });
    if (entry.active) ++reach.active;
  });
  return reach;
}

template <class PortType, class Law>
void Contacts::prepare_entry(Entry& entry, PortType& port, Law& law, const Vec3& u, const Step& step) {
  if constexpr (PortType::rows == 3) {
    if (!entry.loaded) law.clear();
    // A contact without a history is expected to slip the way gravity pulls.
    if (entry.aligned) align(entry, port, law, entry.loaded ? u : Vec3(u + step.dt * step.gravity));
    if (step.force_factor != 1) law.scale_impulses(step.force_factor);
  } else {
    law.set_force(entry.loaded ? law.force() * step.force_factor : 0);
  }
  if (entry.batch != Batch::four) port.prepare();  // those make their levers eight at a time
}

/// Turns t1 against the slip, so that sliding friction lies along one facet.
template <class PortType, class Law>
void Contacts::align(Entry& entry, PortType& port, Law& law, const Vec3& u) {
  const double u1 = port.tangent1().dot(u), u2 = port.tangent2().dot(u), speed = std::sqrt(u1 * u1 + u2 * u2);
  double f[2];
  law.friction_impulse(f);
  const double force = std::sqrt(f[0] * f[0] + f[1] * f[1]);
  double t[2];
  if (speed > slipping) {
    t[0] = -u1 / speed;
    t[1] = -u2 / speed;
    entry.slip_speed = speed;
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
  entry.turned = entry.slip_speed > 0;
  law.split_friction(rotated);
}

void Contacts::activate(graphsolve::InteriorPoint& solver) {
  for (auto& list : list_) list.clear();
  for (const Entry& entry : contacts_)
    if (entry.active) list_[static_cast<int>(entry.batch)].push_back(entry.index);
  for (int b = 0; b < 3; ++b)
    if (batch_number_[b] >= 0) solver.activate(batch_number_[b], list_[b]);
}

int Contacts::put_back(int lane) {
  int count = 0;
  each_entry(lane, [&](Entry& entry) {
    if (entry.active) return;
    visit(entry, [&](auto&& port, auto&& law) {
      if (!(port.distance(bodies_.next[port.body()]) < broken_through)) return;
      entry.active = true;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) law.clear();
      else law.set_force(0);
      port.prepare();
      ++count;
    });
  });
  return count;
}

int Contacts::source(int lane, int batch, int instance) const {
  int source = -1;
  each_entry(lane, [&](const Entry& entry) {
    if (batch_number_[static_cast<int>(entry.batch)] == batch && entry.index == instance) source = entry.source;
  });
  return source;
}

double Contacts::smallest_distance(int lane) const {
  double smallest = std::numeric_limits<double>::infinity();
  each_entry(lane, [&](const Entry& entry) {
    smallest = std::min(smallest, visit(entry, [&](const auto& port, const auto&) {
                          return port.distance(bodies_.now[port.body()]);
                        }));
  });
  return smallest;
}

void Contacts::clear(int lane) {
  each_entry(lane, [](Entry& entry) { entry.active = entry.loaded = false; });
}

void Contacts::save(int lane) {
  each_entry(lane, [&](Entry& entry) {
    entry.saved_active = entry.active;
    visit(entry, [&](const auto& port, const auto& law) {
      double* impulse = saved_.data() + entry.saved;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        entry.saved_tangent = port.tangent1();
        if (!entry.active) return;
        *impulse++ = law.normal_impulse();
        for (int i = 0; i < law.facets(); ++i) *impulse++ = law.facet_impulse(i);
      } else {
        *impulse = law.force();
      }
    });
  });
}

void Contacts::recall(int lane) {
  each_entry(lane, [&](Entry& entry) {
    entry.active = entry.saved_active;
    visit(entry, [&](auto&& port, auto&& law) {
      const double* impulse = saved_.data() + entry.saved;
      if constexpr (std::decay_t<decltype(port)>::rows == 3) {
        port.set_tangent(entry.saved_tangent);
        if (entry.active) law.set_impulses(impulse[0], {impulse + 1, static_cast<std::size_t>(law.facets())});
      } else {
        law.set_force(*impulse);
      }
    });
  });
}

void Contacts::load_record(int lane, std::span<const ContactRecord> records, double impulse_time) {
  each_entry(lane, [&](Entry& entry) {
    const ContactRecord& record = records[entry.source];
    visit(entry, [&](auto&& port, auto&& law) {
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
  });
}

void Contacts::write_record(int lane, std::span<ContactRecord> records, double impulse_time) const {
  for (std::size_t i = 0; i < world_contacts_.size(); ++i) {
    records[world_contacts_[i]] = {};
    records[world_contacts_[i]].distance = world_distance_[lane * world_contacts_.size() + i];
  }
  each_entry(lane, [&](const Entry& entry) {
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
  });
}

}  // namespace physics
