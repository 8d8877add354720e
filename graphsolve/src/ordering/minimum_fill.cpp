#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <queue>
#include <utility>

#include "graphsolve/ordering.hpp"
#include "ordering/ordering_held.hpp"

namespace graphsolve {

namespace {

constexpr int exact_degree = 12;                              ///< above this the score is an upper bound
constexpr std::int64_t against_rule = std::int64_t{1} << 60;  ///< added to the score of an ineligible node

/// Sum over the pairs of a set of d_i d_j, from the sum and the sum of squares of the d_i.
std::int64_t pairs(std::int64_t sum, std::int64_t squares) { return (sum * sum - squares) / 2; }

/// Elimination graph with explicit, sorted neighbour lists. An entry of the queue counts only while it shows its
/// node's present score; lists keep eliminated nodes until these are the majority, so that a hub which loses its
/// neighbours one by one costs O(1) for each.
class MinimumFill {
 public:
  explicit MinimumFill(const BlockGraph& graph)
      : graph_(graph), rule_(graph), nodes_(graph.size()), around_mark_(graph.size(), 0), seen_mark_(graph.size(), 0) {
    for (int i = 0; i < graph.size(); ++i) {
      for (const auto& edge : graph.edges({i})) couple(i, edge.to.index);
      std::sort(nodes_[i].list.begin(), nodes_[i].list.end());
    }
  }

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
    std::vector<int> list;  ///< neighbours, sorted; some may be gone
    int gone = 0;           ///< how many of them are
    bool alive = true;
    std::int64_t sum = 0, squares = 0;  ///< of the dimensions of the neighbours that are left
    std::int64_t score = -1;            ///< -1: not in the queue
    std::int64_t born = 0;              ///< when it became free
    [[nodiscard]] int degree() const { return static_cast<int>(list.size()) - gone; }
    [[nodiscard]] bool sees(int other) const { return std::binary_search(list.begin(), list.end(), other); }
  };
  struct Entry {
    std::int64_t score, born;
    int node;
    bool operator>(const Entry& other) const { return score != other.score ? score > other.score : born > other.born; }
  };

  [[nodiscard]] std::int64_t dimension(int node) const { return graph_.dimension({node}); }
  [[nodiscard]] bool candidate(int node) const { return nodes_[node].alive && (deadlocked_ || rule_.eligible({node})); }

  void couple(int node, int other) {
    nodes_[node].list.push_back(other);
    nodes_[node].sum += dimension(other);
    nodes_[node].squares += dimension(other) * dimension(other);
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
    scratch_.clear();
    for (const int i : node.list)
      if (nodes_[i].alive) scratch_.push_back(i);
    std::int64_t result = 0;
    for (std::size_t a = 0; a < scratch_.size(); ++a)
      for (std::size_t b = a + 1; b < scratch_.size(); ++b)
        if (!nodes_[scratch_[a]].sees(scratch_[b])) result += dimension(scratch_[a]) * dimension(scratch_[b]);
    return result;
  }

  void eliminate(int index) {
    Node& node = nodes_[index];
    node.alive = false;
    around_.clear();
    for (const int i : node.list)
      if (nodes_[i].alive) around_.push_back(i);
    std::vector<int>().swap(node.list);
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
    std::erase_if(node.list, [&](int i) { return !nodes_[i].alive; });
    node.gone = 0;
  }

  /// Couples node i with those of around_ that it does not see yet.
  void join(int i) {
    auto& list = nodes_[i].list;
    scratch_.clear();
    if (list.size() > 16 * around_.size()) {
      for (const int k : around_)
        if (k != i && !nodes_[i].sees(k)) scratch_.push_back(k);
    } else {
      ++seen_stamp_;
      std::size_t seen = 1;  // itself
      for (const int k : list) {
        if (around_mark_[k] != around_stamp_) continue;
        seen_mark_[k] = seen_stamp_;
        ++seen;
      }
      if (seen == around_.size()) return;
      for (const int k : around_)
        if (k != i && seen_mark_[k] != seen_stamp_) scratch_.push_back(k);
    }
    if (scratch_.empty()) return;
    const auto old_size = static_cast<std::ptrdiff_t>(list.size());
    for (const int k : scratch_) {
      couple(i, k);
      if (i < k) filled_.push_back({i, k});
    }
    merged_.clear();
    std::merge(list.begin(), list.begin() + old_size, list.begin() + old_size, list.end(), std::back_inserter(merged_));
    list.assign(merged_.begin(), merged_.end());
  }

  /// The nodes outside the clique that see both ends of a new coupling have one pair less to fill.
  void relieve() {
    int scanned = -1;
    for (const auto& [i, j] : filled_) {
      if (i != scanned) {  // couplings of one node stand together: scan its list once
        scanned = i;
        find_exact_outside(i);
      }
      for (const int k : scratch_)
        if (nodes_[k].sees(j)) enqueue(k, nodes_[k].score - dimension(i) * dimension(j));
    }
  }

  /// scratch_ := neighbours of i outside the newest clique whose score is exact.
  void find_exact_outside(int i) {
    scratch_.clear();
    for (const int k : nodes_[i].list) {
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
  std::int64_t clock_ = 0;
  bool deadlocked_ = false;  ///< has there been a moment with no eligible node?
};

}  // namespace

Ordering minimum_fill_ordering(const BlockGraph& graph) {
  Ordering result = MinimumFill(graph).run();
  hold_networks_early(graph, result);
  return result;
}

}  // namespace graphsolve
