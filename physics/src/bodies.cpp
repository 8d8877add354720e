#include "bodies.hpp"

#include <algorithm>
#include <cmath>

#include "rotation.hpp"

namespace physics {

void Bodies::wire(const graphsolve::Wiring& wiring) {
  block_.clear();
  for (int i = 0; i < size(); ++i) {
    row[i] = wiring.row(node_[i]);
    block_.push_back(wiring.block(node_[i], node_[i]));
  }
}

void Bodies::add(const RigidBody& body, graphsolve::NodeId node) {
  const int i = size();
  mass.push_back(0);
  inertia.emplace_back();
  node_.push_back(node);
  row.push_back(-1);
  now.emplace_back();
  next.emplace_back();
  known_linear.emplace_back(Vec3::Zero());
  known_angular.emplace_back(Vec3::Zero());
  constants_.resize(octets_for(size()));
  groups_.resize(octets_for(size()));
  set(i, body);
}

void Bodies::set(int i, const RigidBody& body) {
  mass[i] = body.mass;
  inertia[i] = body.inertia;
  BodyOctet& octet = constants_[octet_of(i)];
  octet.mass[lane_of(i)] = body.mass;
  for (int k = 0; k < 9; ++k) octet.inertia[k][lane_of(i)] = body.inertia.data()[k];
}

void Bodies::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  groups_.each(instances.index, [](int i) { return i; }, [&](int octet, unsigned used) {
    BodyTask task;
    task.constants = &constants_[octet];
    task.used = used;
    task.dt = dt;
    each_lane(octet, used, [&](int lane, int i) {
      task.velocity[lane] = x.data() + row[i];
      task.now[lane] = now[i].x.data();
      task.next[lane] = next[i].x.data();
      task.known_linear[lane] = known_linear[i].data();
      task.known_angular[lane] = known_angular[i].data();
      task.residual[lane] = residual.data() + row[i];
      task.block[lane] = values ? values + block_[i].offset : nullptr;
    });
    evaluate_bodies(task);
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
