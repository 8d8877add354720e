#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/symbolic.hpp"

namespace graphsolve {

/// Price of some fill: `blocks` of one triangle, the `scalars` of both, and the multiplications and divisions of one
/// LDU factorization that would not be done without it.
struct FillPrice {
  std::int64_t blocks = 0;
  std::int64_t scalars = 0;
  std::int64_t operations = 0;
  friend bool operator==(const FillPrice&, const FillPrice&) = default;
};

/// Why there is fill. A biconnected component is a maximal set of nodes of which any two lie on a common cycle;
/// a graph is a tree exactly when it has none of three nodes and more. Fill inside of one is the price of its
/// cycles. Fill between nodes that no component holds together is no cycle's doing: a node that separates them was
/// eliminated first, and another order would do without.
struct FillCause {
  std::vector<NodeId> nodes;  ///< of the component, ascending; empty: the order is the cause
  int edges = 0;              ///< of the component
  int cycles = 0;             ///< independent ones: edges - nodes + 1; 0: the order is the cause
  FillPrice price;
};

struct FillBlock {
  NodeId first, later;  ///< in order of elimination
  int cause;            ///< index into FillAnalysis::causes
  FillPrice price;      ///< blocks = 1
};

/// Where fill is paid for, finer than cycles can be told apart: nodes eliminated one after the other of which each is
/// coupled in the factor with the next one and with what that is coupled with, no more, such as a separator. Together they
/// are one dense block with the rest of their front below.
struct FillFront {
  std::vector<NodeId> nodes;  ///< in order of elimination
  int rows = 0;               ///< of the front: theirs, and those coupled with them that stay
  FillPrice price;            ///< of the fill blocks whose `first` is one of them
};

/// What leaving out one edge would save. Both sides are ordered afresh by minimum fill, within the edge's
/// biconnected component alone: saving = price with the edge - price without.
struct EdgeSaving {
  NodeId a, b;
  std::int64_t blocks = 0;      ///< of fill, one triangle
  std::int64_t scalars = 0;     ///< of the factor, both triangles, the edge's own blocks among them
  std::int64_t operations = 0;  ///< of one LDU factorization
  int tried = 0, edges = 0;     ///< edges tried, of so many in components with fill
  [[nodiscard]] bool exact() const { return tried == edges; }
};

struct FillAnalysis {
  Symbolic::Counts counts;
  FillPrice total;                        ///< of all fill: the exact sum over `blocks`, over `causes` and over `fronts`
  std::int64_t operations_unfilled = 0;   ///< counts.operations - total.operations
  std::vector<FillCause> causes;          ///< most operations first
  std::vector<FillBlock> blocks;          ///< every fill block once, in order of elimination
  std::vector<FillFront> fronts;          ///< those with fill, most operations first; no node is in two
  std::optional<EdgeSaving> edge;         ///< whose removal saves most operations; none where no removal saves any
};

/// Explains the fill of an elimination. A pivot of d rows with r0 rows coupled by the graph and f by fill costs
/// f d^2 + d ((r0 + f)^2 - r0^2) operations more than without; a fill block of g rows gets g d^2 + d g (2 r0 + f) of it.
///
/// Costs O(fill), and for the edge a fixed budget (at most 1e5 nodes ordered afresh, the most expensive components
/// first): all edges are tried where they are few, else those first that reach furthest up the elimination tree.
///
/// Throws std::invalid_argument when the graph is not the one of `symbolic`, or this build has no Boost.Graph
/// (fill_analysis_available).
FillAnalysis analyze_fill(const BlockGraph& graph, const Symbolic& symbolic);

/// Was Boost.Graph there when graphsolve was built?
bool fill_analysis_available();

}  // namespace graphsolve
