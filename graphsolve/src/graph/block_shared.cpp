#include <algorithm>
#include <cmath>

#include "graph/block_pattern.hpp"
#include "graph/structural_rank.hpp"

namespace graphsolve {

namespace {

constexpr double weakest_entry = 1e-3;  ///< an entry counts from this part of the largest of its row on

constexpr int many_constraints = 16;

/// Regular blocks with many constraints and very many neighbours, as AMD tells dense rows; what the user has said stands.
std::vector<int> find_hubs(const KindInput& input, std::span<const NodeKind> kinds) {
  std::vector<int> hubs;
  const double many = std::max<double>(many_constraints, 10 * std::sqrt(static_cast<double>(kinds.size())));
  for (std::size_t b = 0; b < kinds.size(); ++b) {
    if (kinds[b] != NodeKind::regular || input.blocks[b].kind) continue;
    if (static_cast<double>(input.neighbours[b].size()) <= many) continue;
    const auto constraints =
        std::ranges::count_if(input.neighbours[b], [&](int other) { return kinds[other] == NodeKind::saddle; });
    if (constraints > many_constraints) hubs.push_back(static_cast<int>(b));
  }
  return hubs;
}

/// A column per saddle row: where it stands in blocks that are neither constraints nor hubs. The matrix holds it in
/// its columns; symmetric or not, the other triangle has the same structure but for zeros.
Eigen::SparseMatrix<double> constraints_without(const KindInput& input, std::span<const NodeKind> kinds,
                                                std::span<const int> hubs) {
  std::vector<Eigen::Triplet<double>> entries;
  int column = 0;
  for (std::size_t b = 0; b < kinds.size(); ++b) {
    if (kinds[b] != NodeKind::saddle) continue;
    for (const int j : input.blocks[b].rows) {
      const auto begin = input.matrix.begin[j], end = input.matrix.begin[j + 1];
      double largest = 0;
      for (auto k = begin; k < end; ++k)
        if (input.matrix.row[k] != j) largest = std::max(largest, std::abs(input.matrix.value[k]));
      for (auto k = begin; k < end; ++k) {
        const int i = input.matrix.row[k], other = input.block_of[i];
        if (kinds[other] == NodeKind::saddle || std::ranges::binary_search(hubs, other)) continue;
        const double size = std::abs(input.matrix.value[k]);
        if (size > 0 && size >= weakest_entry * largest) entries.emplace_back(i, column, 1.0);
      }
      ++column;
    }
  }
  Eigen::SparseMatrix<double> result(input.pattern.size(), column);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace

void infer_shared(const KindInput& input, std::span<NodeKind> kinds) {
  const std::vector<int> hubs = find_hubs(input, kinds);
  if (hubs.empty() || !has_full_column_rank(constraints_without(input, kinds, hubs))) return;
  for (const int b : hubs) kinds[b] = NodeKind::shared;
}

}  // namespace graphsolve
