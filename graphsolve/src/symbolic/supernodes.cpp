#include "graphsolve/supernodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "symbolic/elimination_tree.hpp"
#include "symbolic/equal_couplings.hpp"

namespace graphsolve {

namespace {

/// By build/release/bin/fit_supernodes, AMD EPYC with AVX-512, GCC 12 [ns].
constexpr FactorWork weights{20, 10, 11, 0.02, 0, 0.12, 5.9, 0.084, 0.14};

/// Merging nothing comes first: it wins a draw.
constexpr std::array<SupernodeSettings, 6> candidates{{{.largest = 1, .zeros = 0, .always_below = 1},
                                                       {.largest = 2, .zeros = 0.2, .always_below = 1},
                                                       {.largest = 4, .zeros = 0.1, .always_below = 2},
                                                       {.largest = 4, .zeros = 0.2, .always_below = 1},
                                                       {.largest = 6, .zeros = 0.1, .always_below = 1},
                                                       {.largest = 6, .zeros = 0.2, .always_below = 1}}};

/// Supernode of every pivot, named by its last pivot: the one nearest to the root.
class Merging {
 public:
  Merging(const BlockGraph& graph, const Ordering& ordering, const EliminationTree& tree, const SupernodeSettings& settings)
      : settings_(settings), tree_(tree), top_(tree.parent.size()), rows_(top_.size()), zeros_(top_.size(), 0.0) {
    std::iota(top_.begin(), top_.end(), 0);
    for (std::size_t k = 0; k < top_.size(); ++k) rows_[k] = graph.dimension(ordering.sequence[k]);
    merge(graph, ordering);
    for (int& top : top_) top = find(top);
  }
  [[nodiscard]] const std::vector<int>& top() const { return top_; }

 private:
  int find(int k) {
    while (top_[k] != k) k = top_[k] = top_[top_[k]];
    return k;
  }

  /// The child with the longest columns first: it brings the fewest zeros.
  void merge(const BlockGraph& graph, const Ordering& ordering) {
    const int n = static_cast<int>(top_.size());
    std::vector<int> order(n);
    std::iota(order.begin(), order.end(), 0);
    // Parents in ascending order, so that a parent knows its own size when it is merged further up.
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      const int pa = tree_.parent[a] < 0 ? n : tree_.parent[a], pb = tree_.parent[b] < 0 ? n : tree_.parent[b];
      return pa != pb ? pa < pb : tree_.rows_below[a] > tree_.rows_below[b];
    });
    for (const int c : order) {
      const int p = tree_.parent[c];
      if (p < 0) break;
      if (graph.kind(ordering.sequence[c]) != graph.kind(ordering.sequence[p])) continue;
      const double below = tree_.rows_below[p], rows = rows_[c] + rows_[p];
      const double zeros = zeros_[c] + zeros_[p] + rows_[c] * (rows_[p] + below - tree_.rows_below[c]);
      if (rows > settings_.largest) continue;
      if (rows > settings_.always_below && zeros > settings_.zeros * rows * (rows + below)) continue;
      top_[c] = p;
      rows_[p] += rows_[c];
      zeros_[p] = zeros;
    }
  }

  const SupernodeSettings& settings_;
  const EliminationTree& tree_;
  std::vector<int> top_, rows_;
  std::vector<double> zeros_;  ///< scalars, per top
};

Supernodes build(const BlockGraph& graph, const Ordering& ordering, const std::vector<int>& position,
                 const std::vector<int>& top) {
  const int n = graph.size();
  Supernodes result;
  result.ordering.repairs = ordering.repairs;
  result.ordering.forced = ordering.forced;
  std::vector<std::vector<int>> members(n);  // per top, ascending pivots
  for (int k = 0; k < n; ++k) members[top[k]].push_back(k);
  result.node_of.resize(n);
  result.row_of.resize(graph.rows());
  for (int t = 0; t < n; ++t) {
    if (members[t].empty()) continue;
    int dimension = 0;
    for (const int k : members[t]) dimension += graph.dimension(ordering.sequence[k]);
    const NodeId last = ordering.sequence[t];
    std::string name(graph.name(ordering.sequence[members[t].front()]));
    if (members[t].size() > 1) name += " .. " + std::string(graph.name(last));
    const NodeId merged = result.graph.add_node(std::move(name), dimension, graph.kind(last));
    result.ordering.sequence.push_back(merged);
    int row = result.graph.row(merged);
    for (const int k : members[t]) {
      const NodeId node = ordering.sequence[k];
      result.node_of[node.index] = merged;
      for (int i = 0; i < graph.dimension(node); ++i) result.row_of[graph.row(node) + i] = row++;
    }
  }
  for (int a = 0; a < n; ++a)
    for (const auto& edge : graph.edges({a})) {
      const NodeId from = result.node_of[a], to = result.node_of[edge.to.index];
      if (position[a] >= position[edge.to.index] || from == to) continue;
      const bool alone = members[top[position[a]]].size() == 1 && members[top[position[edge.to.index]]].size() == 1;
      result.graph.add_edge(from, to, alone ? edge.rank : EdgeRank::unknown);
    }
  return result;
}

}  // namespace

Supernodes merge_supernodes(const BlockGraph& graph, const Ordering& ordering, const SupernodeSettings& settings) {
  const std::vector<int> position = positions(graph, ordering);
  const EliminationTree tree(graph, ordering, position);
  return build(graph, ordering, position, Merging(graph, ordering, tree, settings).top());
}

Supernodes merge_supernodes(const BlockGraph& graph, const Ordering& ordering) {
  const std::vector<int> position = positions(graph, ordering);
  const EliminationTree tree(graph, ordering, position);
  Supernodes best;
  double least = 0;
  for (const SupernodeSettings& settings : candidates) {
    Supernodes merged = build(graph, ordering, position, Merging(graph, ordering, tree, settings).top());
    const double time = predicted_time(merged.graph, merged.ordering);
    if (best.node_of.empty() || time < least) {
      best = std::move(merged);
      least = time;
    }
  }
  return best;
}

std::span<const SupernodeSettings> supernode_candidates() { return candidates; }

FactorWork factor_work(const BlockGraph& graph, const Ordering& ordering) {
  const EliminationTree tree(graph, ordering, positions(graph, ordering));
  FactorWork work{};
  int together = 0;  // pivots before this one that update with it
  for (int k = 0; k < graph.size(); ++k) {
    const double d = graph.dimension(ordering.sequence[k]), rows = tree.rows_below[k], blocks = tree.blocks_below[k];
    const double operations = d * rows * rows, size = blocks > 0 ? rows / blocks : 0;
    work[0] += 1;
    work[1] += d;
    work[2] += blocks;
    work[3] += d * d * d / 3 + d * d * rows;
    // As group_size has it: the next one couples the same, and all are of one small size.
    const bool goes_on = size == d && d <= kernels::max_spread && tree.parent[k] == k + 1 && blocks > smallest_group &&
                         tree.blocks_below[k + 1] + 1 == blocks && (together + 2) * d <= kernels::at_once;
    if (size <= kernels::max_spread && size == std::floor(size)) {
      // What a group touches once is counted with its last pivot; inside it each member is touched by itself.
      work[4] += goes_on ? blocks : blocks * blocks;
      work[5] += operations;
    } else if (size <= kernels::max_rows) {
      work[6] += blocks * blocks;
      work[7] += operations;
    } else {
      work[8] += operations;
    }
    together = goes_on ? together + 1 : 0;
  }
  return work;
}

double predicted_time(const BlockGraph& graph, const Ordering& ordering) {
  const FactorWork work = factor_work(graph, ordering);
  return std::inner_product(work.begin(), work.end(), weights.begin(), 0.0);
}

}  // namespace graphsolve
