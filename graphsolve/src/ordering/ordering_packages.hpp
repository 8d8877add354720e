#pragma once

#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"

/// Sequences of other packages; they know nothing of the eligibility rule. Each is defined only where its package was
/// found.
namespace graphsolve::packages {

/// The graph as the packages want it: neighbours of node i are list[begin[i]] .. list[begin[i + 1] - 1], ascending.
struct Adjacency {
  std::vector<int> begin, list;
};
Adjacency adjacency(const BlockGraph& graph);

std::vector<NodeId> to_nodes(const std::vector<int>& order);

// SuiteSparse
std::vector<NodeId> amd(const BlockGraph& graph);
std::vector<NodeId> camd(const BlockGraph& graph);
std::vector<int> camd(const Adjacency& adjacency, std::span<const int> stage);  ///< nodes of stage 0 first, then 1, ...
std::vector<NodeId> colamd(const BlockGraph& graph);
// METIS
std::vector<NodeId> nested_dissection(const BlockGraph& graph);
// Boost.Graph
std::vector<NodeId> minimum_degree(const BlockGraph& graph);
std::vector<NodeId> reverse_cuthill_mckee(const BlockGraph& graph);
std::vector<NodeId> sloan(const BlockGraph& graph);

}  // namespace graphsolve::packages
