#pragma once

#include <span>
#include <vector>

#include "graphsolve/term.hpp"

/// The two terms of a quadratic program on a graph; with Bound and Nonnegative as ports it needs no others.
namespace graphsolve {

/// Costs 1/2 x' H x + c' x, each over the unknowns x of a few nodes, one node after the other: F = H x + c.
class QuadraticCost final : public Term {
 public:
  /// hessian: symmetric n x n with n the sum of the nodes' dimensions, column-major; empty: zero.
  /// gradient: c, n entries; empty: zero.  Lengths and symmetry (to 1e-8 of the largest entry) are checked by wire(), which
  /// throws std::invalid_argument.
  void add(std::span<const NodeId> nodes, std::span<const double> hessian, std::span<const double> gradient = {});
  /// One node, H diagonal: weight and, where given, c by component, as many as the node's dimension.
  void add_diagonal(NodeId node, std::span<const double> weight, std::span<const double> gradient = {});

  [[nodiscard]] int size() const override { return static_cast<int>(costs_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override { return costs_[i].nodes; }
  void wire(const Wiring& wiring) override;
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override;

 private:
  struct Cost {
    std::vector<NodeId> nodes;
    std::vector<double> hessian, gradient;
    bool diagonal;
    std::vector<int> row;                 ///< of every unknown
    std::vector<std::int64_t> entry;      ///< of every entry of the hessian
  };
  std::vector<Cost> costs_;
};

/// Constraints g = sum_j A_j x_j - b = 0, one saddle node each, whose unknowns are the multipliers lambda. With the
/// signs of Term: rows of the constraint get +g, rows of x_j get -A_j' lambda. At a solution lambda is the change of the
/// least cost with b. Where an A_j has independent rows, BlockGraph::add_edge(constraint, node, EdgeRank::full) says so, and
/// lets the constraint be eliminated as soon as that node is: on chains of states and inputs that is the difference
/// between some fill and none.
class LinearConstraint final : public Term {
 public:
  struct Part {
    NodeId node;
    std::vector<double> matrix;  ///< A_j, column-major, rows of the constraint by dimension of the node
  };
  /// Lengths are checked by wire(), which throws std::invalid_argument.
  void add(NodeId constraint, std::span<const Part> parts, std::span<const double> right_hand_side);

  [[nodiscard]] int size() const override { return static_cast<int>(constraints_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override { return constraints_[i].nodes; }
  [[nodiscard]] Coupling coupling() const override { return Coupling::star; }
  void wire(const Wiring& wiring) override;
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override;

 private:
  struct Place {
    int row, columns;
    BlockHandle down, across;  ///< blocks (constraint, node) and (node, constraint)
  };
  struct Constraint {
    std::vector<NodeId> nodes;                ///< the constraint, then what it constrains
    std::vector<std::vector<double>> matrix;  ///< by part
    std::vector<double> right_hand_side;
    int row;
    std::vector<Place> place;  ///< by part
  };
  std::vector<Constraint> constraints_;
};

}  // namespace graphsolve
