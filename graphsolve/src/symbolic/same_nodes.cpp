#include "symbolic/same_nodes.hpp"

#include <stdexcept>
#include <string>

namespace graphsolve {

void check_same_nodes(const Symbolic& symbolic, const BlockGraph& graph, std::string_view who) {
  const auto fail = [&](const std::string& given, const std::string& planned) {
    throw std::invalid_argument(std::string(who) + ": " + given + ", in the elimination " + planned);
  };
  if (symbolic.pivots() != graph.size() || symbolic.rows() != graph.rows())
    fail("the graph has " + std::to_string(graph.size()) + " nodes of " + std::to_string(graph.rows()) + " rows in all",
         std::to_string(symbolic.pivots()) + " of " + std::to_string(symbolic.rows()));
  for (int k = 0; k < symbolic.pivots(); ++k)
    if (const NodeId node = symbolic.node(k); symbolic.dimension(k) != graph.dimension(node))
      fail("node '" + std::string(graph.name(node)) + "' has " + std::to_string(graph.dimension(node)) + " rows",
           std::to_string(symbolic.dimension(k)));
}

}  // namespace graphsolve
