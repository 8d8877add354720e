#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "graphsolve/problem.hpp"
#include "graphsolve/symbolic.hpp"

/// Checks for whoever writes a Term, a Port or a Law: compare what they say with central differences.
namespace graphsolve {

struct DerivativeReport {
  double largest_error = 0;  ///< |given - difference| / (1 + |difference|)
  std::string where;         ///< "row 2 of 'a' by column 0 of 'b'"

  /// Is this worse than all before? The first NaN is, and nothing after it.
  [[nodiscard]] bool worsened_by(double error) const { return !(error <= largest_error) && !std::isnan(largest_error); }
};

/// All smooth terms of a problem at x: every block of dF/dx, those that are structurally zero included.
/// Costs one evaluation per unknown: for small problems. Wires the terms anew: an InteriorPoint that was made before says so
/// with std::logic_error when it is used again. Throws std::invalid_argument where x has another length than the graph has
/// rows, and what a term throws when it is wired.
DerivativeReport check_terms(Problem& problem, std::span<const double> x, double step = 1e-6);

/// What check_port does: rate() is the derivative of u, add_condensed() is J1^T K J2 with the J1 of add_force(). entry(values, i, j)
/// reads entry (i, j) of the matrix.
template <class Port, class Entry>
DerivativeReport check_port_by_entries(Port& port, std::span<const double> x, std::size_t values_size, Entry&& entry, double step) {
  const int n = static_cast<int>(x.size());
  constexpr int rows = Port::rows;
  DerivativeReport report;
  std::vector<double> at(x.begin(), x.end()), direction(n, 0.0);
  double plus[rows], minus[rows], given[rows];
  for (int j = 0; j < n; ++j) {
    at[j] = x[j] + step;
    port.evaluate(at, plus);
    at[j] = x[j] - step;
    port.evaluate(at, minus);
    at[j] = x[j];
    port.evaluate(at, given);
    direction[j] = 1;
    port.rate(direction.data(), given);
    direction[j] = 0;
    for (int r = 0; r < rows; ++r) {
      const double difference = (plus[r] - minus[r]) / (2 * step);
      const double error = std::abs(given[r] - difference) / (1 + std::abs(difference));
      if (!report.worsened_by(error)) continue;
      report = {error, "row " + std::to_string(r) + " by unknown " + std::to_string(j)};
    }
  }
  // add_condensed against add_force and rate, column by column with unit K.
  std::vector<double> values(values_size), force(n);
  for (int r = 0; r < rows; ++r)
    for (int s = 0; s < rows; ++s) {
      double k[rows * rows] = {}, f[rows] = {};
      k[s * rows + r] = 1;
      f[r] = 1;
      std::fill(values.begin(), values.end(), 0.0);
      std::fill(force.begin(), force.end(), 0.0);
      port.add_condensed(k, values.data());
      port.add_force(f, force.data(), 1.0);
      for (int j = 0; j < n; ++j) {
        direction[j] = 1;
        port.rate(direction.data(), given);
        direction[j] = 0;
        for (int i = 0; i < n; ++i) {
          const double error = std::abs(entry(values, i, j) - force[i] * given[s]);
          if (!report.worsened_by(error)) continue;
          report = {error, "condensed entry " + std::to_string(i) + ", " + std::to_string(j)};
        }
      }
    }
  return report;
}

/// A port that is wired by this Symbolic, at x, a vector of all rows of its graph; another length throws
/// std::invalid_argument.
template <class Port>
DerivativeReport check_port(Port& port, const Symbolic& symbolic, std::span<const double> x, double step = 1e-6) {
  if (x.size() != static_cast<std::size_t>(symbolic.rows()))
    throw std::invalid_argument("check_port: a point of " + std::to_string(x.size()) + " numbers, the graph has " +
                                std::to_string(symbolic.rows()) + " rows");
  std::vector<int> pivot(x.size());
  for (int k = 0; k < symbolic.pivots(); ++k) std::fill_n(pivot.begin() + symbolic.row(k), symbolic.dimension(k), k);
  const auto entry = [&](const std::vector<double>& values, int i, int j) {
    const int a = pivot[i], b = pivot[j], first = std::min(a, b), last = std::max(a, b);
    const auto coupled = symbolic.coupled(first);
    const auto found = std::lower_bound(coupled.begin(), coupled.end(), last);
    const bool none = found == coupled.end() || *found != last || symbolic.is_fill(first, static_cast<int>(found - coupled.begin()));
    if (first != last && none) return 0.0;
    const BlockHandle block = symbolic.block(symbolic.node(a), symbolic.node(b));
    return values[block.place(i - symbolic.row(a), j - symbolic.row(b))];
  };
  return check_port_by_entries(port, x, static_cast<std::size_t>(symbolic.values_size()), entry, step);
}

/// A port that is wired to a graph of one node.
template <class Port>
DerivativeReport check_port(Port& port, std::span<const double> x, double step = 1e-6) {
  const std::size_t n = x.size();
  return check_port_by_entries(port, x, n * n, [&](const std::vector<double>& values, int i, int j) { return values[j * n + i]; }, step);
}

/// A law at u: one Newton step towards mu, taken by a small part alpha, must lower every local residual to
/// (1 - alpha) of itself up to alpha^2, and the force must move as f0 - K du says.
template <class Law>
DerivativeReport check_law(Law& law, std::span<const double> u, std::span<const double> du, double mu,
                           double alpha = 1e-5) {
  constexpr int rows = Law::rows;
  DerivativeReport report;
  double k[rows * rows], f0[rows], before[rows], after[rows], moved[rows];
  law.residual(u.data(), before);
  law.condense(1e300, k);
  law.right_hand_side(mu, 0.0, f0);
  law.recover(du.data());
  const double products = law.complementarity(0.0);
  const double promised = (1 - alpha) * products + alpha * mu * law.degree();
  const double quadratic = std::abs(law.complementarity(1.0)) + products + mu * law.degree();
  law.accept(alpha);
  const auto note = [&](double error, std::string where) {
    if (report.worsened_by(error)) report = {error, std::move(where)};
  };
  note(std::abs(law.complementarity(0.0) - promised) / (alpha * quadratic), "sum of products");
  for (int r = 0; r < rows; ++r) moved[r] = u[r] + alpha * du[r];
  law.residual(moved, after);
  for (int r = 0; r < rows; ++r) {
    double df = f0[r];
    for (int s = 0; s < rows; ++s) df -= k[s * rows + r] * du[s];
    note(std::abs((after[r] - before[r]) / alpha - df) / (1 + std::abs(df)), "force " + std::to_string(r));
  }
  return report;
}

}  // namespace graphsolve
