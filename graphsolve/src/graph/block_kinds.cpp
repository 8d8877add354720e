#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "graph/block_pattern.hpp"

namespace graphsolve {

namespace {

/// What the diagonal of a block looks like.
enum class Own { zero, negative, positive, mixed };

std::vector<Own> classify(const KindInput& input) {
  std::vector<Own> own(input.blocks.size());
  for (std::size_t b = 0; b < own.size(); ++b) {
    int positive = 0, negative = 0;
    bool zero = true;
    for (const int i : input.blocks[b].rows) {
      const double d = input.pattern.diagonal[i];
      positive += d > 0;
      negative += d < 0;
      for (std::int64_t k = input.matrix.begin[i]; k < input.matrix.begin[i + 1]; ++k)
        if (input.block_of[input.matrix.row[k]] == static_cast<int>(b) && input.matrix.value[k] != 0) zero = false;
    }
    const int rows = static_cast<int>(input.blocks[b].rows.size());
    own[b] = zero ? Own::zero : positive == rows ? Own::positive : negative == rows ? Own::negative : Own::mixed;
  }
  return own;
}

/// One connected set of zero blocks, in two colours if that is possible.
struct Coloured {
  std::vector<int> side[2];
  bool two_colours = true;
};

Coloured colour_from(int start, const KindInput& input, const std::vector<Own>& own, std::vector<int>& colour) {
  Coloured result;
  std::vector<int> queue{start};
  colour[start] = 0;
  for (std::size_t at = 0; at < queue.size(); ++at) {
    const int b = queue[at];
    result.side[colour[b]].push_back(b);
    for (const int other : input.neighbours[b]) {
      if (own[other] != Own::zero) continue;
      if (colour[other] < 0) {
        colour[other] = 1 - colour[b];
        queue.push_back(other);
      } else if (colour[other] == colour[b]) {
        result.two_colours = false;
      }
    }
  }
  return result;
}

/// Which colour holds the constraints.
int saddle_side(const Coloured& set, const KindInput& input, const std::vector<Own>& own) {
  bool touches[2] = {false, false};
  std::size_t rows[2] = {0, 0};
  for (const int c : {0, 1}) {
    for (const int b : set.side[c]) {
      rows[c] += input.blocks[b].rows.size();
      for (const int other : input.neighbours[b]) touches[c] = touches[c] || own[other] != Own::zero;
    }
  }
  if (touches[0] != touches[1]) return touches[0] ? 0 : 1;
  // Variables usually come first.
  return rows[0] > rows[1] ? 0 : 1;
}

bool dual_of_quasi_definite(std::size_t b, const KindInput& input, const std::vector<Own>& own) {
  return input.pattern.symmetric && own[b] == Own::negative && !input.neighbours[b].empty() &&
         std::ranges::all_of(input.neighbours[b], [&](int other) { return own[other] == Own::positive; });
}

}  // namespace

std::vector<NodeKind> infer_kinds(const KindInput& input) {
  const std::vector<Own> own = classify(input);
  std::vector<NodeKind> kinds(own.size(), NodeKind::regular);
  std::vector<int> colour(own.size(), -1);
  for (std::size_t b = 0; b < own.size(); ++b) {
    if (dual_of_quasi_definite(b, input, own)) kinds[b] = NodeKind::saddle;
    if (own[b] != Own::zero || colour[b] >= 0) continue;
    const Coloured set = colour_from(static_cast<int>(b), input, own, colour);
    const bool single = set.side[1].empty();
    const int saddle = single ? 0 : saddle_side(set, input, own);
    for (const int c : {0, 1})
      for (const int member : set.side[c])
        kinds[member] = c == saddle || !set.two_colours ? NodeKind::saddle : NodeKind::semidefinite;
  }
  for (std::size_t b = 0; b < own.size(); ++b)
    if (input.blocks[b].kind) kinds[b] = *input.blocks[b].kind;
  return kinds;
}

namespace {

/// Reads dense couplings out of the sparse matrix: block (a, b) and block (b, a) transposed.
class Couplings {
 public:
  explicit Couplings(const KindInput& input) : input_(input), place_(input.block_of.size()) {
    for (const Block& block : input.blocks)
      for (std::size_t r = 0; r < block.rows.size(); ++r) place_[block.rows[r]] = static_cast<int>(r);
  }

  [[nodiscard]] Eigen::MatrixXd block(int a, int b) const {
    const auto &rows = input_.blocks[a].rows, &columns = input_.blocks[b].rows;
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::int64_t begin = input_.matrix.begin[columns[c]], end = input_.matrix.begin[columns[c] + 1];
      // Only the part of a long column that can belong to the block.
      const auto [low, high] = std::ranges::minmax(rows);
      const auto* row = input_.matrix.row.data();
      for (std::int64_t k = std::lower_bound(row + begin, row + end, low) - row; k < end && row[k] <= high; ++k)
        if (input_.block_of[row[k]] == a) dense(place_[row[k]], static_cast<Eigen::Index>(c)) = input_.matrix.value[k];
    }
    return dense;
  }

 private:
  const KindInput& input_;
  std::vector<int> place_;  ///< of a row in its block
};

/// Smallest pivot of the rows of J, or 0 when they are more than its columns.
double row_pivot(const Eigen::MatrixXd& j) {
  if (j.rows() > j.cols()) return 0;
  if (j.rows() == 1) return j.norm();
  return Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(j.transpose()).matrixQR().diagonal().cwiseAbs().minCoeff();
}

/// A coupling counts when it is no weaker than this part of the strongest of the same block. Three digits may be lost,
/// which refinement returns; asking for more leaves costless variables without a host, and then nothing is eligible.
constexpr double weakest_coupling = 1e-3;

}  // namespace

std::vector<BlockCoupling> infer_ranks(const KindInput& input, std::span<const NodeKind> kinds) {
  std::vector<BlockCoupling> ranks;
  const Couplings couplings(input);
  // Pivot of every coupling of a block, as rows that stand in its neighbours' columns; both triangles must be fine.
  const auto add = [&](int b, NodeKind partner_not, EdgeRank rank) {
    std::vector<BlockCoupling> found;
    std::vector<double> pivots;
    double largest = 0;
    for (const int other : input.neighbours[b]) {
      const Eigen::MatrixXd there = couplings.block(b, other), back = couplings.block(other, b).transpose();
      largest = std::max({largest, there.cwiseAbs().maxCoeff(), back.cwiseAbs().maxCoeff()});
      if (kinds[other] == partner_not) continue;
      const double pivot = std::min(row_pivot(there), row_pivot(back));
      found.push_back({b, other, rank});
      pivots.push_back(pivot);
    }
    for (std::size_t k = 0; k < found.size(); ++k)
      if (pivots[k] >= weakest_coupling * largest && pivots[k] > 0) ranks.push_back(found[k]);
  };
  for (int b = 0; b < static_cast<int>(kinds.size()); ++b) {
    if (kinds[b] == NodeKind::saddle) add(b, NodeKind::saddle, EdgeRank::full_row);
    if (kinds[b] == NodeKind::semidefinite) add(b, NodeKind::regular, EdgeRank::full_column);
  }
  return ranks;
}

}  // namespace graphsolve
