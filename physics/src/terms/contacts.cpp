#include "terms/contacts.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

namespace physics {

namespace {

constexpr double slipping = 1e-4;       ///< [m/s] below this a contact counts as not sliding
constexpr double smallest_turn = 0.01;  ///< [rad] a smaller one of the force that holds keeps the basis
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
  pressed_.resize(bodies_.size());
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
  if (entry.batch != Batch::four)
    saved_.resize(saved_.size() + (entry.batch == Batch::none ? 1 : 4 + contact.directions));
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
        port.set_slip(entry.aligned ? SlipMeasure::displacement : SlipMeasure::velocity);
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
  presses_summed_ = false;
  each_entry(lane, [&](Entry& entry) { entry.loaded = entry.active; });
  if (step.force_factor != 1) sum_presses(lane);  // before some of the impulses are another step's
  each_entry(lane, [&](Entry& entry) {
    entry.turned = false;
    entry.slip_speed = 0;
    visit(entry, [&](auto&& port, auto&& law) {
      Approach a;
      if constexpr (std::is_same_v<std::decay_t<decltype(port)>, PyramidPort>) a = port.approach();
      else a = port.approach(velocity);
      reach.smallest_distance = std::min(reach.smallest_distance, a.distance);
      // Cannot be reached: even after two steps of free fall and a quarter more speed there is a gap left.
      entry.active = !step.cull || !(a.distance / step.dt + a.speed - fall - 0.25 * std::abs(a.speed) > reach_margin);
      if (entry.active) prepare_entry(lane, entry, port, law, a, step);
    });
    if (entry.active) ++reach.active;
  });
  return reach;
}

/// Once per step, and only where something slips: at rest nobody asks.
void Contacts::sum_presses(int lane) {
  if (presses_summed_) return;
  presses_summed_ = true;
  each_entry(lane, [&](const Entry& entry) { visit(entry, [&](auto&& port, auto&&) { pressed_[port.body()] = 0; }); });
  each_entry(lane, [&](const Entry& entry) {
    if (!entry.loaded) return;
    visit(entry, [&](auto&& port, auto&& law) {
      if constexpr (std::decay_t<decltype(port)>::rows == 3) pressed_[port.body()] += law.normal_impulse();
    });
  });
}

template <class PortType, class Law>
void Contacts::prepare_entry(int lane, Entry& entry, PortType& port, Law& law, const Approach& a, const Step& step) {
  if constexpr (PortType::rows == 3) {
    if (!entry.loaded) law.clear();
    // A contact without a history is expected to slip the way gravity pulls.
    const auto slip = [&](double u, auto&& tangent) {
      return entry.loaded ? u : u + step.dt * tangent().dot(step.gravity);
    };
    if (entry.aligned)
      align(lane, entry, port, law, slip(a.slip[0], [&] { return port.tangent1(); }),
            slip(a.slip[1], [&] { return port.tangent2(); }));
    if (step.force_factor != 1) law.scale_impulses(step.force_factor);
  } else {
    law.set_force(entry.loaded ? law.force() * step.force_factor : 0);
  }
  if (entry.batch != Batch::four) port.prepare();  // those make their levers eight at a time
}

/// Turns t1 to where friction has to act, so that its whole bound is there on one facet: against the slip (u1, u2) while
/// that is fast, along the force that held while it is slow. In between lies what friction would have to do to stop the
/// slip in one step, f - m u. Against the slip alone, a body that is pushed at 0.9 of its friction creeps for ever: a facet
/// 22 degrees off the push gives way, to a slip 45 degrees from that facet, and so on.
template <class PortType, class Law>
void Contacts::align(int lane, Entry& entry, PortType& port, Law& law, double u1, double u2) {
  const double speed = std::sqrt(u1 * u1 + u2 * u2), bound = law.friction_bound();
  double f[2];
  law.friction_impulse(f);
  double t[2] = {f[0], f[1]}, least = 0.5 * bound;  // below it the corners of the pyramid do not matter
  double held = 1;
  if (speed > slipping) {
    // As slips: each contact carries the part of the body's mass that it has of all that presses it.
    sum_presses(lane);
    const double press = law.normal_impulse();
    held = press > 0 ? pressed_[port.body()] / (press * bodies_.mass(port.body())) : 0;
    t[0] = held * f[0] - u1;
    t[1] = held * f[1] - u2;
    least *= held;
  }
  const double length = std::sqrt(t[0] * t[0] + t[1] * t[1]);
  if (!(length > least)) return;
  t[0] /= length;
  t[1] /= length;
  const double rotated[2] = {t[0] * f[0] + t[1] * f[1], -t[1] * f[0] + t[0] * f[1]};
  if (speed > slipping) {
    entry.slip_speed = length;
    entry.turn_by_mass = held * rotated[1] / (length * bodies_.mass(port.body()));
  }
  if (!(speed > slipping) && t[0] > std::cos(smallest_turn)) return;
  port.set_tangent((t[0] * port.tangent1() + t[1] * port.tangent2()).normalized());
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
  int count = 0, body = -1;
  NextPose pose;  // of that body: its contacts mostly follow each other
  each_entry(lane, [&](Entry& entry) {
    if (entry.active) return;
    visit(entry, [&](auto&& port, auto&& law) {
      if (port.body() != body) pose = bodies_.pose_next(body = port.body());
      if (!(port.distance(pose) < broken_through)) return;
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
                          return port.distance(bodies_.pose_now(port.body()));
                        }));
  });
  return smallest;
}

}  // namespace physics
