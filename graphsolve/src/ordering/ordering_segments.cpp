#include "ordering/ordering_segments.hpp"

#include <algorithm>
#include <numeric>

#include "graphsolve/simd/lanes.hpp"

namespace graphsolve {

namespace {

constexpr int segments = simd::lanes;
constexpr int shortest = 2;  ///< segment that is worth it

}  // namespace

Segments::Segments(int nodes)
    : waits_(nodes, 0), narrow_(nodes, 0), seen_(nodes, 0), rank_(nodes), path_(nodes, -1), taken_(nodes, 0) {
  std::iota(rank_.begin(), rank_.end(), 0);
}

void Segments::find(std::span<const int> narrow, QuotientGraph& rest) {
  if (static_cast<int>(narrow.size()) < segments * shortest) return;
  for (const int node : narrow) narrow_[node] = !taken_[node];
  for (const int node : narrow) {
    if (!narrow_[node] || seen_[node]) continue;
    seen_[node] = 1;
    along_.assign(1, node);
    neighbours(node, rest);
    const std::vector<int> sides = around_;
    for (const int side : sides) {
      std::reverse(along_.begin(), along_.end());  // the second half goes on from `node`
      walk(node, side, rest);
    }
    // From the end with the smaller number: the order of a path does not depend on where it was found.
    if (along_.back() < along_.front()) std::reverse(along_.begin(), along_.end());
    cut(along_, rest);
  }
  for (const int node : narrow) narrow_[node] = seen_[node] = 0;
}

void Segments::neighbours(int node, QuotientGraph& rest) { rest.neighbours(node, narrow_.size(), around_); }

void Segments::walk(int from, int next, QuotientGraph& rest) {
  while (next >= 0 && narrow_[next] && !seen_[next]) {
    seen_[next] = 1;
    along_.push_back(next);
    neighbours(next, rest);
    int following = -1;
    for (const int i : around_)
      if (i != from) following = i;
    from = next;
    next = following;
  }
}

/// Waiting nodes lie between segments, and at an end that leads nowhere: so every segment lies between two nodes that
/// come later. What is left over waits at the ends.
void Segments::cut(std::span<const int> path, QuotientGraph& rest) {
  const int n = static_cast<int>(path.size());
  const auto free_end = [&](int end, int inner) {
    neighbours(end, rest);
    return std::ranges::none_of(around_, [&](int i) { return i != inner && i != end; });
  };
  if (n < segments * shortest) return;
  const int head = free_end(path[0], path[1]) ? 1 : 0, tail = free_end(path[n - 1], path[n - 2]) ? 1 : 0;
  neighbours(path[0], rest);
  const bool closed = std::ranges::find(around_, path[n - 1]) != around_.end();
  const int least = segments - 1 + (closed ? 1 : head + tail);
  const int length = (n - least) / segments;
  if (length < shortest) return;
  const int over = n - segments * length - least;
  int next = (closed ? 1 : head) + (closed ? over : over / 2);  // of the first segment
  const int number = static_cast<int>(paths_.size()), begin = static_cast<int>(nodes_.size());
  nodes_.insert(nodes_.end(), path.begin(), path.end());
  for (const int node : path) waits_[node] = taken_[node] = 1;
  for (int s = 0; s < segments; ++s, next += length + 1)
    for (int k = next; k < next + length; ++k) {
      waits_[path[k]] = 0;
      path_[path[k]] = number;
    }
  paths_.push_back({begin, begin + n, segments * length});
  sort_ranks(path);
}

void Segments::sort_ranks(std::span<const int> path) {
  ranks_.clear();
  for (const int node : path) ranks_.push_back(rank_[node]);
  std::sort(ranks_.begin(), ranks_.end());
  for (std::size_t k = 0; k < path.size(); ++k) rank_[path[k]] = ranks_[k];
}

void Segments::eliminate(int node) {
  if (path_[node] < 0) return;
  Path& path = paths_[path_[node]];
  if (--path.in_segments == 0) release(path);
}

void Segments::release(const Path& path) {
  for (int k = path.begin; k < path.end; ++k) waits_[nodes_[k]] = 0;
}

void Segments::give_up() {
  for (; given_up_ < paths_.size(); ++given_up_) release(paths_[given_up_]);
}

}  // namespace graphsolve
