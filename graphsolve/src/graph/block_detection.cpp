#include "graphsolve/block_detection.hpp"

#include <algorithm>
#include <stdexcept>

#include "graph/block_pattern.hpp"

namespace graphsolve {

namespace {

/// Rows by hash of their pattern; equal ones next to each other, ascending.
struct Hashed {
  std::uint64_t hash;
  int row;
  friend auto operator<=>(const Hashed&, const Hashed&) = default;
};

/// Steele, Lea, Flood: splitmix64, a bijection that mixes well.
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

enum class Diagonal { included, left_out };

std::uint64_t hash(std::span<const int> pattern, int row, Diagonal diagonal) {
  std::uint64_t sum = mix(pattern.size());
  for (const int i : pattern)
    if (diagonal == Diagonal::included || i != row) sum += mix(static_cast<std::uint64_t>(i));
  return sum;
}

bool equal(const Pattern& pattern, int a, int b, Diagonal diagonal) {
  const auto rows_a = pattern.of(a), rows_b = pattern.of(b);
  if (diagonal == Diagonal::included) return std::ranges::equal(rows_a, rows_b);
  std::size_t i = 0, k = 0;
  while (true) {
    if (i < rows_a.size() && rows_a[i] == a) ++i;
    if (k < rows_b.size() && rows_b[k] == b) ++k;
    if (i == rows_a.size() || k == rows_b.size()) return i == rows_a.size() && k == rows_b.size();
    if (rows_a[i++] != rows_b[k++]) return false;
  }
}

/// Gives every row of `candidates` that has a like the number of the first such row.
void group(const Pattern& pattern, std::span<const int> candidates, Diagonal diagonal, std::vector<int>& first_of) {
  std::vector<Hashed> hashed;
  hashed.reserve(candidates.size());
  for (const int i : candidates) hashed.push_back({hash(pattern.of(i), i, diagonal), i});
  std::ranges::sort(hashed);
  std::vector<int> firsts;  // of the different patterns that share one hash: one, but for accidents
  for (std::size_t begin = 0, end = 0; begin < hashed.size(); begin = end) {
    firsts.clear();
    for (; end < hashed.size() && hashed[end].hash == hashed[begin].hash; ++end) {
      const int i = hashed[end].row;
      const auto like =
          std::ranges::find_if(firsts, [&](int first) { return equal(pattern, first, i, diagonal); });
      if (like == firsts.end()) firsts.push_back(i);
      else first_of[i] = *like;
    }
  }
}

/// Rows by group, in order of the first row; groups beyond the largest size are cut evenly.
std::vector<Block> cut(const std::vector<int>& first_of, int largest) {
  const int n = static_cast<int>(first_of.size());
  std::vector<int> size(static_cast<std::size_t>(n), 0), seen(static_cast<std::size_t>(n), 0), part_block(static_cast<std::size_t>(n), -1);
  for (const int first : first_of) ++size[first];
  std::vector<Block> blocks;
  for (int i = 0; i < n; ++i) {
    const int g = first_of[i];
    const int parts = (size[g] + largest - 1) / largest;
    // Row number s of the group goes to part floor(s parts / size); a part begins where that grows.
    const auto part = [&](std::int64_t s) { return s * parts / size[g]; };
    const int s = seen[g]++;
    if (s == 0 || part(s) != part(s - 1)) {
      part_block[g] = static_cast<int>(blocks.size());
      blocks.emplace_back();
    }
    blocks[part_block[g]].rows.push_back(i);
  }
  for (Block& block : blocks) block.name = name_of_rows(block.rows);
  return blocks;
}

}  // namespace

BlockStructure detect_blocks(const SparseMatrix& matrix, const DetectionSettings& settings) {
  if (settings.largest_block < 1)
    throw std::invalid_argument("the largest block must have at least 1 row, not " +
                                std::to_string(settings.largest_block));
  const Pattern pattern = symmetric_pattern(matrix);
  const int n = pattern.size();
  std::vector<int> first_of(static_cast<std::size_t>(n)), candidates(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) first_of[i] = candidates[i] = i;
  group(pattern, candidates, Diagonal::included, first_of);
  std::vector<char> alone(static_cast<std::size_t>(n), 1);
  for (int i = 0; i < n; ++i)
    if (first_of[i] != i) alone[i] = alone[first_of[i]] = 0;
  candidates.clear();
  for (int i = 0; i < n; ++i)
    if (alone[i] && pattern.diagonal[i] == 0) candidates.push_back(i);
  group(pattern, candidates, Diagonal::left_out, first_of);
  const std::vector<Block> blocks = cut(first_of, settings.largest_block);
  return build_structure(matrix, pattern, blocks, {});
}

std::vector<Block> consecutive_blocks(std::span<const int> sizes) {
  std::vector<Block> blocks;
  int row = 0;
  for (const int size : sizes) {
    if (size < 1)
      throw std::invalid_argument("block " + std::to_string(blocks.size() + 1) + " has " + std::to_string(size) +
                                  " rows; at least 1 is needed");
    Block block;
    for (int i = 0; i < size; ++i) block.rows.push_back(row++);
    block.name = name_of_rows(block.rows);
    blocks.push_back(std::move(block));
  }
  return blocks;
}

BlockStructure make_blocks(const SparseMatrix& matrix, std::span<const Block> blocks,
                           std::span<const BlockCoupling> couplings) {
  const Pattern pattern = symmetric_pattern(matrix);
  const int n = pattern.size();
  std::vector<const Block*> owner(static_cast<std::size_t>(n), nullptr);
  for (const Block& block : blocks) {
    if (block.rows.empty()) throw std::invalid_argument("block '" + block.name + "' has no rows");
    for (const int i : block.rows) {
      if (i < 0 || i >= n)
        throw std::invalid_argument("block '" + block.name + "': row " + std::to_string(std::int64_t{i} + 1) +
                                    " lies outside of 1 .. " + std::to_string(n));
      if (owner[i])
        throw std::invalid_argument("row " + std::to_string(i + 1) + " is in block '" + owner[i]->name +
                                    "' and in block '" + block.name + "'");
      owner[i] = &block;
    }
  }
  for (int i = 0; i < n; ++i)
    if (!owner[i]) throw std::invalid_argument("row " + std::to_string(i + 1) + " is in no block");
  for (const BlockCoupling& c : couplings)
    if (c.a < 0 || c.b < 0 || c.a == c.b || std::max(c.a, c.b) >= static_cast<int>(blocks.size()))
      throw std::invalid_argument("a coupling of blocks " + std::to_string(c.a) + " and " + std::to_string(c.b));
  return build_structure(matrix, pattern, blocks, couplings);
}

}  // namespace graphsolve
