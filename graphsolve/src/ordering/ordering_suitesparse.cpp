#ifdef GRAPHSOLVE_SUITESPARSE

#include <amd.h>
#include <camd.h>
#include <colamd.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

#include "ordering/ordering_packages.hpp"

namespace graphsolve::packages {

namespace {

void check(const char* name, bool fine, int status) {
  if (!fine) throw std::runtime_error(std::string(name) + " failed with status " + std::to_string(status));
}

/// Where camd may place a node: saddle nodes after their small neighbours, hubs after the saddle nodes. A hub taken
/// early would couple all its saddle neighbours with each other; "hub" is what AMD calls a dense row.
int place(const BlockGraph& graph, NodeId node) {
  if (graph.kind(node) == NodeKind::saddle) return 1;
  if (graph.kind(node) == NodeKind::shared) return 2;
  const double dense = std::max(16.0, 10 * std::sqrt(static_cast<double>(graph.size())));
  return static_cast<double>(graph.edges(node).size()) > dense ? 2 : 0;
}

}  // namespace

std::vector<NodeId> amd(const BlockGraph& graph) {
  const Adjacency a = adjacency(graph);
  std::vector<int> order(graph.size());
  const int status = amd_order(graph.size(), a.begin.data(), a.list.data(), order.data(), nullptr, nullptr);
  check("AMD", status >= AMD_OK, status);
  return to_nodes(order);
}

std::vector<int> camd(const Adjacency& adjacency, std::span<const int> stage) {
  const int n = static_cast<int>(stage.size());
  // The sets must be numbered without gaps.
  std::vector<int> number(n == 0 ? 0 : 1 + *std::max_element(stage.begin(), stage.end()), -1), order(n), set(n);
  for (const int s : stage) number[s] = 0;
  for (int next = 0; int& s : number)
    if (s == 0) s = next++;
  for (int i = 0; i < n; ++i) set[i] = number[stage[i]];
  const int status =
      camd_order(n, adjacency.begin.data(), adjacency.list.data(), order.data(), nullptr, nullptr, set.data());
  check("CAMD", status >= CAMD_OK, status);
  return order;
}

std::vector<NodeId> camd(const BlockGraph& graph) {
  std::vector<int> places(graph.size());
  for (int i = 0; i < graph.size(); ++i) places[i] = place(graph, {i});
  return to_nodes(camd(adjacency(graph), places));
}

/// COLAMD orders the columns of a matrix for little fill in its normal equations. The columns are the nodes that are
/// not saddle nodes; a row is a saddle node or a coupling between two columns, so that a graph without saddle nodes
/// is ordered as itself. The saddle nodes come first here: the rule defers each until it may come.
std::vector<NodeId> colamd(const BlockGraph& graph) {
  std::vector<int> column_of(graph.size(), -1), row_of(graph.size(), -1), columns;
  std::vector<NodeId> sequence;
  int rows = 0;
  for (int i = 0; i < graph.size(); ++i) {
    if (graph.kind({i}) == NodeKind::saddle) {
      row_of[i] = rows++;
      sequence.push_back({i});
    } else {
      column_of[i] = static_cast<int>(columns.size());
      columns.push_back(i);
    }
  }
  std::vector<std::vector<int>> entries(columns.size());
  for (const int i : columns)
    for (const auto& edge : graph.edges({i})) {
      const int j = edge.to.index;
      if (row_of[j] >= 0) entries[column_of[i]].push_back(row_of[j]);
      if (column_of[j] <= column_of[i]) continue;
      entries[column_of[i]].push_back(rows);
      entries[column_of[j]].push_back(rows++);
    }
  std::vector<int> begin{0}, list;
  for (auto& column : entries) {
    std::sort(column.begin(), column.end());
    list.insert(list.end(), column.begin(), column.end());
    begin.push_back(static_cast<int>(list.size()));
  }
  const int count = static_cast<int>(columns.size());
  const std::size_t length = colamd_recommended(begin.back(), rows, count);
  if (length == 0) throw std::runtime_error("COLAMD: the graph is too large for it");
  list.resize(length);
  int status[COLAMD_STATS];
  const bool fine = ::colamd(rows, count, static_cast<int>(length), list.data(), begin.data(), nullptr, status) != 0;
  check("COLAMD", fine, status[COLAMD_STATUS]);
  for (int k = 0; k < count; ++k) sequence.push_back({columns[begin[k]]});
  return sequence;
}

}  // namespace graphsolve::packages

#endif
