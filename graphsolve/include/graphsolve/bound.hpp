#pragma once

#include <array>
#include <stdexcept>
#include <string>

#include "graphsolve/port_batch.hpp"

namespace graphsolve {

/// A port on one scalar of a node: u = x_i - limit (lower) or u = limit - x_i (upper). With the law Nonnegative
/// it is a bound of a quadratic or nonlinear program.
class Bound {
 public:
  static constexpr int rows = 1;
  static constexpr int node_count = 1;
  enum class Side { lower, upper };
  std::array<NodeId, 1> nodes;

  Bound(NodeId node, int component, Side side, double limit)
      : nodes{node}, component_(component), sign_(side == Side::lower ? 1.0 : -1.0), limit_(limit) {}

  void wire(const Wiring& wiring) {
    const BlockHandle block = wiring.block(nodes[0], nodes[0]);
    if (component_ < 0 || component_ >= block.rows)
      throw std::invalid_argument("bound: the node has no component " + std::to_string(component_));
    row_ = wiring.row(nodes[0]) + component_;
    entry_ = block.place(component_, component_);
  }
  void evaluate(std::span<const double> x, double* u) const { u[0] = sign_ * (x[row_] - limit_); }
  void add_force(const double* f, double* residual, double sign) const { residual[row_] += sign * sign_ * f[0]; }
  void rate(const double* dx, double* du) const { du[0] = sign_ * dx[row_]; }
  void add_condensed(const double* k, double* values) const { values[entry_] += k[0]; }

 private:
  int component_;
  double sign_, limit_;
  int row_ = -1;
  std::int64_t entry_ = -1;
};

}  // namespace graphsolve
