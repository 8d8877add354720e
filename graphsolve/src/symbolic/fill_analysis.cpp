#include "graphsolve/fill_analysis.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>

#include "graph/biconnected.hpp"
#include "symbolic/edge_saving.hpp"
#include "symbolic/same_nodes.hpp"
#include "symbolic/operations.hpp"

namespace graphsolve {

namespace {

FillPrice& operator+=(FillPrice& a, const FillPrice& b) {
  a.blocks += b.blocks;
  a.scalars += b.scalars;
  add_operations(a.operations, b.operations);
  return a;
}

/// Appends the fill blocks of one pivot with their prices.
void price_pivot(const Symbolic& symbolic, int k, const Biconnected& biconnected, std::vector<FillBlock>& blocks) {
  const auto coupled = symbolic.coupled(k);
  const std::int64_t d = symbolic.dimension(k);
  std::int64_t filled = 0;
  for (std::size_t i = 0; i < coupled.size(); ++i)
    if (symbolic.is_fill(k, static_cast<int>(i))) filled += symbolic.dimension(coupled[i]);
  const std::int64_t unfilled = symbolic.pivot(k).coupled_rows - filled;
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    if (!symbolic.is_fill(k, static_cast<int>(i))) continue;
    const std::int64_t g = symbolic.dimension(coupled[i]);
    const NodeId first = symbolic.node(k), later = symbolic.node(coupled[i]);
    blocks.push_back({.first = first,
                      .later = later,
                      .cause = biconnected.common(first, later),
                      .price = {1, 2 * d * g, g * d * d + d * g * (2 * unfilled + filled)}});
  }
}

/// Fronts of all pivots, then those with fill, most operations first. What a pivot is coupled with, but for its parent, the
/// parent is coupled with too: equal numbers are equal sets.
std::vector<FillFront> find_fronts(const Symbolic& symbolic, const std::vector<FillBlock>& blocks) {
  const int n = symbolic.pivots();
  std::vector<int> child(n, -1), front_of(n, -1);  // the pivot that comes before this one in its front
  for (int k = 0; k < n; ++k)
    if (const int p = symbolic.parent(k); p >= 0 && symbolic.coupled(k).size() == symbolic.coupled(p).size() + 1) child[p] = k;
  std::vector<FillFront> fronts;
  for (int k = 0; k < n; ++k) {
    if (child[k] < 0) {
      front_of[k] = static_cast<int>(fronts.size());
      fronts.push_back({.nodes = {}, .rows = symbolic.dimension(k) + symbolic.pivot(k).coupled_rows, .price = {}});
    } else {
      front_of[k] = front_of[child[k]];
    }
    fronts[front_of[k]].nodes.push_back(symbolic.node(k));
  }
  for (const FillBlock& block : blocks) fronts[front_of[symbolic.position(block.first)]].price += block.price;
  std::erase_if(fronts, [](const FillFront& front) { return front.price.blocks == 0; });
  std::ranges::stable_sort(fronts, std::greater<>(), [](const FillFront& front) { return front.price.operations; });
  return fronts;
}

/// Sorts the causes, most operations first, and drops those without fill; the blocks' indices follow.
void sort_causes(FillAnalysis& analysis) {
  auto& causes = analysis.causes;
  std::vector<int> order(causes.size()), place(causes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return causes[a].price.operations > causes[b].price.operations; });
  std::vector<FillCause> sorted;
  for (const int k : order) {
    place[k] = static_cast<int>(sorted.size());
    if (causes[k].price.blocks > 0) sorted.push_back(std::move(causes[k]));
  }
  causes = std::move(sorted);
  for (FillBlock& block : analysis.blocks) block.cause = place[block.cause];
}

}  // namespace

FillAnalysis analyze_fill(const BlockGraph& graph, const Symbolic& symbolic) {
  check_same_nodes(symbolic, graph, "fill analysis");
  const Biconnected biconnected(graph);
  FillAnalysis result;
  result.counts = symbolic.counts();
  const int order_itself = static_cast<int>(biconnected.parts().size());
  for (const auto& part : biconnected.parts())
    result.causes.push_back({.nodes = part.nodes,
                             .edges = part.edges,
                             .cycles = part.edges - static_cast<int>(part.nodes.size()) + 1,
                             .price = {}});
  result.causes.emplace_back();
  result.blocks.reserve(result.counts.fill_blocks);
  for (int k = 0; k < symbolic.pivots(); ++k) price_pivot(symbolic, k, biconnected, result.blocks);
  for (FillBlock& block : result.blocks) {
    if (block.cause < 0) block.cause = order_itself;
    result.causes[block.cause].price += block.price;
    result.total += block.price;
  }
  result.operations_unfilled = result.counts.operations - result.total.operations;
  sort_causes(result);
  result.fronts = find_fronts(symbolic, result.blocks);
  result.edge = find_edge_saving(graph, symbolic, result.causes);
  return result;
}

}  // namespace graphsolve
