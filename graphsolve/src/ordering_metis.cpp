#ifdef GRAPHSOLVE_METIS

#include <metis.h>

#include <mutex>
#include <stdexcept>
#include <string>

#include "ordering_packages.hpp"

namespace graphsolve::packages {

std::vector<NodeId> nested_dissection(const BlockGraph& graph) {
  Adjacency a = adjacency(graph);
  std::vector<int> order(graph.size()), inverse(graph.size()), weights(graph.size());
  for (int i = 0; i < graph.size(); ++i) weights[i] = graph.dimension({i});
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  idx_t n = graph.size();
  // METIS draws from a random state of the whole process: one thread at a time, or equal graphs get unequal orders.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const int status =
      METIS_NodeND(&n, a.begin.data(), a.list.data(), weights.data(), options, order.data(), inverse.data());
  if (status != METIS_OK) throw std::runtime_error("METIS failed with status " + std::to_string(status));
  return to_nodes(order);
}

}  // namespace graphsolve::packages

#endif
