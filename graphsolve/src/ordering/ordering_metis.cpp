#ifdef GRAPHSOLVE_METIS

#include <metis.h>

#include <array>
#include <bit>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "ordering/ordering_condensed.hpp"
#include "ordering/ordering_packages.hpp"

namespace graphsolve::packages {

namespace {

/// METIS draws from a random state of the whole process: one thread at a time, or equal graphs get unequal orders.
std::mutex one_at_a_time;

std::array<idx_t, METIS_NOPTIONS> options() {
  std::array<idx_t, METIS_NOPTIONS> result{};
  METIS_SetDefaultOptions(result.data());
  result[METIS_OPTION_SEED] = 1;
  return result;
}

void check(int status) {
  if (status != METIS_OK) throw std::runtime_error("METIS failed with status " + std::to_string(status));
}

#ifdef GRAPHSOLVE_SUITESPARSE

constexpr std::size_t size_of_part = 64;  ///< nodes, about, where nothing is cut any more

/// The graph between some of the nodes. place: room for one number per node, -1 everywhere before and after.
Adjacency between(const Adjacency& graph, const std::vector<int>& nodes, std::vector<int>& place) {
  Adjacency result;
  result.begin.push_back(0);
  for (std::size_t k = 0; k < nodes.size(); ++k) place[nodes[k]] = static_cast<int>(k);
  for (const int i : nodes) {
    for (int e = graph.begin[i]; e < graph.begin[i + 1]; ++e)
      if (place[graph.list[e]] >= 0) result.list.push_back(place[graph.list[e]]);
    result.begin.push_back(static_cast<int>(result.list.size()));
  }
  for (const int i : nodes) place[i] = -1;
  return result;
}

/// Cuts until parts are small. 0 for the nodes of parts; of separators the later the larger what they cut.
std::vector<int> separators(const CondensedGraph& graph) {
  std::vector<int> stage(graph.size(), 0), place(graph.size(), -1), side, weights;
  std::vector<std::vector<int>> parts(1, std::vector<int>(graph.size()));
  std::iota(parts[0].begin(), parts[0].end(), 0);
  auto how = options();
  while (!parts.empty()) {
    const std::vector<int> nodes = std::exchange(parts.back(), {});
    parts.pop_back();
    if (nodes.size() <= size_of_part) continue;
    Adjacency some = between(graph.adjacency(), nodes, place);
    if (some.list.empty()) continue;
    weights.clear();
    for (const int i : nodes) weights.push_back(graph.weights()[i]);
    side.assign(nodes.size(), 0);
    idx_t n = static_cast<idx_t>(nodes.size()), size = 0;
    check(METIS_ComputeVertexSeparator(&n, some.begin.data(), some.list.data(), weights.data(), how.data(), &size, side.data()));
    std::array<std::vector<int>, 3> cut;  // two parts, and what is between them
    for (std::size_t k = 0; k < nodes.size(); ++k) cut[side[k]].push_back(nodes[k]);
    if (cut[0].empty() || cut[1].empty()) continue;
    for (const int i : cut[2]) stage[i] = static_cast<int>(std::bit_width(nodes.size()));
    parts.push_back(std::move(cut[0]));
    parts.push_back(std::move(cut[1]));
  }
  return stage;
}

/// Minimum degree inside the parts, then in the separators of one stage after the other: less fill than by METIS alone, whose
/// order within them is not of its best.
std::vector<int> dissect(const CondensedGraph& graph) {
  std::vector<int> stage;
  {
    const std::lock_guard lock(one_at_a_time);
    stage = separators(graph);
  }
  return camd(graph.adjacency(), stage);
}

#else

std::vector<int> dissect(const CondensedGraph& graph) {
  Adjacency a = graph.adjacency();
  std::vector<int> order(graph.size()), inverse(graph.size()), weights = graph.weights();
  auto how = options();
  idx_t n = graph.size();
  const std::lock_guard lock(one_at_a_time);
  check(METIS_NodeND(&n, a.begin.data(), a.list.data(), weights.data(), how.data(), order.data(), inverse.data()));
  return order;
}

#endif

}  // namespace

std::vector<NodeId> nested_dissection(const BlockGraph& graph) {
  const CondensedGraph left(graph);
  std::vector<int> order(left.size());
  std::iota(order.begin(), order.end(), 0);
  if (!left.adjacency().list.empty()) order = dissect(left);
  return left.expand(order);
}

}  // namespace graphsolve::packages

#endif
