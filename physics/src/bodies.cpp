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

void Bodies::evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                      double* values) {
  using Vector3 = Eigen::Map<const Vec3>;
  for (const int i : instances.index) {
    const Vec3 v = Vector3(x.data() + row[i]), w = Vector3(x.data() + row[i] + 3);
    const Pose& from = now[i];
    Pose& to = next[i];
    const double s = rotation_scalar(w, dt);
    to.x = from.x + dt * v;
    to.q = rotate(from.q, w, s, dt);
    to.rotation = to.q.toRotationMatrix();
    to.turn = rotation_derivative(w, s, dt);
    Eigen::Map<Vec3>(residual.data() + row[i]) += mass[i] * v - known_linear[i];
    Eigen::Map<Vec3>(residual.data() + row[i] + 3) += momentum_plus(inertia[i], w, s, dt) - known_angular[i];
    if (!values) continue;
    Eigen::Map<Eigen::Matrix<double, 6, 6>> block(values + block_[i].offset);
    block(0, 0) += mass[i];
    block(1, 1) += mass[i];
    block(2, 2) += mass[i];
    block.bottomRightCorner<3, 3>() += momentum_plus_derivative(inertia[i], w, s, dt);
  }
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
