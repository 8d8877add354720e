#include <algorithm>
#include <stdexcept>
#include <string>

#include "graph/block_pattern.hpp"
#include "graphsolve/overlap.hpp"

namespace graphsolve {

namespace {

/// Blocks that a block is coupled with in the pattern, ascending.
std::vector<std::vector<int>> find_neighbours(const Pattern& pattern, std::span<const Block> blocks,
                                              std::span<const int> block_of) {
  std::vector<std::vector<int>> neighbours(blocks.size());
  std::vector<int> seen_by(blocks.size(), -1);
  for (int b = 0; b < static_cast<int>(blocks.size()); ++b) {
    seen_by[b] = b;
    for (const int i : blocks[b].rows) {
      for (const int j : pattern.of(i)) {
        const int other = block_of[j];
        if (seen_by[other] == b) continue;
        seen_by[other] = b;
        neighbours[b].push_back(other);
      }
    }
    std::ranges::sort(neighbours[b]);
  }
  return neighbours;
}

void check_rows(const char* what, std::span<const double> from, std::span<const double> to, std::size_t rows) {
  if (from.size() == rows && to.size() == rows) return check_apart(what, from, to);
  throw std::invalid_argument(std::string(what) + ": " + std::to_string(from.size()) + " numbers to " +
                              std::to_string(to.size()) + " places, where " + std::to_string(rows) + " to " +
                              std::to_string(rows) + " are needed");
}

}  // namespace

BlockStructure build_structure(const SparseMatrix& matrix, const Pattern& pattern, std::span<const Block> blocks,
                               std::span<const BlockCoupling> couplings) {
  BlockStructure structure;
  structure.added_entries = pattern.added_entries;
  structure.symmetric = pattern.symmetric;
  structure.row_of.assign(static_cast<std::size_t>(pattern.size()), -1);
  std::vector<int> block_of(static_cast<std::size_t>(pattern.size()));
  int row = 0;
  for (int b = 0; b < static_cast<int>(blocks.size()); ++b) {
    for (const int i : blocks[b].rows) {
      block_of[i] = b;
      structure.row_of[i] = row++;
    }
  }
  const std::vector<std::vector<int>> neighbours = find_neighbours(pattern, blocks, block_of);
  const KindInput input{blocks, pattern, matrix, neighbours, block_of};
  std::vector<NodeKind> kinds = infer_kinds(input);
  infer_shared(input, kinds);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    structure.graph.add_node(blocks[b].name, static_cast<int>(blocks[b].rows.size()), kinds[b]);
  for (int b = 0; b < static_cast<int>(blocks.size()); ++b)
    for (const int other : neighbours[b])
      if (b < other) structure.graph.add_edge({b}, {other});
  for (const BlockCoupling& c : infer_ranks(input, kinds)) structure.graph.add_edge({c.a}, {c.b}, c.rank);
  for (const BlockCoupling& c : couplings) structure.graph.add_edge({c.a}, {c.b}, c.rank);
  return structure;
}

void BlockStructure::to_graph(std::span<const double> matrix_rows, std::span<double> graph_rows) const {
  check_rows("to_graph", matrix_rows, graph_rows, row_of.size());
  for (std::size_t i = 0; i < row_of.size(); ++i) graph_rows[row_of[i]] = matrix_rows[i];
}

void BlockStructure::to_matrix(std::span<const double> graph_rows, std::span<double> matrix_rows) const {
  check_rows("to_matrix", graph_rows, matrix_rows, row_of.size());
  for (std::size_t i = 0; i < row_of.size(); ++i) matrix_rows[i] = graph_rows[row_of[i]];
}

std::vector<int> BlockStructure::matrix_rows(NodeId node) const {
  std::vector<int> rows(static_cast<std::size_t>(graph.dimension(node)));
  const int first = graph.row(node), end = first + graph.dimension(node);
  for (std::size_t i = 0; i < row_of.size(); ++i)
    if (row_of[i] >= first && row_of[i] < end) rows[row_of[i] - first] = static_cast<int>(i);
  return rows;
}

}  // namespace graphsolve
