#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <queue>

#include "graphsolve/ordering.hpp"

namespace graphsolve {

namespace {

constexpr int exact_degree = 12;  ///< above this the score is an upper bound

/// Elimination graph with explicit, sorted neighbour lists. Scores are kept up to date lazily: an entry of the
/// queue counts only while it carries its node's present stamp.
class MinimumFill {
 public:
  explicit MinimumFill(const BlockGraph& graph) : graph_(graph), rule_(graph), neighbours_(graph.size()),
        stamp_(graph.size(), 0), born_(graph.size(), 0), alive_(graph.size(), 1) {
    for (int i = 0; i < graph.size(); ++i) {
      for (const auto& edge : graph.edges({i})) neighbours_[i].push_back(edge.to.index);
      std::sort(neighbours_[i].begin(), neighbours_[i].end());
    }
  }

  Ordering run() {
    Ordering result;
    const int n = graph_.size();
    result.sequence.reserve(n);
    for (int i = 0; i < n; ++i)
      if (rule_.eligible({i})) enter(i);
    int lost = 0;  // where to look for a node when nothing is eligible
    while (static_cast<int>(result.sequence.size()) < n) {
      int node = next();
      if (node < 0) {
        while (!alive_[lost]) ++lost;
        node = lost;
        ++result.forced;
      }
      eliminate(node);
      result.sequence.push_back({node});
    }
    return result;
  }

 private:
  struct Entry {
    std::int64_t score;
    std::int64_t born;
    int node, stamp;
    bool operator>(const Entry& other) const {
      return score != other.score ? score > other.score : born > other.born;
    }
  };

  void enter(int node) {
    born_[node] = ++clock_;
    queue_.push({score(node), born_[node], node, stamp_[node]});
  }
  int next() {
    while (!queue_.empty()) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (alive_[entry.node] && entry.stamp == stamp_[entry.node]) return entry.node;
    }
    return -1;
  }

  /// Scalars of one triangle that elimination of the node adds.
  [[nodiscard]] std::int64_t score(int node) const {
    const auto& around = neighbours_[node];
    std::int64_t fill = 0;
    if (static_cast<int>(around.size()) > exact_degree) {
      std::int64_t sum = 0, squares = 0;
      for (const int i : around) {
        const std::int64_t d = graph_.dimension({i});
        sum += d;
        squares += d * d;
      }
      return (sum * sum - squares) / 2;
    }
    for (std::size_t a = 0; a < around.size(); ++a)
      for (std::size_t b = a + 1; b < around.size(); ++b)
        if (!std::binary_search(neighbours_[around[a]].begin(), neighbours_[around[a]].end(), around[b]))
          fill += std::int64_t{1} * graph_.dimension({around[a]}) * graph_.dimension({around[b]});
    return fill;
  }

  void eliminate(int node) {
    alive_[node] = 0;
    const std::vector<int> around = std::move(neighbours_[node]);
    neighbours_[node].clear();
    bool filled = false;
    for (const int i : around) {
      auto& list = neighbours_[i];
      list.erase(std::lower_bound(list.begin(), list.end(), node));
      if (around.size() < 2) continue;
      merged_.clear();
      std::set_union(list.begin(), list.end(), around.begin(), around.end(), std::back_inserter(merged_));
      merged_.erase(std::lower_bound(merged_.begin(), merged_.end(), i));
      filled = filled || merged_.size() > list.size();
      list.assign(merged_.begin(), merged_.end());
    }
    freed_.clear();
    rule_.eliminate({node}, freed_);
    for (const NodeId i : freed_) enter(i.index);
    for (const int i : around) rescore(i);
    if (!filled) return;
    // Fill between two neighbours also changes the score of those that see both.
    for (const int i : around)
      if (static_cast<int>(neighbours_[i].size()) <= exact_degree)
        for (const int k : neighbours_[i]) rescore(k);
  }

  void rescore(int node) {
    if (!rule_.eligible({node}) || !alive_[node] || born_[node] == 0) return;
    ++stamp_[node];
    queue_.push({score(node), born_[node], node, stamp_[node]});
  }

  const BlockGraph& graph_;
  Eligibility rule_;
  std::vector<std::vector<int>> neighbours_;
  std::vector<int> stamp_;
  std::vector<std::int64_t> born_;
  std::vector<char> alive_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
  std::vector<int> merged_;
  std::vector<NodeId> freed_;
  std::int64_t clock_ = 0;
};

}  // namespace

Ordering minimum_fill_ordering(const BlockGraph& graph) { return MinimumFill(graph).run(); }

}  // namespace graphsolve
