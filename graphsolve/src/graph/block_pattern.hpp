#pragma once

#include <span>
#include <string>
#include <vector>

#include "graphsolve/block_detection.hpp"

namespace graphsolve {

/// The pattern of A + A^T + I, by columns (or rows: it is symmetric), ascending.
struct Pattern {
  std::vector<std::int64_t> begin{0};
  std::vector<int> row;
  std::vector<double> diagonal;    ///< values of A's diagonal
  std::int64_t added_entries = 0;  ///< off the diagonal, that A had not
  bool symmetric = true;           ///< A is, pattern and values

  [[nodiscard]] int size() const { return static_cast<int>(begin.size()) - 1; }
  [[nodiscard]] std::span<const int> of(int i) const { return {row.data() + begin[i], row.data() + begin[i + 1]}; }
};

/// Throws std::invalid_argument when the matrix is not square, is empty, or holds a value that is not finite.
Pattern symmetric_pattern(const SparseMatrix& matrix);

/// Graph, kinds and ranks from blocks that cover every row once.
BlockStructure build_structure(const SparseMatrix& matrix, const Pattern& pattern, std::span<const Block> blocks,
                               std::span<const BlockCoupling> couplings);

/// What kinds and ranks are read from.
struct KindInput {
  std::span<const Block> blocks;
  const Pattern& pattern;
  const SparseMatrix& matrix;
  std::span<const std::vector<int>> neighbours;  ///< per block, ascending
  std::span<const int> block_of;                 ///< per row
};
/// Kind of every block, by the rule of block_detection.hpp; what the user has said stands.
std::vector<NodeKind> infer_kinds(const KindInput& input);

/// Makes those regular blocks shared that the rule of block_detection.hpp calls so.
void infer_shared(const KindInput& input, std::span<NodeKind> kinds);

/// Couplings of full rank, by the rule of block_detection.hpp.
std::vector<BlockCoupling> infer_ranks(const KindInput& input, std::span<const NodeKind> kinds);

/// "row 7", "rows 4-9", "rows 1-2, 5 and 12 more"; rows from 0, counted from 1 in the name.
std::string name_of_rows(std::span<const int> rows);

}  // namespace graphsolve
