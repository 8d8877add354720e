#include "graphsolve/ordering.hpp"

namespace graphsolve {

namespace {

NodeKind counterpart(NodeKind kind) { return kind == NodeKind::saddle ? NodeKind::regular : NodeKind::saddle; }

/// Is the host's own part of the constraint enough for the guest's pivot?
bool carries(EdgeRank rank, NodeKind guest) {
  if (rank == EdgeRank::full) return true;
  return rank == (guest == NodeKind::saddle ? EdgeRank::full_row : EdgeRank::full_column);
}

}  // namespace

Eligibility::Eligibility(const BlockGraph& graph)
    : graph_(graph), eliminated_(graph.size(), 0), eligible_(graph.size(), 0), waiting_(graph.size(), 0) {
  for (int i = 0; i < graph.size(); ++i) {
    const NodeKind kind = graph.kind({i});
    if (kind != NodeKind::regular)
      for (const auto& edge : graph.edges({i})) waiting_[i] += graph.kind(edge.to) == counterpart(kind);
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
  const NodeKind kind = graph_.kind(node);
  // Guests lean on this node: saddle nodes on a regular one, semidefinite nodes on a saddle one.
  const NodeKind guest_kind = kind == NodeKind::regular ? NodeKind::saddle : NodeKind::semidefinite;
  if (kind == NodeKind::semidefinite) return;
  int left = 0, only = -1;
  EdgeRank rank = EdgeRank::unknown;
  for (const auto& edge : graph_.edges(node)) {
    const int guest = edge.to.index;
    if (graph_.kind(edge.to) != guest_kind) continue;
    if (--waiting_[guest] == 0) free_node(guest, freed);
    if (eliminated_[guest]) continue;
    ++left;
    only = guest;
    rank = edge.rank;
  }
  if (left == 1 && carries(rank, guest_kind)) free_node(only, freed);
}

}  // namespace graphsolve
