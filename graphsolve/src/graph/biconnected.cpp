#include "graph/biconnected.hpp"

#include <algorithm>

#include "graphsolve/fill_analysis.hpp"

#ifdef GRAPHSOLVE_BOOST
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/biconnected_components.hpp>
#else
#include <stdexcept>
#endif

namespace graphsolve {

#ifdef GRAPHSOLVE_BOOST

bool fill_analysis_available() { return true; }

namespace {

struct NumberedEdge {
  int a, b, part;
};

/// All edges with the number of their biconnected component, sorted by it.
std::vector<NumberedEdge> numbered_edges(const BlockGraph& graph) {
  using Number = boost::property<boost::edge_index_t, std::size_t>;
  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, boost::no_property, Number>;
  Graph g(graph.size());
  std::vector<NumberedEdge> edges;
  for (int i = 0; i < graph.size(); ++i)
    for (const auto& edge : graph.edges({i})) {
      if (edge.to.index < i) continue;
      add_edge(i, edge.to.index, Number(edges.size()), g);
      edges.push_back({i, edge.to.index, -1});
    }
  std::vector<std::size_t> part(edges.size());
  boost::biconnected_components(g, boost::make_iterator_property_map(part.begin(), get(boost::edge_index, g)));
  for (std::size_t k = 0; k < edges.size(); ++k) edges[k].part = static_cast<int>(part[k]);
  std::stable_sort(edges.begin(), edges.end(),
                   [](const NumberedEdge& x, const NumberedEdge& y) { return x.part < y.part; });
  return edges;
}

}  // namespace

Biconnected::Biconnected(const BlockGraph& graph) : begin_(graph.size() + 1, 0) {
  const auto edges = numbered_edges(graph);
  for (auto first = edges.begin(); first != edges.end();) {
    const auto last = std::find_if(first, edges.end(), [&](const NumberedEdge& e) { return e.part != first->part; });
    Part part{.nodes = {}, .edges = static_cast<int>(last - first)};
    for (; first != last; ++first) part.nodes.insert(part.nodes.end(), {NodeId{first->a}, NodeId{first->b}});
    if (part.edges == 1) continue;  // a bridge
    std::sort(part.nodes.begin(), part.nodes.end());
    part.nodes.erase(std::unique(part.nodes.begin(), part.nodes.end()), part.nodes.end());
    parts_.push_back(std::move(part));
  }
  for (const Part& part : parts_)
    for (const NodeId node : part.nodes) ++begin_[node.index + 1];
  for (int i = 0; i < graph.size(); ++i) begin_[i + 1] += begin_[i];
  list_.resize(begin_.back());
  std::vector<int> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t k = 0; k < parts_.size(); ++k)
    for (const NodeId node : parts_[k].nodes) list_[next[node.index]++] = static_cast<int>(k);
}

#else

bool fill_analysis_available() { return false; }

Biconnected::Biconnected(const BlockGraph&) {
  throw std::invalid_argument("fill analysis is not available: this build is without Boost.Graph");
}

#endif

int Biconnected::common(NodeId a, NodeId b) const {
  auto few = parts_of(a), many = parts_of(b);
  if (few.size() > many.size()) std::swap(few, many);
  for (const int part : few)
    if (std::binary_search(many.begin(), many.end(), part)) return part;
  return -1;
}

}  // namespace graphsolve
