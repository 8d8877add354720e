#include <algorithm>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>

#include "graphsolve/ordering.hpp"
#include "ordering/counted_ordering.hpp"
#include "ordering/ordering_held.hpp"
#include "ordering/sorted_runs.hpp"

namespace graphsolve {

namespace {

constexpr int exact_degree = 12;                              ///< above this the score is an upper bound
constexpr std::int64_t against_rule = std::int64_t{1} << 60;  ///< added to the score of an ineligible node

/// Sum over the pairs of a set of d_i d_j, from the sum and the sum of squares of the d_i.
std::int64_t pairs(std::int64_t sum, std::int64_t squares) { return (sum * sum - squares) / 2; }

/// Elimination graph with explicit neighbour lists. An entry of the queue counts only while it shows its node's present
/// score; lists keep eliminated nodes until these are the majority and take new ones in runs, so that a hub which
/// loses or gains its neighbours one by one costs O(log) for each.
class MinimumFill {
 public:
  explicit MinimumFill(const BlockGraph& graph)
      : graph_(graph), rule_(graph), nodes_(graph.size()), around_mark_(graph.size(), 0), seen_mark_(graph.size(), 0) {
    for (int i = 0; i < graph.size(); ++i) {
      scratch_.clear();
      for (const auto& edge : graph.edges({i})) scratch_.push_back(edge.to.index);
      std::sort(scratch_.begin(), scratch_.end());
      couple(i, scratch_);
    }
  }

  [[nodiscard]] std::int64_t walked() const { return walked_; }

  Ordering run() {
    Ordering result{.method = OrderingMethod::minimum_fill};
    const int n = graph_.size();
    result.sequence.reserve(n);
    for (int i = 0; i < n; ++i) update(i);
    while (static_cast<int>(result.sequence.size()) < n) {
      int node = next();
      if (node < 0) {  // from now on the queue also holds ineligible nodes, behind all others
        deadlocked_ = true;
        clique_sum_ = clique_squares_ = 0;
        for (int i = 0; i < n; ++i) update(i);
        node = next();
      }
      result.forced += !rule_.eligible({node});
      eliminate(node);
      result.sequence.push_back({node});
    }
    return result;
  }

 private:
  struct Node {
    SortedRuns list;  ///< neighbours; some may be gone
    int gone = 0;     ///< how many of them are
    bool alive = true;
    std::int64_t sum = 0, squares = 0;  ///< of the dimensions of the neighbours that are left
    std::int64_t score = -1;            ///< -1: not in the queue
    std::int64_t born = 0;              ///< when it became free
    [[nodiscard]] int degree() const { return static_cast<int>(list.size()) - gone; }
    [[nodiscard]] bool sees(int other) const { return list.contains(other); }
  };
  struct Entry {
    std::int64_t score, born;
    int node;
    bool operator>(const Entry& other) const { return score != other.score ? score > other.score : born > other.born; }
  };

  [[nodiscard]] std::int64_t dimension(int node) const { return graph_.dimension({node}); }
  [[nodiscard]] bool candidate(int node) const { return nodes_[node].alive && (deadlocked_ || rule_.eligible({node})); }

  /// others: ascending, none of them coupled with the node.
  void couple(int node, const std::vector<int>& others) {
    walked_ += static_cast<std::int64_t>(nodes_[node].list.add(others, merged_));
    for (const int other : others) {
      nodes_[node].sum += dimension(other);
      nodes_[node].squares += dimension(other) * dimension(other);
    }
  }

  int next() {
    while (!queue_.empty()) {
      const Entry entry = queue_.top();
      queue_.pop();
      const Node& node = nodes_[entry.node];
      if (node.alive && entry.score == node.score && entry.born == node.born) return entry.node;
    }
    return -1;
  }

  void enqueue(int index, std::int64_t score) {
    Node& node = nodes_[index];
    if (score == node.score) return;
    if (node.born == 0) node.born = ++clock_;
    node.score = score;
    queue_.push({score, node.born, index});
  }

  /// Scores the node afresh if it may be eliminated.
  void update(int node) {
    if (candidate(node)) enqueue(node, fill(node) + (rule_.eligible({node}) ? 0 : against_rule));
  }

  /// Scalars of one triangle that elimination of the node adds. Of the pairs around a node of large degree only
  /// those inside the newest clique are known to be coupled already.
  [[nodiscard]] std::int64_t fill(int index) {
    const Node& node = nodes_[index];
    if (node.degree() > exact_degree) {
      const std::int64_t d = clique_sum_ > 0 ? dimension(index) : 0;
      return pairs(node.sum, node.squares) - pairs(clique_sum_ - d, clique_squares_ - d * d);
    }
    find_alive(node, scratch_);
    std::int64_t result = 0;
    walked_ += static_cast<std::int64_t>(scratch_.size() * scratch_.size());
    for (std::size_t a = 0; a < scratch_.size(); ++a)
      for (std::size_t b = a + 1; b < scratch_.size(); ++b)
        if (!nodes_[scratch_[a]].sees(scratch_[b])) result += dimension(scratch_[a]) * dimension(scratch_[b]);
    return result;
  }

  void find_alive(const Node& node, std::vector<int>& out) {
    out.clear();
    walked_ += static_cast<std::int64_t>(node.list.size());
    for (const int i : node.list.entries())
      if (nodes_[i].alive) out.push_back(i);
  }

  void eliminate(int index) {
    Node& node = nodes_[index];
    node.alive = false;
    find_alive(node, around_);
    std::sort(around_.begin(), around_.end());
    node.list.clear();
    clique_sum_ = node.sum;
    clique_squares_ = node.squares;
    filled_.clear();
    ++around_stamp_;
    for (const int i : around_) {
      around_mark_[i] = around_stamp_;
      forget(i, index);
    }
    // A score of 0 is exact, whatever the degree: the neighbours see each other already.
    if (node.score % against_rule != 0)
      for (const int i : around_) join(i);
    freed_.clear();
    rule_.eliminate({index}, freed_);
    for (const NodeId i : freed_) nodes_[i.index].born = ++clock_;
    for (const int i : around_) update(i);  // the freed nodes are among them
    relieve();
  }

  void forget(int index, int eliminated) {
    Node& node = nodes_[index];
    node.sum -= dimension(eliminated);
    node.squares -= dimension(eliminated) * dimension(eliminated);
    if (2 * ++node.gone <= static_cast<int>(node.list.size())) return;
    walked_ += static_cast<std::int64_t>(node.list.size());
    node.list.erase_if([&](int i) { return !nodes_[i].alive; });
    node.gone = 0;
  }

  /// Couples node i with those of around_ that it does not see yet.
  void join(int i) {
    const SortedRuns& list = nodes_[i].list;
    scratch_.clear();
    walked_ += static_cast<std::int64_t>(std::min(list.size(), 16 * around_.size()));
    if (list.size() > 16 * around_.size()) {
      for (const int k : around_)
        if (k != i && !nodes_[i].sees(k)) scratch_.push_back(k);
    } else {
      ++seen_stamp_;
      std::size_t seen = 1;  // itself
      for (const int k : list.entries()) {
        if (around_mark_[k] != around_stamp_) continue;
        seen_mark_[k] = seen_stamp_;
        ++seen;
      }
      if (seen == around_.size()) return;
      for (const int k : around_)
        if (k != i && seen_mark_[k] != seen_stamp_) scratch_.push_back(k);
    }
    if (scratch_.empty()) return;
    couple(i, scratch_);
    for (const int k : scratch_)
      if (i < k) filled_.push_back({i, k});
  }

  /// The nodes outside the clique that see both ends of a new coupling have one pair less to fill. Couplings of one
  /// node stand together: its list is looked through once for all, unless it is longer than those of the other ends.
  void relieve() {
    for (std::size_t begin = 0, end = 0; begin < filled_.size(); begin = end) {
      const int i = filled_[begin].first;
      std::size_t others = 0;
      for (; end < filled_.size() && filled_[end].first == i; ++end) others += nodes_[filled_[end].second].list.size();
      const bool at_once = nodes_[i].list.size() <= others;
      if (at_once) find_exact_outside(i);
      for (std::size_t k = begin; k < end; ++k) {
        const int j = filled_[k].second;
        if (!at_once) find_exact_outside(j);
        relieve(i, j, at_once ? j : i);
      }
    }
  }

  /// Of the nodes of scratch_ those that see the end `other`.
  void relieve(int i, int j, int other) {
    walked_ += static_cast<std::int64_t>(scratch_.size());
    for (const int k : scratch_)
      if (nodes_[k].sees(other)) enqueue(k, nodes_[k].score - dimension(i) * dimension(j));
  }

  /// scratch_ := neighbours of i outside the newest clique whose score is exact.
  void find_exact_outside(int i) {
    scratch_.clear();
    walked_ += static_cast<std::int64_t>(nodes_[i].list.size());
    for (const int k : nodes_[i].list.entries()) {
      const Node& node = nodes_[k];
      if (node.score < 0 || !node.alive || node.degree() > exact_degree) continue;
      if (around_mark_[k] != around_stamp_) scratch_.push_back(k);
    }
  }

  const BlockGraph& graph_;
  Eligibility rule_;
  std::vector<Node> nodes_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
  std::vector<int> around_;  ///< neighbours of the node just eliminated: the newest clique
  std::int64_t clique_sum_ = 0, clique_squares_ = 0;
  std::vector<int> around_mark_, seen_mark_;  ///< the stamp: a node of around_; of those one that is seen already
  int around_stamp_ = 0, seen_stamp_ = 0;
  std::vector<std::pair<int, int>> filled_;  ///< couplings that its elimination added
  std::vector<int> scratch_, merged_;
  std::vector<NodeId> freed_;
  std::int64_t clock_ = 0, walked_ = 0;
  bool deadlocked_ = false;  ///< has there been a moment with no eligible node?
};

}  // namespace

CountedOrdering counted_minimum_fill_ordering(const BlockGraph& graph) {
  MinimumFill search(graph);
  CountedOrdering result{search.run()};
  result.walked = search.walked();
  hold_networks_early(graph, result.ordering);
  return result;
}

Ordering minimum_fill_ordering(const BlockGraph& graph) { return counted_minimum_fill_ordering(graph).ordering; }

}  // namespace graphsolve
