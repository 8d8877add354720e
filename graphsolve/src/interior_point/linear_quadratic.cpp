#include "graphsolve/linear_quadratic.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace graphsolve {
namespace {

void check_length(const char* what, std::size_t instance, std::size_t given, std::size_t needed) {
  if (given == needed) return;
  throw std::invalid_argument(std::string(what) + " " + std::to_string(instance) + ": " + std::to_string(given) +
                              " entries where " + std::to_string(needed) + " are needed");
}

void check_symmetric(std::size_t instance, std::span<const double> hessian, std::size_t n) {
  double largest = 0;
  for (const double entry : hessian) largest = std::max(largest, std::abs(entry));
  for (std::size_t c = 0; c < n; ++c)
    for (std::size_t r = c + 1; r < n; ++r) {
      const double below = hessian[c * n + r], right = hessian[r * n + c];
      if (std::abs(below - right) > 1e-8 * largest)
        throw std::invalid_argument("hessian of quadratic cost " + std::to_string(instance) + " is not symmetric: entry (" +
                                    std::to_string(r) + ", " + std::to_string(c) + ") is " + std::to_string(below) +
                                    ", its mirror image " + std::to_string(right));
    }
}

}  // namespace

void QuadraticCost::add(std::span<const NodeId> nodes, std::span<const double> hessian,
                        std::span<const double> gradient) {
  costs_.push_back({{nodes.begin(), nodes.end()},
                    {hessian.begin(), hessian.end()},
                    {gradient.begin(), gradient.end()},
                    false,
                    {},
                    {}});
}

void QuadraticCost::add_diagonal(NodeId node, std::span<const double> weight, std::span<const double> gradient) {
  costs_.push_back({{node}, {weight.begin(), weight.end()}, {gradient.begin(), gradient.end()}, true, {}, {}});
}

void QuadraticCost::wire(const Wiring& wiring) {
  for (std::size_t i = 0; i < costs_.size(); ++i) {
    Cost& cost = costs_[i];
    cost.row.clear();
    cost.entry.clear();
    for (const NodeId node : cost.nodes)
      for (int k = 0; k < wiring.block(node, node).rows; ++k) cost.row.push_back(wiring.row(node) + k);
    const std::size_t n = cost.row.size();
    if (!cost.gradient.empty()) check_length("gradient of quadratic cost", i, cost.gradient.size(), n);
    if (cost.hessian.empty()) continue;
    check_length("hessian of quadratic cost", i, cost.hessian.size(), cost.diagonal ? n : n * n);
    if (!cost.diagonal) check_symmetric(i, cost.hessian, n);
    for (const NodeId column_node : cost.nodes)
      for (int column = 0; column < wiring.block(column_node, column_node).rows; ++column)
        for (const NodeId node : cost.nodes) {
          const BlockHandle block = wiring.block(node, column_node);
          for (int row = 0; row < block.rows; ++row)
            if (!cost.diagonal || row == column) cost.entry.push_back(block.place(row, column));
        }
  }
}

void QuadraticCost::evaluate(Instances instances, std::span<const double> x, std::span<double> residual,
                             double* values) {
  for (const int i : instances.index) {
    const Cost& cost = costs_[i];
    const std::size_t n = cost.row.size();
    for (std::size_t k = 0; k < cost.gradient.size(); ++k) residual[cost.row[k]] += cost.gradient[k];
    for (std::size_t k = 0; k < cost.hessian.size(); ++k) {
      const std::size_t row = cost.diagonal ? k : k % n, column = cost.diagonal ? k : k / n;
      residual[cost.row[row]] += cost.hessian[k] * x[cost.row[column]];
      if (values) values[cost.entry[k]] += cost.hessian[k];
    }
  }
}

void LinearConstraint::add(NodeId constraint, std::span<const Part> parts, std::span<const double> right_hand_side) {
  Constraint made{{constraint}, {}, {right_hand_side.begin(), right_hand_side.end()}, -1, {}};
  for (const Part& part : parts) {
    made.nodes.push_back(part.node);
    made.matrix.push_back(part.matrix);
  }
  constraints_.push_back(std::move(made));
}

void LinearConstraint::wire(const Wiring& wiring) {
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    Constraint& c = constraints_[i];
    c.row = wiring.row(c.nodes[0]);
    c.place.clear();
    check_length("right-hand side of constraint", i, c.right_hand_side.size(),
                 wiring.block(c.nodes[0], c.nodes[0]).rows);
    for (std::size_t j = 0; j < c.matrix.size(); ++j) {
      const NodeId node = c.nodes[j + 1];
      const BlockHandle down = wiring.block(c.nodes[0], node);
      check_length("matrix of constraint", i, c.matrix[j].size(), static_cast<std::size_t>(down.rows) * down.columns);
      c.place.push_back({wiring.row(node), down.columns, down, wiring.block(node, c.nodes[0])});
    }
  }
}

void LinearConstraint::evaluate(Instances instances, std::span<const double> x, std::span<double> residual,
                                double* values) {
  for (const int i : instances.index) {
    const Constraint& c = constraints_[i];
    const int rows = static_cast<int>(c.right_hand_side.size());
    for (int r = 0; r < rows; ++r) residual[c.row + r] -= c.right_hand_side[r];
    for (std::size_t j = 0; j < c.matrix.size(); ++j) {
      const Place& p = c.place[j];
      const double* a = c.matrix[j].data();
      for (int k = 0; k < p.columns; ++k)
        for (int r = 0; r < rows; ++r, ++a) {
          residual[c.row + r] += *a * x[p.row + k];
          residual[p.row + k] -= *a * x[c.row + r];
          if (!values) continue;
          values[p.down.place(r, k)] += *a;
          values[p.across.place(k, r)] -= *a;
        }
    }
  }
}

}  // namespace graphsolve
