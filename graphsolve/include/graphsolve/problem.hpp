#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/port_batch.hpp"
#include "graphsolve/term.hpp"

namespace graphsolve {

/// A complementarity problem on a graph: find x with  F(x) - sum J1^T f = 0  (smooth terms and ports), each f
/// tied to its u(x) by its law. Holds references: terms and ports stay the caller's and must outlive it.
class Problem {
 public:
  /// The nodes, and those edges whose rank is known; the couplings of terms and ports are added by add().
  explicit Problem(BlockGraph graph);

  /// Throws std::invalid_argument where an instance names no node, or one that is not in the graph.
  void add(Term& term);
  /// Returns the number of the batch, for InteriorPoint::activate. Throws as for a term.
  int add(PortBatch& ports);

  /// Makes residuals comparable: |residual| * scale is what the stopping test reads, one entry per row of the
  /// node. Rows that are not set get one over the diagonal of the matrix, wherever x is, where that is positive, else 1;
  /// of a diagonal below 1e-4 of what couples the row to others at the start, over that. With rows that are not set no start
  /// is accepted without an iteration: a diagonal that cancels against its neighbours is no measure of x.
  /// Throws std::invalid_argument unless there are as many as the node has rows, and all are numbers > 0.
  void set_row_scale(NodeId node, std::span<const double> scale);
  /// What set_row_scale throws.
  void check_row_scale(NodeId node, std::span<const double> scale) const;

  [[nodiscard]] const BlockGraph& graph() const { return graph_; }
  [[nodiscard]] std::span<Term* const> terms() const { return terms_; }
  [[nodiscard]] std::span<PortBatch* const> ports() const { return ports_; }
  /// By row, NaN where not set; empty where none is.
  [[nodiscard]] std::span<const double> row_scale() const { return row_scale_; }
  /// Terms and ports keep the places of one Symbolic: whoever wires them takes a number here, and may use them for as long as
  /// nobody has taken another for one of them, by this problem or by another (InteriorPoint, check_terms).
  std::int64_t take_wiring();
  [[nodiscard]] bool wired(std::int64_t number) const;

 private:
  void check_node(NodeId node, const char* what) const;
  void couple(std::span<const NodeId> nodes, Coupling coupling);
  BlockGraph graph_;
  std::vector<Term*> terms_;
  std::vector<PortBatch*> ports_;
  std::vector<double> row_scale_;
};

}  // namespace graphsolve
