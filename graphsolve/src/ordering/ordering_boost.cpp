#ifdef GRAPHSOLVE_BOOST

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <boost/graph/minimum_degree_ordering.hpp>
#include <boost/graph/properties.hpp>
#include <boost/graph/sloan_ordering.hpp>

#include <algorithm>

#include "ordering/ordering_packages.hpp"

namespace graphsolve::packages {

namespace {

using Properties = boost::property<boost::vertex_color_t, boost::default_color_type,
                                   boost::property<boost::vertex_degree_t, int,
                                                   boost::property<boost::vertex_priority_t, double>>>;
using Undirected = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, Properties>;
using Directed = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS>;

struct Part {
  std::vector<int> nodes;  ///< of the part, ascending
  Undirected graph;
};

/// The components of two nodes and more as graphs of their own; Sloan's method wants them connected. Single nodes go
/// to `alone`.
std::vector<Part> split(const BlockGraph& graph, std::vector<NodeId>& alone) {
  const Components components = connected_components(graph);
  std::vector<Part> parts(components.count);
  std::vector<int> local(graph.size());
  for (int i = 0; i < graph.size(); ++i) {
    auto& nodes = parts[components.of_node[i]].nodes;
    local[i] = static_cast<int>(nodes.size());
    nodes.push_back(i);
  }
  for (Part& part : parts) {
    if (part.nodes.size() == 1) alone.push_back({part.nodes[0]});
    part.graph = Undirected(part.nodes.size());
    for (const int i : part.nodes)
      for (const auto& edge : graph.edges({i}))
        if (i < edge.to.index) add_edge(local[i], local[edge.to.index], part.graph);
    auto degree = get(boost::vertex_degree, part.graph);
    for (std::size_t v = 0; v < part.nodes.size(); ++v)
      degree[v] = static_cast<int>(out_degree(v, part.graph));
  }
  std::erase_if(parts, [](const Part& part) { return part.nodes.size() == 1; });
  return parts;
}

}  // namespace

std::vector<NodeId> minimum_degree(const BlockGraph& graph) {
  const int n = graph.size();
  // Boost's search for the next degree looks one bucket past the largest degree; a vertex of its own without edges,
  // which comes out first, makes that bucket exist.
  const int padded = n + 1;
  Directed directed(padded);
  for (int i = 0; i < n; ++i)
    for (const auto& edge : graph.edges({i})) add_edge(i, edge.to.index, directed);
  std::vector<int> degree(padded, 0), inverse(padded, 0), order(padded, 0), supernodes(padded, 1);
  const auto index = get(boost::vertex_index, directed);
  boost::minimum_degree_ordering(directed, boost::make_iterator_property_map(degree.begin(), index), inverse.data(),
                                 order.data(), boost::make_iterator_property_map(supernodes.begin(), index), 0,
                                 index);
  std::erase(order, n);
  return to_nodes(order);
}

std::vector<NodeId> reverse_cuthill_mckee(const BlockGraph& graph) {
  std::vector<NodeId> sequence;
  for (Part& part : split(graph, sequence)) {
    std::vector<std::size_t> order(part.nodes.size());
    boost::cuthill_mckee_ordering(part.graph, order.rbegin(), get(boost::vertex_color, part.graph),
                                  get(boost::vertex_degree, part.graph));
    for (const std::size_t v : order) sequence.push_back({part.nodes[v]});
  }
  return sequence;
}

std::vector<NodeId> sloan(const BlockGraph& graph) {
  std::vector<NodeId> sequence;
  for (Part& part : split(graph, sequence)) {
    std::vector<std::size_t> order(part.nodes.size());
    boost::sloan_ordering(part.graph, order.begin(), get(boost::vertex_color, part.graph),
                          get(boost::vertex_degree, part.graph), get(boost::vertex_priority, part.graph));
    for (const std::size_t v : order) sequence.push_back({part.nodes[v]});
  }
  return sequence;
}

}  // namespace graphsolve::packages

#endif
