#pragma once

#include <array>
#include <stdexcept>
#include <string>

#include "graphsolve/port_batch.hpp"

namespace graphsolve {

/// A port on one scalar of a node: u = x_i - limit (lower) or u = limit - x_i (upper). With the law Nonnegative
/// it is a bound of a quadratic or nonlinear program. A lower limit of -infinity or an upper one of infinity, or
/// beyond 1e150, is none: u = 1 wherever x is, and no force reaches the graph. Throws std::invalid_argument for NaN and
/// the other infinity.
class Bound {
 public:
  static constexpr int rows = 1;
  static constexpr int node_count = 1;
  enum class Side { lower, upper };
  std::array<NodeId, 1> nodes;

  Bound(NodeId node, int component, Side side, double limit)
      : nodes{node}, component_(component), sign_(side == Side::lower ? 1.0 : -1.0), limit_(limit) {
    if (!(sign_ * limit <= beyond))
      throw std::invalid_argument("bound: " + std::string(side == Side::lower ? "lower" : "upper") + " limit " +
                                  std::to_string(limit) + " of component " + std::to_string(component) +
                                  " cannot be kept");
    if (sign_ * limit >= -beyond) return;
    sign_ = 0;
    limit_ = 0;
    free_ = 1;
  }

  void wire(const Wiring& wiring) {
    const BlockHandle block = wiring.block(nodes[0], nodes[0]);
    if (component_ < 0 || component_ >= block.rows)
      throw std::invalid_argument("bound: the node has no component " + std::to_string(component_));
    row_ = wiring.row(nodes[0]) + component_;
    entry_ = block.place(component_, component_);
  }
  void evaluate(std::span<const double> x, double* u) const { u[0] = sign_ * (x[row_] - limit_) + free_; }
  void add_force(const double* f, double* residual, double sign) const { residual[row_] += sign * sign_ * f[0]; }
  void rate(const double* dx, double* du) const { du[0] = sign_ * dx[row_]; }
  void add_condensed(const double* k, double* values) const { values[entry_] += sign_ * sign_ * k[0]; }

 private:
  static constexpr double beyond = 1e150;  ///< whose square is a number
  int component_;
  double sign_, limit_;
  double free_ = 0;  ///< u where there is no limit
  int row_ = -1;
  std::int64_t entry_ = -1;
};

}  // namespace graphsolve
