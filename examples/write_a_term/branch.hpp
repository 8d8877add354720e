#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "graphsolve/term.hpp"

/// A smooth term: branches of an electrical circuit. Unknowns are the potentials of the nodes [V], rows the sum of the
/// currents that leave a node [A]. The current from a to b is
///   i(v) = v / (R sqrt(1 + (v / v0)^2)),   v = x_a - x_b - emf:
/// a resistor where v0 is infinite, a lamp whose resistance rises as it heats up where it is not.
struct Branch {
  graphsolve::NodeId from, to;  ///< `to` of index -1: ground, 0 V
  double ohm;
  double emf = 0;
  double saturation = std::numeric_limits<double>::infinity();

  [[nodiscard]] double current(double v) const { return v / (ohm * std::sqrt(1 + v * v / (saturation * saturation))); }
  /// di/dv = 1 / (R (1 + (v/v0)^2)^(3/2)) > 0: the term is monotone.
  [[nodiscard]] double conductance(double v) const {
    return 1 / (ohm * std::pow(1 + v * v / (saturation * saturation), 1.5));
  }
};

class Branches final : public graphsolve::Term {
 public:
  void add(const Branch& branch) { branches_.push_back({branch, {branch.from, branch.to}, {}, {}}); }

  [[nodiscard]] int size() const override { return static_cast<int>(branches_.size()); }
  [[nodiscard]] std::span<const graphsolve::NodeId> nodes(int i) const override {
    return {branches_[i].nodes.data(), branches_[i].ends()};
  }

  void wire(const graphsolve::Wiring& wiring) override {
    for (Wired& w : branches_)
      for (std::size_t a = 0; a < w.ends(); ++a) {
        w.row[a] = wiring.row(w.nodes[a]);
        for (std::size_t b = 0; b < w.ends(); ++b) w.entry[a][b] = wiring.block(w.nodes[a], w.nodes[b]).offset;
      }
  }

  void evaluate(graphsolve::Instances instances, std::span<const double> x, std::span<double> residual,
                double* values) override {
    constexpr double sign[2] = {1, -1};  // the current leaves `from` and enters `to`
    for (const int i : instances.index) {
      const Wired& w = branches_[i];
      double v = -w.branch.emf;
      for (std::size_t a = 0; a < w.ends(); ++a) v += sign[a] * x[w.row[a]];
      for (std::size_t a = 0; a < w.ends(); ++a) {
        residual[w.row[a]] += sign[a] * w.branch.current(v);
        if (!values) continue;
        for (std::size_t b = 0; b < w.ends(); ++b)
          values[w.entry[a][b]] += sign[a] * sign[b] * w.branch.conductance(v);
      }
    }
  }

 private:
  struct Wired {
    Branch branch;
    std::array<graphsolve::NodeId, 2> nodes;
    int row[2];
    std::int64_t entry[2][2];
    [[nodiscard]] std::size_t ends() const { return nodes[1].index < 0 ? 1 : 2; }
  };
  std::vector<Wired> branches_;
};
