#include "graphsolve/entry_map.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "graphsolve/factorization.hpp"
#include "graphsolve/overlap.hpp"
#include "simd/program.hpp"
#include "symbolic/same_nodes.hpp"

namespace graphsolve {

namespace {

void check_structure(const BlockStructure& structure, const Symbolic& symbolic) {
  const BlockGraph& graph = structure.graph;
  const int rows = graph.rows();
  if (structure.row_of.size() != static_cast<std::size_t>(rows) ||
      std::ranges::any_of(structure.row_of, [&](int row) { return row < 0 || row >= rows; }))
    throw std::invalid_argument("the rows of the block structure are not those of its graph, which has " + std::to_string(rows));
  check_same_nodes(symbolic, graph, "entry map");
}

}  // namespace

EntryMap::EntryMap(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic)
    : EntryMap(matrix, structure, symbolic, FactorizationKind::ldu) {}

EntryMap::EntryMap(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic,
                   FactorizationKind kind)
    : entries_(matrix.row.size()), values_size_(symbolic.values_size()) {
  const int rows = structure.graph.rows();
  if (matrix.rows != rows || matrix.columns != rows)
    throw std::invalid_argument("a matrix of " + std::to_string(matrix.rows) + " x " + std::to_string(matrix.columns) +
                                " for a graph of " + std::to_string(rows) + " rows");
  check_columns(matrix);
  check_structure(structure, symbolic);
  find_runs(matrix, structure, symbolic, kind == FactorizationKind::ldu);
  find_gaps(symbolic, kind);
  bind_sheaves();
}

void EntryMap::find_runs(const SparseMatrix& matrix, const BlockStructure& structure, const Symbolic& symbolic,
                         bool both_triangles) {
  const BlockGraph& graph = structure.graph;
  std::vector<int> node_of(static_cast<std::size_t>(graph.rows()));
  for (int v = 0; v < graph.size(); ++v)
    std::fill_n(node_of.begin() + graph.row({v}), graph.dimension({v}), v);
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
      if (!both_triangles && (a == b ? row < column : symbolic.position(a) < symbolic.position(b))) continue;
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
  std::ranges::stable_sort(runs_, {}, &Run::place);
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

void EntryMap::bind_sheaves() {
  constexpr std::size_t width = simd::lanes;
  std::size_t kept = 0;
  for (std::size_t r = 0; r < runs_.size();) {
    const Run& first = runs_[r];
    std::size_t alike = 1;
    while (alike < width && r + alike < runs_.size() && first.stride == simd::lanes && runs_[r + alike].stride == first.stride &&
           runs_[r + alike].count == first.count && runs_[r + alike].place == first.place + static_cast<std::int64_t>(alike))
      ++alike;
    if (alike < width) {
      runs_[kept++] = runs_[r++];
      continue;
    }
    Sheaf& sheaf = sheaves_.emplace_back(Sheaf{first.place, first.count, {}});
    for (std::size_t l = 0; l < width; ++l) sheaf.numbers[l] = runs_[r + l].number;
    r += width;
  }
  runs_.resize(kept);
  runs_.shrink_to_fit();
  sheaves_.shrink_to_fit();
}

void EntryMap::write(std::span<const double> values, std::span<double> factor_values) const {
  if (values.size() != entries_ || factor_values.size() != static_cast<std::size_t>(values_size_))
    throw std::invalid_argument("entry map: " + std::to_string(values.size()) + " numbers to " +
                                std::to_string(factor_values.size()) + " places, where " + std::to_string(entries_) +
                                " to " + std::to_string(values_size_) + " are needed");
  check_apart("entry map", values, factor_values);
  for (const auto& [begin, end] : gaps_) std::fill(factor_values.begin() + begin, factor_values.begin() + end, 0.0);
  for (const Run& run : runs_) {
    const double* from = values.data() + run.number;
    double* to = factor_values.data() + run.place;
    for (int i = 0; i < run.count; ++i, to += run.stride) *to = from[i];
  }
  for (const Sheaf& sheaf : sheaves_) {
    std::array<const double*, simd::lanes> from;
    for (int l = 0; l < simd::lanes; ++l) from[l] = values.data() + sheaf.numbers[l];
    double* to = factor_values.data() + sheaf.place;
    for (std::int64_t i = 0; i < sheaf.count; ++i, to += simd::lanes)
      for (int l = 0; l < simd::lanes; ++l) to[l] = from[l][i];
  }
}

}  // namespace graphsolve
