#pragma once

#include <array>
#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/ordering.hpp"

namespace graphsolve {

/// A graph whose nodes are merged into larger ones, so that the block factorization works on few large blocks
/// instead of many small ones. Pays where blocks are small and the fill is large: matrices of scalars, meshes.
struct Supernodes {
  BlockGraph graph;             ///< of the merged nodes; one that merges nothing keeps its name and kind
  Ordering ordering;            ///< of the merged nodes; repairs and forced as before
  std::vector<NodeId> node_of;  ///< per node of the given graph: the merged node that holds it
  std::vector<int> row_of;      ///< row i of the given graph is row row_of[i] of the merged one: a permutation
};

struct SupernodeSettings {
  int largest = 4;       ///< rows of a merged node; a node that is larger by itself stays alone
  double zeros = 0.1;    ///< part of a merged node's columns, it and what stands under it, that may be zeros
  int always_below = 2;  ///< merged nodes of up to so many rows are made whatever the zeros
};

/// Merges children with parents of the elimination tree where their columns are nearly equal: child c of rows w_c with
/// r_c rows under it, parent p of w_p and r_p, cost w_c (w_p + r_p - r_c) zeros (Ashcraft and Grimes 1989, "The
/// influence of relaxed supernode partitions on the multifrontal method"). Only nodes of one kind are merged, so that
/// signs and the eligibility rule keep their meaning. Cost O(scalars of the factor), memory O(nodes + edges).
/// Throws std::invalid_argument when the ordering is not one of this graph.
Supernodes merge_supernodes(const BlockGraph& graph, const Ordering& ordering, const SupernodeSettings& settings);

/// The same with the settings, among a few, of least predicted_time. Merges nothing where that is fastest.
Supernodes merge_supernodes(const BlockGraph& graph, const Ordering& ordering);

/// The settings it tries; the first merges nothing.
std::span<const SupernodeSettings> supernode_candidates();

/// Sums over the pivots of an elimination, of d rows with r rows in b blocks under each:
///   1,  d,  b,  d^3/3 + d^2 r;
///   where r / b is 1, 2, 3 or 4, as where all blocks are of that size: b^2 (together with other pivots: its share of
///   that), d r^2;  else where it is up to 8: b^2, d r^2;  where it is larger: d r^2.
using FactorWork = std::array<double, 9>;
FactorWork factor_work(const BlockGraph& graph, const Ordering& ordering);

/// Rough time of one Factorization of the graph in this order, pivots one by one [ns]: factor_work by weights that
/// bench/fit_supernodes.cpp found. Only to compare orderings and supernodes of one matrix. Cost O(blocks of the factor),
/// memory O(nodes).
double predicted_time(const BlockGraph& graph, const Ordering& ordering);

}  // namespace graphsolve
