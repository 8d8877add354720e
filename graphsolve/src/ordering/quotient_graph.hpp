#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "graphsolve/block_graph.hpp"

namespace graphsolve {

/// What is left of a graph while its nodes are eliminated one after the other. Eliminating a node couples all its
/// neighbours with each other; instead of the new edges the clique is kept as one list, an *element*, and an element
/// that a newer one contains is dropped (quotient graph: George and Liu 1980; Amestoy, Davis and Duff 1996). So memory
/// stays proportional to the graph, however much it fills.
///
/// Each node has a sorted list of its neighbours that no element shows yet, and a list of the elements it is in.
/// Entries that are gone stay as such until they are the majority, so that a hub which loses its neighbours one by
/// one costs O(log) for each.
class QuotientGraph {
 public:
  explicit QuotientGraph(const BlockGraph& graph);

  [[nodiscard]] int size() const { return static_cast<int>(nodes_.size()); }
  [[nodiscard]] bool alive(int node) const { return nodes_[node].alive; }
  [[nodiscard]] int dimension(int node) const { return nodes_[node].dimension; }

  /// Eliminates the node. Returns its neighbours, now coupled with each other; valid until the next call.
  std::span<const int> eliminate(int node);

  /// The neighbours of a node, each once, in no order; stops as soon as there are more than `limit`.
  void neighbours(int node, std::size_t limit, std::vector<int>& out);

  /// Sum of the dimensions of the neighbours: at once where the node is in two elements at most, as in a complete graph.
  [[nodiscard]] std::int64_t rows_around(int node);

  /// Entries of lists that `neighbours` and `rows_around` have looked at: their cost.
  [[nodiscard]] std::int64_t walked() const { return walked_; }

 private:
  struct Node {
    int begin = 0, end = 0;                ///< its part of lists_: elements from the front, variables up to the end
    int elements = 0, elements_gone = 0;   ///< entries, and how many of them are gone
    int variables = 0, variables_gone = 0;
    int dimension = 0;
    bool alive = true;
    std::int64_t sum = 0;                  ///< of the dimensions of the variables that are left
  };
  struct Element {
    std::int64_t begin = 0;
    int size = 0;             ///< 0: gone
    int seen = -1;            ///< last elimination whose clique it was compared with
    std::int64_t weight = 0;  ///< sum of dimensions
    int compared = -1;        ///< the same where every member of that clique was looked at: `outside` is exact then
    std::int64_t outside = 0; ///< of those that are not in that clique
  };

  [[nodiscard]] std::span<const int> elements(const Node& node) const {
    return {lists_.data() + node.begin, static_cast<std::size_t>(node.elements)};
  }
  [[nodiscard]] std::span<int> variables(const Node& node) {
    return {lists_.data() + node.end - node.variables, static_cast<std::size_t>(node.variables)};
  }
  [[nodiscard]] std::span<const int> members(const Element& element) const {
    return {members_.data() + element.begin, static_cast<std::size_t>(element.size)};
  }
  void gather_clique(int node);
  void drop(Element& element);
  void prune(Node& node);
  void remove_variable(Node& node, int other);
  void compact_elements(Node& node);
  void compact_variables(Node& node);
  void store_clique();
  void measure_overlaps();
  [[nodiscard]] std::int64_t walk_rows_around(int node);

  std::vector<Node> nodes_;
  std::vector<int> lists_;  ///< entries of variables that are gone read ~node
  std::vector<Element> elements_;  ///< one per elimination
  std::vector<int> members_;
  std::int64_t members_left_ = 0;  ///< entries of members_ in elements that are not gone
  int eliminated_ = -1;            ///< the node eliminated last
  std::vector<int> clique_;        ///< its neighbours: the newest clique
  std::vector<int> mark_;
  int stamp_ = 0;
  std::vector<int> scratch_;
  std::int64_t walked_ = 0;
};

}  // namespace graphsolve
