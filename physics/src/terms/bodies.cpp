#include "terms/bodies.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simd/placement.hpp"

/// The term. The state between steps: bodies_state.cpp.
namespace physics {

void Bodies::wire(const graphsolve::Wiring& wiring) {
  std::vector<Placed> placed;
  for (int i = 0; i < size(); ++i) {
    row[i] = wiring.row(node_[i]);
    placed.push_back({0, wiring.claim(node_[i], node_[i])});
  }
  kernels_ = body_kernels();
  move_to(places_in_octets(placed));
  const std::size_t octets = octets_.size() - 1;
  groups_.resize(static_cast<int>(octets));
  blocks_.assign(octets, {});
  rows_.assign(octets, {});
  std::vector<int> body_at(octets * graphsolve::simd::lanes, -1);
  for (int i = 0; i < size(); ++i) {
    blocks_[octet_of(place_[i])].set(lane_of(place_[i]), placed[i].block);
    rows_[octet_of(place_[i])].fill(row[i]);
    body_at[place_[i]] = i;
  }
  for (int i = 0; i < size(); ++i) rows_[octet_of(place_[i])][lane_of(place_[i])] = row[i];
  for (auto& blocks : blocks_) blocks.finish();
  of_copies_.wire(std::move(body_at));
}

int Bodies::octet_of_all(std::span<const int, graphsolve::simd::lanes> body) const {
  int octet = -1;
  const int of_world = static_cast<int>(octets_.size()) - 1;
  for (int l = 0; l < graphsolve::simd::lanes; ++l) {
    if (body[l] == nothing) continue;
    const int here = body[l] < 0 ? of_world : octet_of(place_[body[l]]);
    if ((body[l] >= 0 && lane_of(place_[body[l]]) != l) || (octet >= 0 && octet != here)) return -1;
    octet = here;
  }
  return octet;
}

void Bodies::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  groups_.each(instances.index, instances.version, [&](int i) { return place_[i]; }, [&](int octet, unsigned used) {
    BodyTask task;
    task.body = &octets_[octet];
    task.at = &at_[octet];
    task.residual = &residual_[joints_push_ ? octet : 0];
    task.used = used;
    task.dt = dt;
    task.rows = rows_[octet].data();
    task.x = x.data();
    task.values = values;
    task.turn_always = turn_always;
    task.blocks = &blocks_[octet];
    kernels_.evaluate(task);
    if (!joints_push_) kernels_.hand_out(*task.residual, used, task.rows, residual.data());
  });
}

void Bodies::let_joints_push() {
  joints_push_ = true;
  residual_.resize(octets_.size());
}

void Bodies::hand_out(std::span<double> residual) {
  groups_.each_again([&](int octet, unsigned used) {
    kernels_.hand_out(residual_[octet], used, rows_[octet].data(), residual.data());
  });
}

/// Keeps |w + alpha dw| dt below the bound: the larger root of a quadratic in alpha.
void Bodies::bound_step(graphsolve::Instances instances, std::span<const double> x, std::span<const double> dx,
                        std::span<double> alpha) const {
  const double bound = largest_turn / dt, bound2 = bound * bound;
  for (const int i : instances.index) {
    double& a = alpha[instances.component[i]];
    const Eigen::Map<const Vec3> w(x.data() + row[i] + 3), dw(dx.data() + row[i] + 3);
    if (!((w + a * dw).squaredNorm() > bound2)) continue;
    const double dd = dw.squaredNorm(), wd = w.dot(dw), c = std::max(0.0, bound2 - w.squaredNorm());
    a = std::min(a, 0.99 * (std::sqrt(wd * wd + dd * c) - wd) / dd);
  }
}

}  // namespace physics
