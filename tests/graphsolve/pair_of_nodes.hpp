#pragma once

#include "graphsolve/robust_solver.hpp"

/// Two coupled nodes of one row each, "left" and "right", for tests of the robust solver: numbers small enough to work out.
namespace cases {

inline graphsolve::BlockGraph pair_graph(graphsolve::NodeKind kind = graphsolve::NodeKind::regular) {
  graphsolve::BlockGraph graph;
  const graphsolve::NodeId a = graph.add_node("left", 1, kind), b = graph.add_node("right", 1, kind);
  graph.add_edge(a, b);
  return graph;
}

inline void fill(graphsolve::RobustSolver& solver, double aa, double ab, double ba, double bb) {
  const graphsolve::Symbolic& s = solver.symbolic();
  solver.entry(s.block({0}, {0})) = aa;
  solver.entry(s.block({0}, {1})) = ab;
  solver.entry(s.block({1}, {0})) = ba;
  solver.entry(s.block({1}, {1})) = bb;
}

}  // namespace cases
