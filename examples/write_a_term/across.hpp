#pragma once

#include <array>

#include "graphsolve/port_batch.hpp"

/// A port between two nodes of one unknown each: u = limit - (x_a - x_b). With the law 0 <= u _|_ f >= 0 it is a diode:
/// f is its current from a to b, u the voltage that is missing until it conducts.
class Across {
 public:
  static constexpr int rows = 1;
  static constexpr int node_count = 2;
  std::array<graphsolve::NodeId, 2> nodes;

  Across(graphsolve::NodeId from, graphsolve::NodeId to, double limit) : nodes{from, to}, limit_(limit) {}

  void wire(const graphsolve::Wiring& wiring) {
    for (int a = 0; a < 2; ++a) {
      row_[a] = wiring.row(nodes[a]);
      for (int b = 0; b < 2; ++b) entry_[a][b] = wiring.block(nodes[a], nodes[b]).offset;
    }
  }
  void evaluate(std::span<const double> x, double* u) const { u[0] = limit_ - x[row_[0]] + x[row_[1]]; }
  /// J1 = J2 = (-1, 1).
  void add_force(const double* f, double* residual, double sign) const {
    for (int a = 0; a < 2; ++a) residual[row_[a]] += sign * slope[a] * f[0];
  }
  void rate(const double* dx, double* du) const { du[0] = slope[0] * dx[row_[0]] + slope[1] * dx[row_[1]]; }
  void add_condensed(const double* k, double* values) const {
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) values[entry_[a][b]] += slope[a] * k[0] * slope[b];
  }

 private:
  static constexpr double slope[2] = {-1, 1};
  double limit_;
  int row_[2] = {-1, -1};
  std::int64_t entry_[2][2] = {};
};
