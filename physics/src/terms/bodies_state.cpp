#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "mechanism/limits.hpp"
#include "terms/bodies.hpp"

/// What bodies are, and their state between steps.
namespace physics {

namespace {

template <class T>
void put(const T& numbers, Octet* to, int lane) {
  for (Eigen::Index k = 0; k < numbers.size(); ++k) to[k][lane] = numbers.data()[k];
}

}  // namespace

void Bodies::reserve(int bodies) {
  const auto each = [&](auto&... lists) { (lists.reserve(bodies), ...); };
  each(node_, row, place_);
  octets_.reserve(octets_for(bodies) + 1);
}

/// A body has its place from the start; wire() finds a better one.
void Bodies::add(const RigidBody& body, graphsolve::NodeId node) {
  node_.push_back(node);
  row.push_back(-1);
  place_.push_back(size() - 1);
  kernels_ = body_kernels();
  octets_.resize(octets_for(size()) + 1, BodyOctet::at_origin());
  set(size() - 1, body, Vec3::Zero());
}

void Bodies::move_to(std::vector<int> places) {
  const int octets = octets_with(places);
  const auto before = std::exchange(octets_, std::vector<BodyOctet>(octets + 1, BodyOctet::at_origin()));
  for (std::size_t i = 0; i < places.size(); ++i)
    copy_lane(before[octet_of(place_[i])], lane_of(place_[i]), octets_[octet_of(places[i])], lane_of(places[i]));
  place_ = std::move(places);
  saved_.assign(octets + 1, {});
  at_.assign(octets + 1, BodyAtOctet::at_origin());
  residual_.resize(1);
}

void Bodies::set(int i, const RigidBody& body, const Vec3& gravity) {
  BodyOctet& octet = octet_with(i);
  octet.mass[lane_with(i)] = body.mass;
  for (int k = 0, c = 0; c < 3; ++c)
    for (int r = c; r < 3; ++r) octet.inertia[k++][lane_with(i)] = body.inertia(r, c);
  put(gravity, octet.gravity, lane_with(i));
}

Mat3 Bodies::inertia(int i) const {
  const BodyOctet& octet = octet_with(i);
  Mat3 inertia;
  for (int k = 0, c = 0; c < 3; ++c)
    for (int r = c; r < 3; ++r) inertia(r, c) = inertia(c, r) = octet.inertia[k++][lane_with(i)];
  return inertia;
}

double Bodies::kinetic_energy(int i) const {
  const Vec3 w = spin(i);
  return 0.5 * (mass(i) * velocity(i).squaredNorm() + w.dot(inertia(i) * w));
}

Pose Bodies::pose_now(int body) const {
  if (body < 0) return world_pose;
  Pose pose;
  copy_now(body, pose.x.data());
  return pose;
}

void Bodies::copy_now(int body, double* to) const {
  const BodyOctet& octet = octet_with(body);
  const int lane = lane_with(body);
  for (int k = 0; k < 3; ++k) to[k] = octet.state.x[k][lane];
  for (int k = 0; k < 4; ++k) to[3 + k] = octet.state.q[k][lane];
  for (int k = 0; k < 9; ++k) to[7 + k] = octet.rotation[k][lane];
}

void Bodies::place(int i, const Vec3& x, const Quat& q) {
  BodyOctet& octet = octet_with(i);
  put(x, octet.state.x, lane_with(i));
  put(q.coeffs(), octet.state.q, lane_with(i));
  kernels_.place(octet, 1u << lane_with(i));
}

void Bodies::set_velocity(int i, const Vec3& v, const Vec3& w) {
  put(v, octet_with(i).state.velocity, lane_with(i));
  put(w, octet_with(i).state.velocity + 3, lane_with(i));
}

void Bodies::set_missed(int i, const Vec3& linear, const Vec3& angular) {
  put(linear, octet_with(i).missed, lane_with(i));
  put(angular, octet_with(i).missed + 3, lane_with(i));
}

void Bodies::add_known(int i, const Vec3& linear, const Vec3& angular) {
  Octet* known = octet_with(i).known;
  for (int k = 0; k < 3; ++k) {
    known[k][lane_with(i)] += linear[k];
    known[k + 3][lane_with(i)] += angular[k];
  }
}

unsigned Bodies::begin(std::span<const int> copies, const BodyStart& start) {
  unsigned beyond = 0;
  of_copies_.each(copies, [&](int octet, unsigned used) { beyond |= kernels_.begin(octets_[octet], used, start); });
  return beyond;
}

bool Bodies::commit(std::span<const int> copies, std::span<const double> residual) {
  bool sound = true;
  of_copies_.each(copies, [&](int octet, unsigned used) {
    sound &= !kernels_.commit(octets_[octet], used, at_[octet], rows_[octet].data(), residual.data());
  });
  return sound;
}

bool Bodies::has_energy(int i, const Vec3& gravity) const {
  const Vec3 w = spin(i);
  const double v = velocity(i).lpNorm<Eigen::Infinity>(), x = position(i).lpNorm<Eigen::Infinity>();
  return mass(i) * v * (v + x) + w.dot(inertia(i) * w) + std::abs(mass(i) * gravity.dot(position(i))) <= largest_energy;
}

void Bodies::save() {
  for (std::size_t k = 0; k < octets_.size(); ++k) saved_[k] = octets_[k].state;
}

void Bodies::restore(int copy) {
  of_copies_.each({&copy, 1}, [&](int octet, unsigned used) {
    for (unsigned rest = used; rest != 0; rest &= rest - 1) {
      const int lane = std::countr_zero(rest);
      copy_lane(saved_[octet], lane, octets_[octet].state, lane);
    }
    kernels_.place(octets_[octet], used);
  });
}

void Bodies::forget_missed(int copy) {
  of_copies_.each({&copy, 1}, [&](int octet, unsigned used) {
    for (unsigned rest = used; rest != 0; rest &= rest - 1)
      for (Octet& number : octets_[octet].missed) number[std::countr_zero(rest)] = 0;
  });
}

void Bodies::exchange_with_saved() {
  for (std::size_t k = 0; k < octets_.size(); ++k) {
    std::swap(saved_[k], octets_[k].state);
    kernels_.place(octets_[k], 0xffu);
  }
}

}  // namespace physics
