#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace graphsolve {

/// Handle of a node; valid for the graph that made it.
struct NodeId {
  int index = -1;
  friend auto operator<=>(NodeId, NodeId) = default;
};

/// What is known of a node's own diagonal block; decides when it may be eliminated (ordering.hpp).
enum class NodeKind {
  regular,       ///< positive definite (its symmetric part), and still so when any other regular nodes are eliminated
  semidefinite,  ///< the own block may be zero, such as a variable without cost; one with bounds is `regular`: their
                 ///< ports make it definite
  saddle,        ///< a constraint row: its pivot appears only through its neighbours
  shared,        ///< regular, and the saddle nodes are independent without it: a parameter of many of them, which none
                 ///< has to wait for, so that it may go last
};

/// What is known of the coupling between a saddle node and its neighbour, from the saddle's side.
enum class EdgeRank {
  unknown,
  full_row,     ///< the constraint's rows are independent on this neighbour alone
  full_column,  ///< the neighbour's columns are independent in this constraint alone
  full,         ///< both: square and invertible
};

/// A sparse matrix as a graph: one node per diagonal block, one edge per pair of off-diagonal blocks
/// (structurally symmetric, values free). Knows dimensions and names, no numbers.
class BlockGraph {
 public:
  /// Room for so many nodes, where their number is known before: a graph is kept as long as what is made of it.
  void reserve(int nodes);

  /// Blocks are dense: one of so many rows holds 2 GB, and a larger one is a slip of the pen.
  static constexpr int largest_dimension = 16384;

  /// Throws std::invalid_argument unless 1 <= dimension <= largest_dimension.
  NodeId add_node(std::string name, int dimension, NodeKind kind = NodeKind::regular);

  /// Adding an edge again joins what is known of its rank. Throws std::invalid_argument for a loop or a
  /// foreign node.
  void add_edge(NodeId a, NodeId b, EdgeRank rank = EdgeRank::unknown);

  [[nodiscard]] int size() const { return static_cast<int>(nodes_.size()); }
  [[nodiscard]] int dimension(NodeId node) const { return nodes_[node.index].dimension; }
  [[nodiscard]] NodeKind kind(NodeId node) const { return nodes_[node.index].kind; }
  [[nodiscard]] std::string_view name(NodeId node) const { return nodes_[node.index].name; }
  [[nodiscard]] int rows() const { return rows_; }                             ///< sum of all dimensions
  [[nodiscard]] int row(NodeId node) const { return nodes_[node.index].row; }  ///< first row of the node

  struct Edge {
    NodeId to;
    EdgeRank rank;
  };
  /// Neighbours in the order in which their edges were added.
  [[nodiscard]] std::span<const Edge> edges(NodeId node) const { return adjacency_[node.index]; }

 private:
  struct Node {
    std::string name;
    int dimension;
    int row;
    NodeKind kind;
  };
  std::vector<Node> nodes_;
  std::vector<std::vector<Edge>> adjacency_;
  int rows_ = 0;
};

/// Connected component of every node, numbered from 0 in order of first appearance.
struct Components {
  int count = 0;
  std::vector<int> of_node;
};
Components connected_components(const BlockGraph& graph);

}  // namespace graphsolve
