#include <algorithm>
#include <stdexcept>
#include <string>

#include "graph/block_pattern.hpp"
#include "graphsolve/factorization.hpp"
#include "simd/program.hpp"

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

void check_sizes(const char* what, std::size_t from, std::size_t to, std::size_t needed_from, std::size_t needed_to) {
  if (from == needed_from && to == needed_to) return;
  throw std::invalid_argument(std::string(what) + ": " + std::to_string(from) + " numbers to " + std::to_string(to) +
                              " places, where " + std::to_string(needed_from) + " to " + std::to_string(needed_to) +
                              " are needed");
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
  check_sizes("to_graph", matrix_rows.size(), graph_rows.size(), row_of.size(), row_of.size());
  for (std::size_t i = 0; i < row_of.size(); ++i) graph_rows[row_of[i]] = matrix_rows[i];
}

void BlockStructure::to_matrix(std::span<const double> graph_rows, std::span<double> matrix_rows) const {
  check_sizes("to_matrix", graph_rows.size(), matrix_rows.size(), row_of.size(), row_of.size());
  for (std::size_t i = 0; i < row_of.size(); ++i) matrix_rows[i] = graph_rows[row_of[i]];
}

std::vector<int> BlockStructure::matrix_rows(NodeId node) const {
  std::vector<int> rows(static_cast<std::size_t>(graph.dimension(node)));
  const int first = graph.row(node), end = first + graph.dimension(node);
  for (std::size_t i = 0; i < row_of.size(); ++i)
    if (row_of[i] >= first && row_of[i] < end) rows[row_of[i] - first] = static_cast<int>(i);
  return rows;
}

EntryMap::EntryMap(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic)
    : EntryMap(matrix, structure, symbolic, FactorizationKind::ldu) {}

EntryMap::EntryMap(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic,
                   FactorizationKind kind)
    : entries_(matrix.row.size()), values_size_(symbolic.values_size()) {
  const BlockGraph& graph = structure.graph;
  if (matrix.rows != graph.rows() || matrix.columns != graph.rows())
    throw std::invalid_argument("a matrix of " + std::to_string(matrix.rows) + " x " + std::to_string(matrix.columns) +
                                " for a graph of " + std::to_string(graph.rows()) + " rows");
  check_columns(matrix);
  std::vector<int> node_of(static_cast<std::size_t>(graph.rows()));
  for (int v = 0; v < graph.size(); ++v)
    std::fill_n(node_of.begin() + graph.row({v}), graph.dimension({v}), v);
  const bool all = kind == FactorizationKind::ldu;
  for (int j = 0; j < matrix.columns; ++j) {
    const int column = structure.row_of[j];
    const NodeId b{node_of[column]};
    NodeId last;
    BlockHandle block;
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      const int row = structure.row_of[matrix.row[k]];
      const NodeId a{node_of[row]};
      if (a != last) block = symbolic.block(a, b);
      last = a;
      if (!all && (a == b ? row < column : symbolic.position(a) < symbolic.position(b))) continue;
      const std::int64_t place = block.place(row - graph.row(a), column - graph.row(b));
      if (!runs_.empty()) {
        Run& run = runs_.back();
        if (run.number + run.count == k && run.stride == block.stride && run.place + run.count * run.stride == place) {
          ++run.count;
          continue;
        }
      }
      runs_.push_back({place, k, 1, block.stride});
    }
  }
  runs_.shrink_to_fit();
  std::ranges::stable_sort(runs_, {}, &Run::place);
  find_gaps(symbolic, kind);
}

void EntryMap::find_gaps(const Symbolic& symbolic, FactorizationKind kind) {
  std::vector<bool> taken(static_cast<std::size_t>(values_size_), false);
  for (const Run& run : runs_)
    for (int i = 0; i < run.count; ++i) taken[run.place + static_cast<std::int64_t>(i) * run.stride] = true;
  for (const auto& group : symbolic.program().groups()) {
    const std::int64_t end = kind == FactorizationKind::ldu ? group.end : group.upper;
    for (std::int64_t place = group.begin; place < end; ++place) {
      if (taken[place]) continue;
      if (!gaps_.empty() && gaps_.back().end == place) ++gaps_.back().end;
      else gaps_.push_back({place, place + 1});
    }
  }
  gaps_.shrink_to_fit();
}

void EntryMap::write(std::span<const double> values, std::span<double> factor_values) const {
  check_sizes("entry map", values.size(), factor_values.size(), entries_, static_cast<std::size_t>(values_size_));
  for (const auto& [begin, end] : gaps_) std::fill(factor_values.begin() + begin, factor_values.begin() + end, 0.0);
  for (const Run& run : runs_) {
    const double* from = values.data() + run.number;
    double* to = factor_values.data() + run.place;
    for (int i = 0; i < run.count; ++i, to += run.stride) *to = from[i];
  }
}

}  // namespace graphsolve
