#include "graphsolve/ordering.hpp"

namespace graphsolve {

namespace {

/// Saddle nodes wait for regular and semidefinite nodes, semidefinite nodes for saddle nodes.
bool waits_for(NodeKind guest, NodeKind host) {
  if (guest == NodeKind::saddle) return host == NodeKind::regular || host == NodeKind::semidefinite;
  return guest == NodeKind::semidefinite && host == NodeKind::saddle;
}

/// Is the host's own part of the constraint enough for the guest's pivot?
bool carries(EdgeRank rank, NodeKind guest) {
  if (rank == EdgeRank::full) return true;
  return rank == (guest == NodeKind::saddle ? EdgeRank::full_row : EdgeRank::full_column);
}

}  // namespace

Eligibility::Eligibility(const BlockGraph& graph)
    : graph_(graph), eliminated_(graph.size(), 0), eligible_(graph.size(), 0), waiting_(graph.size(), 0) {
  for (int i = 0; i < graph.size(); ++i) {
    for (const auto& edge : graph.edges({i})) waiting_[i] += waits_for(graph.kind({i}), graph.kind(edge.to));
    eligible_[i] = waiting_[i] == 0;
  }
}

void Eligibility::free_node(int node, std::vector<NodeId>& freed) {
  if (eligible_[node] || eliminated_[node]) return;
  eligible_[node] = 1;
  freed.push_back({node});
}

void Eligibility::eliminate(NodeId node, std::vector<NodeId>& freed) {
  eliminated_[node.index] = 1;
  eligible_[node.index] = 0;
  // The guest that is left alone with this host has the host's whole rank to itself; with two, neither is sure.
  int left = 0;
  BlockGraph::Edge last{};
  for (const auto& edge : graph_.edges(node)) {
    const int guest = edge.to.index;
    if (!waits_for(graph_.kind(edge.to), graph_.kind(node))) continue;
    if (--waiting_[guest] == 0) free_node(guest, freed);
    if (eliminated_[guest]) continue;
    ++left;
    last = edge;
  }
  if (left == 1 && carries(last.rank, graph_.kind(last.to))) free_node(last.to.index, freed);
}

}  // namespace graphsolve
