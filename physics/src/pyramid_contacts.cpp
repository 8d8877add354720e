#include "pyramid_contacts.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "simd/placement.hpp"

namespace physics {

using graphsolve::Instances;

void PyramidLane::describe(double friction, double island_mass, double stiffness, int) {
  for (int k = 0; k < ContactOctet::pairs; ++k)
    for (Octet* number : {&octet_->s[k], &octet_->z[k], &octet_->ds[k], &octet_->dz[k]}) (*number)[lane_] = 0;
  octet_->friction[lane_] = friction;
  octet_->scale[lane_] = island_mass;
  octet_->largest_ratio[lane_] = stiffness;
  octet_->frozen[lane_] = 0;
}

PyramidLaw<4> PyramidLane::copy() const {
  PyramidLaw<4> law(friction(), scale(), octet_->largest_ratio[lane_], facets());
  for (int k = 0; k < ContactOctet::pairs; ++k) law.set_pair(k, octet_->s[k][lane_], octet_->z[k][lane_]);
  return law;
}

void PyramidPort::place(const Vec3& point, const Vec3& normal, double offset, double radius) {
  set(octet_->point, point);
  set(octet_->normal, normal);
  octet_->offset[lane_] = offset;
  octet_->radius[lane_] = radius;
}

void PyramidPort::set_tangent(const Vec3& t1) {
  set(octet_->tangent[0], t1);
  set(octet_->tangent[1], normal().cross(t1));
}

void PyramidPort::prepare(const Pose& pose) {
  ContactPort<3> port = copy();
  port.prepare(pose);
  for (int r = 0; r < rows; ++r) set(octet_->lever[r], port.lever(r));
}

ContactPort<3> PyramidPort::copy() const {
  ContactPort<3> port(*bodies_, body_, point(), normal(), plane_offset(), radius());
  port.set_tangent(tangent1());
  return port;
}

int PyramidContacts::add(int body) {
  seats_.push_back({bodies_.node(body), body});
  return size() - 1;
}

void PyramidContacts::wire(const graphsolve::Wiring& wiring) {
  if (seats_.empty()) return;
  std::vector<Placed> placed;
  for (const Seat& seat : seats_) placed.push_back({0, wiring.block(seat.node, seat.node)});
  place_ = places_in_octets(placed);
  const int octets = octets_for(1 + *std::max_element(place_.begin(), place_.end()));
  octets_.assign(octets, {});
  groups_.resize(octets);
  blocks_.assign(octets, {});
  one_body_.assign(octets, 1);
  contact_at_.assign(octets * graphsolve::simd::lanes, -1);
  product_.assign(seats_.size(), 0.0);
  kernels_ = contact_kernels();
  std::vector<int> body(octets, -1);
  for (int i = 0; i < size(); ++i) {
    const int octet = octet_of(place_[i]);
    contact_at_[place_[i]] = i;
    blocks_[octet].set(lane_of(place_[i]), placed[i].block);
    if (body[octet] >= 0 && body[octet] != seats_[i].body) one_body_[octet] = 0;
    body[octet] = seats_[i].body;
  }
  find_lane_places(wiring);
  for (auto& blocks : blocks_) blocks.finish();
  beside_.clear();
  for (int octet = 0; octet < octets; ++octet) {
    constexpr int lanes = graphsolve::simd::lanes;
    std::array<int, lanes> of_lane;
    for (int l = 0; l < lanes; ++l) {
      const int i = contact_at_[octet * lanes + l];
      of_lane[l] = i < 0 ? Bodies::nothing : seats_[i].body;
    }
    beside_.push_back(bodies_.octet_of_all(of_lane));
  }
}

/// Lanes without a contact stand in for one that has.
void PyramidContacts::find_lane_places(const graphsolve::Wiring& wiring) {
  lane_places_.assign(octets_.size(), {});
  for (int octet = 0; octet < static_cast<int>(octets_.size()); ++octet) {
    LanePlaces& places = lane_places_[octet];
    unsigned used = 0;
    for (int l = 0; l < graphsolve::simd::lanes; ++l)
      if (contact_at_[octet * graphsolve::simd::lanes + l] >= 0) used |= 1u << l;
    each_contact(octet, used, [&](int lane, int i) {
      places.row[lane] = wiring.row(seats_[i].node);
      places.body[lane] = bodies_.place_of(seats_[i].body);
      places.component[lane] = wiring.component(seats_[i].node);
    });
    places.used = used;
    places.side_by_side = used == 0xffu;
    for (int l = 1; l < graphsolve::simd::lanes; ++l)
      if (places.component[l] != places.component[0] + l) places.side_by_side = false;
  }
}

/// f(task, octet) with what every operation needs.
template <class F>
void PyramidContacts::each_octet(const Instances& instances, F&& f) const {
  groups_.each(instances.index, instances.version, [&](int i) { return place_[i]; }, [&](int octet, unsigned used) {
    ContactTask task;
    task.octet = &octets_[octet];
    task.used = used;
    task.one_body = one_body_[octet] != 0;
    task.dt = bodies_.dt;
    f(task, octet);
  });
}

/// f(lane, contact) for all eight lanes; those that are not used stand in for one that is.
template <class F>
void PyramidContacts::each_contact(int octet, unsigned used, F&& f) const {
  each_lane(octet, used, [&](int lane, int place) { f(lane, contact_at_[place]); });
}

/// What belongs to the component of each lane. Lanes mostly are those of eight components in a row, or of a single one.
void PyramidContacts::take(Octet& to, const ContactTask& task, int octet, std::span<const double> from) const {
  const LanePlaces& places = lane_places_[octet];
  const int first = places.component[0];
  if (places.side_by_side) {
    std::copy_n(from.data() + first, graphsolve::simd::lanes, to.lane);
    return;
  }
  each_lane(0, task.used, [&](int lane, int place) { to[lane] = from[places.component[place]]; });
}

/// Results of the used lanes: f(contact, lane).
template <class F>
void PyramidContacts::give(const ContactTask& task, int octet, F&& f) const {
  for (unsigned rest = task.used; rest != 0; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    f(contact_at_[octet * graphsolve::simd::lanes + lane], lane);
  }
}

/// The largest of each component, of results of the used lanes. A NaN stays, as in graphsolve::keep_largest.
void PyramidContacts::give_largest(const ContactTask& task, int octet, const Octet& out, std::span<double> by_component) const {
  const LanePlaces& places = lane_places_[octet];
  if (places.side_by_side && task.used == 0xffu) {
    double* to = by_component.data() + places.component[0];
    for (int l = 0; l < graphsolve::simd::lanes; ++l) to[l] = out.lane[l] > to[l] || out.lane[l] != out.lane[l] ? out.lane[l] : to[l];
    return;
  }
  for (unsigned rest = task.used; rest != 0; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    graphsolve::keep_largest(by_component[places.component[lane]], out[lane]);
  }
}

/// Whole octets, or lane by lane.
void PyramidContacts::point_at_poses(ContactTask& task, int octet, When when) const {
  const auto poses = [&](int bodies) { return when == When::now ? bodies_.poses_now(bodies) : bodies_.poses_next(bodies); };
  if (beside_[octet] >= 0) {
    task.poses = poses(beside_[octet]);
    if (when == When::next) task.velocities = bodies_.velocities_next(beside_[octet]);
    return;
  }
  const auto& places = lane_places_[octet].body;
  for (int l = 0; l < graphsolve::simd::lanes; ++l) task.pose[l] = &poses(octet_of(places[l]))->lane[lane_of(places[l])];
}

template <class T>
void PyramidContacts::point_at_rows(T** to, int octet, T* x) const {
  for (int l = 0; l < graphsolve::simd::lanes; ++l) to[l] = x + lane_places_[octet].row[l];
}

void PyramidContacts::look(std::span<const double> velocity) {
  for (int octet = 0; octet < static_cast<int>(octets_.size()); ++octet) {
    ContactTask task;
    task.octet = &octets_[octet];
    task.used = lane_places_[octet].used;
    task.one_body = one_body_[octet] != 0;
    point_at_poses(task, octet, When::now);
    point_at_rows(task.x, octet, velocity.data());
    kernels_.look(task);
  }
}

void PyramidContacts::save() {
  for (ContactOctet& o : octets_) {
    std::ranges::copy_n(o.z, std::ssize(o.saved_z), o.saved_z);
    std::ranges::copy(o.tangent[0], o.saved_tangent);
  }
}

void PyramidContacts::remember(Instances instances, double factor) {
  each_octet(instances, [&](ContactTask& task, int octet) {
    point_at_poses(task, octet, When::now);
    kernels_.remember(task, factor);
  });
}

void PyramidContacts::restore(Instances instances) {
  each_octet(instances, [&](ContactTask& task, int) { kernels_.restore(task); });
}

/// With force directions at the new configuration the arms change with it.
void PyramidContacts::aim_at_next(std::span<const int> contacts) {
  for (const int i : contacts) port(i).prepare(bodies_.pose_next(seats_[i].body));
}

void PyramidContacts::start_warm(Instances instances, std::span<const double> x, std::span<const double> mu,
                                 std::span<const double> scale) {
  if (bodies_.force_at_next) aim_at_next(instances.index);
  each_octet(instances, [&](ContactTask& task, int octet) {
    point_at_poses(task, octet, When::next);
    point_at_rows(task.x, octet, x.data());
    take(task.first, task, octet, mu);
    take(task.second, task, octet, scale);
    kernels_.start_warm(task);
  });
}

void PyramidContacts::start_cold(Instances instances, double velocity, std::span<const double> scale) {
  each_octet(instances, [&](ContactTask& task, int octet) {
    take(task.second, task, octet, scale);
    kernels_.start_cold(task, velocity);
  });
}

void PyramidContacts::evaluate(Instances instances, std::span<const double> x, std::span<double> residual,
                               std::span<const double> scale, std::span<double> error, std::span<double> product) {
  if (bodies_.force_at_next) aim_at_next(instances.index);
  each_octet(instances, [&](ContactTask& task, int octet) {
    point_at_poses(task, octet, When::next);
    point_at_rows(task.x, octet, x.data());
    point_at_rows(task.rows, octet, residual.data());
    take(task.second, task, octet, scale);
    kernels_.evaluate(task);
    give_largest(task, octet, task.out, error);
    give_largest(task, octet, task.also_out, product);
  });
}

void PyramidContacts::condense(Instances instances, std::span<const double> largest_ratio, double* values) {
  each_octet(instances, [&](ContactTask& task, int octet) {
    take(task.first, task, octet, largest_ratio);
    task.values = values;
    task.blocks = &blocks_[octet];
    kernels_.condense(task);
  });
}

void PyramidContacts::right_hand_side(Instances instances, std::span<const double> mu,
                                      std::span<const double> correction, std::span<double> rhs) {
  each_octet(instances, [&](ContactTask& task, int octet) {
    take(task.first, task, octet, mu);
    take(task.second, task, octet, correction);
    point_at_rows(task.rows, octet, rhs.data());
    kernels_.right_hand_side(task);
  });
}

void PyramidContacts::recover(Instances instances, std::span<const double> dx, std::span<double> ratio) {
  each_octet(instances, [&](ContactTask& task, int octet) {
    point_at_rows(task.x, octet, dx.data());
    kernels_.recover(task);
    give_largest(task, octet, task.out, ratio);
  });
}

void PyramidContacts::complementarity(Instances instances, std::span<const double> alpha,
                                      std::span<double> sum) const {
  each_octet(instances, [&](ContactTask& task, int octet) {
    take(task.first, task, octet, alpha);
    kernels_.complementarity(task);
    give(task, octet, [&](int i, int lane) { product_[i] = task.out[lane]; });
  });
  // In the order of the contacts, whatever octets they are in: the sum in bits depends on it.
  for (const int i : instances.index) sum[instances.component[i]] += product_[i];
}

void PyramidContacts::accept(Instances instances, std::span<const double> alpha) {
  each_octet(instances, [&](ContactTask& task, int octet) {
    take(task.first, task, octet, alpha);
    kernels_.accept(task);
  });
}

void PyramidContacts::relax(Instances instances, double damping, std::span<double> change) {
  for (const int i : instances.index) {
    ContactOctet& o = octets_[octet_of(place_[i])];
    const int lane = lane_of(place_[i]);
    double &frozen = o.frozen[lane], &held = o.frozen_bound[lane];
    const double moved = relax_bound(law(i).friction_bound(), o.scale[lane], damping, frozen, held);
    graphsolve::keep_largest(change[instances.component[i]], moved);
  }
}

}  // namespace physics
