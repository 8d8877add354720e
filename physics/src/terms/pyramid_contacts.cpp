#include "terms/pyramid_contacts.hpp"

#include <algorithm>
#include <bit>

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

void PyramidPort::set_slip(SlipMeasure slip) {
  const unsigned bit = 1u << lane_, others = *displaced_ & ~bit;
  *displaced_ = static_cast<unsigned char>(slip == SlipMeasure::displacement ? others | bit : others);
}

void PyramidPort::prepare(const Pose& pose) {
  ContactPort<3> port = copy();
  port.prepare(pose);
  for (int r = 0; r < rows; ++r) set(octet_->lever[r], port.lever(r));
}

ContactPort<3> PyramidPort::copy() const {
  ContactPort<3> port(*bodies_, body_, point(), normal(), plane_offset(), radius());
  port.set_tangent(tangent1());
  port.set_slip((*displaced_ >> lane_ & 1) != 0 ? SlipMeasure::displacement : SlipMeasure::velocity);
  return port;
}

int PyramidContacts::add(int body) {
  seats_.push_back({bodies_.node(body), body});
  return size() - 1;
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
void PyramidContacts::give_largest(const ContactTask& task, int octet, const Octet& out,
                                   std::span<double> by_component) const {
  const LanePlaces& places = lane_places_[octet];
  if (places.side_by_side && task.used == 0xffu) {
    double* to = by_component.data() + places.component[0];
    for (int l = 0; l < graphsolve::simd::lanes; ++l)
      to[l] = out.lane[l] > to[l] || out.lane[l] != out.lane[l] ? out.lane[l] : to[l];
    return;
  }
  for (unsigned rest = task.used; rest != 0; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    graphsolve::keep_largest(by_component[places.component[lane]], out[lane]);
  }
}

/// Whole octets, or lane by lane.
void PyramidContacts::point_at_poses(ContactTask& task, int octet, When when) const {
  ContactTask::Poses& to = when == When::now ? task.now : task.next;
  const auto poses = [&](int bodies) {
    return when == When::now ? bodies_.poses_now(bodies) : bodies_.poses_next(bodies);
  };
  if (beside_[octet] >= 0) {
    to.all = poses(beside_[octet]);
    return;
  }
  const auto& places = lane_places_[octet].body;
  const int lanes = task.one_body ? 1 : graphsolve::simd::lanes;
  for (int l = 0; l < lanes; ++l) to.lane[l] = &poses(octet_of(places[l]))->lane[lane_of(places[l])];
}

void PyramidContacts::point_at_motion(ContactTask& task, int octet, std::span<const double> x) const {
  task.displaced = displaced_[octet];
  if (task.displaced != 0) point_at_poses(task, octet, When::now);
  point_at_poses(task, octet, When::next);
  if (beside_[octet] >= 0) task.velocities = bodies_.velocities_next(beside_[octet]);
  point_at_rows(task.x, octet, x.data());
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
    point_at_motion(task, octet, x);
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
    point_at_motion(task, octet, x);
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
    const LanePlaces& places = lane_places_[octet];
    if (!in_order_) give(task, octet, [&](int i, int lane) { product_[i] = task.out[lane]; });
    else if (places.side_by_side && task.used == 0xffu)
      for (int l = 0; l < graphsolve::simd::lanes; ++l) sum[places.component[0] + l] += task.out.lane[l];
    else give(task, octet, [&](int, int lane) { sum[places.component[lane]] += task.out[lane]; });
  });
  // In the order of the contacts, whatever octets they are in: the sum in bits depends on it.
  for (std::size_t k = 0; !in_order_ && k < instances.index.size(); ++k)
    sum[instances.component[instances.index[k]]] += product_[instances.index[k]];
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
