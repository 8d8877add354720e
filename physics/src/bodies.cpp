#include "bodies.hpp"

#include <algorithm>
#include <cmath>

#include "rotation.hpp"
#include "simd/placement.hpp"

namespace physics {

void Bodies::wire(const graphsolve::Wiring& wiring) {
  std::vector<Placed> placed;
  for (int i = 0; i < size(); ++i) {
    row[i] = wiring.row(node_[i]);
    placed.push_back({0, wiring.claim(node_[i], node_[i])});
  }
  place_ = places_in_octets(placed);
  const int octets = octets_for(1 + *std::max_element(place_.begin(), place_.end()));
  constants_.assign(octets, {});
  at_.assign(octets, {});
  kernel_ = body_kernel();
  groups_.resize(octets);
  blocks_.assign(octets, {});
  body_at_.assign(octets * graphsolve::simd::lanes, -1);
  for (int i = 0; i < size(); ++i) {
    blocks_[octet_of(place_[i])].set(lane_of(place_[i]), placed[i].block);
    body_at_[place_[i]] = i;
    set_octet(i);
  }
  for (auto& blocks : blocks_) blocks.finish();
}

const BodyAtOctet* Bodies::octet_of_all(std::span<const int, graphsolve::simd::lanes> body) const {
  int octet = -1;
  for (int l = 0; l < graphsolve::simd::lanes; ++l) {
    if (body[l] == nothing) continue;
    if (body[l] < 0) return nullptr;  // the world has no octet
    const int place = place_[body[l]];
    if (lane_of(place) != l || (octet >= 0 && octet_of(place) != octet)) return nullptr;
    octet = octet_of(place);
  }
  return octet < 0 ? nullptr : &at_[octet];
}

void Bodies::reserve(int bodies) {
  const auto each = [&](auto&... lists) { (lists.reserve(bodies), ...); };
  each(node_, row, now, known_linear, known_angular, mass, inertia);
}

void Bodies::add(const RigidBody& body, graphsolve::NodeId node) {
  node_.push_back(node);
  row.push_back(-1);
  now.emplace_back();
  known_linear.emplace_back(Vec3::Zero());
  known_angular.emplace_back(Vec3::Zero());
  mass.push_back(body.mass);
  inertia.push_back(body.inertia);
}

void Bodies::set(int i, const RigidBody& body) {
  mass[i] = body.mass;
  inertia[i] = body.inertia;
  set_octet(i);
}

void Bodies::set_octet(int i) {
  BodyOctet& octet = constants_[octet_of(place_[i])];
  const int lane = lane_of(place_[i]);
  octet.mass[lane] = mass[i];
  for (int k = 0; k < 9; ++k) octet.inertia[k][lane] = inertia[i].data()[k];
}

void Bodies::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  groups_.each(instances.index, instances.version, [&](int i) { return place_[i]; }, [&](int octet, unsigned used) {
    BodyTask task;
    task.constants = &constants_[octet];
    task.used = used;
    task.dt = dt;
    task.values = values;
    task.blocks = &blocks_[octet];
    each_lane(octet, used, [&](int lane, int place) {
      const int i = body_at_[place];
      task.velocity[lane] = x.data() + row[i];
      task.now[lane] = now[i].x.data();
      task.known_linear[lane] = known_linear[i].data();
      task.known_angular[lane] = known_angular[i].data();
      task.residual[lane] = residual.data() + row[i];
    });
    task.at = &at_[octet];
    kernel_(task);
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
