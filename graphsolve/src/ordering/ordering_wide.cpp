#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <span>
#include <tuple>
#include <vector>

#include "graphsolve/ordering.hpp"
#include "ordering/counted_ordering.hpp"
#include "ordering/least_rows.hpp"
#include "ordering/ordering_held.hpp"
#include "ordering/ordering_segments.hpp"
#include "ordering/quotient_graph.hpp"

namespace graphsolve {

namespace {

constexpr std::size_t narrow = 2;  ///< neighbours of a node that every round takes
constexpr int last = std::numeric_limits<int>::max();  ///< in place of the rows of a node that had better wait

using Numbers = std::priority_queue<int, std::vector<int>, std::greater<>>;

/// Rounds of independent nodes. Eliminating one of a round changes neither neighbours nor eligibility of the others,
/// so a round may be sorted freely: by shape. A round looks at no less than a quarter of the nodes that may come, and
/// takes a constant share of these: hence O(log n) rounds on graphs of bounded degree, and O(n) work in them. Nodes that
/// had better wait, and those against the rule, come one at a time; they lie in queues, so that such a round costs
/// O(log n) and not a look at all nodes.
class Wide {
 public:
  explicit Wide(const BlockGraph& graph)
      : graph_(graph), rule_(graph), rest_(graph), segments_(graph.size()), components_(connected_components(graph)),
        costless_(components_.count, 0), guests_(graph.size(), 0), blocked_(graph.size(), 0), seen_(graph.size(), 0),
        forced_rows_(rest_), left_(graph.size()) {
    for (int i = 0; i < graph.size(); ++i) {
      for (const auto& edge : graph.edges({i})) guests_[i] += graph.kind(edge.to) == NodeKind::saddle;
      if (graph.kind({i}) == NodeKind::semidefinite) costless_[components_.of_node[i]] = 1;
    }
    for (int i = 0; i < graph.size(); ++i) {
      if (!rule_.eligible({i})) continue;
      if (wasteful(i)) wasteful_.push(i);
      else waiting_.push_back({i});
    }
    wasteful_left_ = wasteful_.size();
  }

  [[nodiscard]] std::int64_t walked() const { return rest_.walked(); }
  [[nodiscard]] std::int64_t waiting() const { return looked_at_; }

  Ordering run() {
    Ordering result{.method = OrderingMethod::wide};
    result.sequence.reserve(graph_.size());
    for (Waiting& w : waiting_) score(w);
    while (static_cast<int>(result.sequence.size()) < graph_.size()) {
      if (waiting_.empty() && wasteful_left_ == 0) {
        force(result);
        continue;
      }
      find_candidates();
      cut_paths();
      pick_round();
      for (const Pick& pick : round_) {
        result.sequence.push_back({pick.node});
        eliminate(pick.node);
      }
      refresh();
    }
    return result;
  }

 private:
  struct Waiting {
    int node;
    int rows = last;  ///< of its neighbours
    bool narrow = false;
    bool operator<(const Waiting& other) const { return std::tie(rows, node) < std::tie(other.rows, other.node); }
  };
  struct Pick {
    NodeKind kind;
    int dimension, coupled_rows, node;
    bool operator<(const Pick& other) const {
      return std::tie(kind, dimension, coupled_rows, node) <
             std::tie(other.kind, other.dimension, other.coupled_rows, other.node);
    }
  };

  void score(Waiting& w) {
    rest_.neighbours(w.node, narrow, around_);  // no more than it takes to see that it is not
    w.narrow = around_.size() <= narrow;
    w.rows = w.narrow ? rows(around_) : static_cast<int>(rest_.rows_around(w.node));
  }

  [[nodiscard]] int rows(std::span<const int> nodes) const {
    int sum = 0;
    for (const int i : nodes) sum += graph_.dimension({i});
    return sum;
  }

  /// Would eliminating the node leave several guests at it, in a component with costless nodes? Guests that share a
  /// host wait for all their hosts, among them perhaps costless ones, which wait in turn for their guests: such a host
  /// had better serve a single guest, or all may come to wait for each other.
  [[nodiscard]] bool wasteful(int node) const {
    return graph_.kind({node}) == NodeKind::regular && costless_[components_.of_node[node]] && guests_[node] > 1;
  }

  /// The narrow nodes, and of the others those at most twice as large as the smallest; no more than it takes to have
  /// a quarter of all. Of wasteful nodes one at a time, where there are no others: it may give these a way out.
  void find_candidates() {
    candidates_.clear();
    if (waiting_.empty()) {
      while (!(rest_.alive(wasteful_.top()) && wasteful(wasteful_.top()))) wasteful_.pop();
      candidates_.push_back({wasteful_.top()});
      return;
    }
    looked_at_ += static_cast<std::int64_t>(waiting_.size());
    const auto quarter = static_cast<std::ptrdiff_t>((waiting_.size() + wasteful_left_) / 4);
    int bound = last;
    if (quarter < static_cast<std::ptrdiff_t>(waiting_.size())) {
      std::nth_element(waiting_.begin(), waiting_.begin() + quarter, waiting_.end());
      bound = waiting_[quarter].rows;
    }
    int least = last;
    for (const Waiting& w : waiting_)
      if (!w.narrow) least = std::min(least, w.rows);
    bound = least < last ? std::min(bound, 2 * least) : 0;
    for (const Waiting& w : waiting_)
      if (w.narrow || w.rows <= bound) candidates_.push_back(w);
  }

  void cut_paths() {
    narrow_.clear();
    for (const Waiting& w : candidates_)
      if (w.narrow) narrow_.push_back(w.node);
    segments_.find(narrow_, rest_);
    if (std::ranges::all_of(candidates_, [&](const Waiting& w) { return segments_.waits(w.node); })) segments_.give_up();
  }

  void pick_round() {
    ++stamp_;
    round_.clear();
    // Along a path greedy picking then takes every second node.
    const auto key = [&](const Waiting& w) { return std::pair(w.rows, segments_.rank(w.node)); };
    const auto before = [&](const Waiting& a, const Waiting& b) { return key(a) < key(b); };
    if (complete_) {  // the first one blocks all others
      std::erase_if(candidates_, [&](const Waiting& w) { return segments_.waits(w.node); });
      std::swap(candidates_.front(), *std::min_element(candidates_.begin(), candidates_.end(), before));
      candidates_.resize(1);
    }
    std::sort(candidates_.begin(), candidates_.end(), before);
    for (const Waiting& w : candidates_) {
      const int node = w.node;
      if (blocked_[node] == stamp_ || segments_.waits(node)) continue;
      rest_.neighbours(node, graph_.size(), around_);
      for (const int i : around_) blocked_[i] = stamp_;
      round_.push_back({graph_.kind({node}), graph_.dimension({node}), rows(around_), node});
    }
    std::sort(round_.begin(), round_.end());
    touched_.clear();
  }

  void eliminate(int node) {
    segments_.eliminate(node);
    wasteful_left_ -= wasteful(node);
    const auto clique = rest_.eliminate(node);
    complete_ = static_cast<int>(clique.size()) == --left_;
    if (graph_.kind({node}) == NodeKind::saddle)
      for (const auto& edge : graph_.edges({node})) lose_guest(edge.to.index);
    forced_rows_.change(clique);
    touched_.insert(touched_.end(), clique.begin(), clique.end());
    freed_.clear();
    rule_.eliminate({node}, freed_);
    for (const NodeId i : freed_) waiting_.push_back({i.index});
  }

  void lose_guest(int host) {
    const bool was_wasteful = wasteful(host);
    --guests_[host];
    if (!was_wasteful || wasteful(host) || !rest_.alive(host)) return;
    --wasteful_left_;
    waiting_.push_back({host});
  }

  /// Looks again at what the round touched.
  void refresh() {
    looked_at_ += static_cast<std::int64_t>(waiting_.size());
    ++stamp_;
    for (const int i : touched_) seen_[i] = stamp_;
    std::erase_if(waiting_, [&](const Waiting& w) { return !rest_.alive(w.node); });
    for (Waiting& w : waiting_)
      if (seen_[w.node] == stamp_ || w.rows == last) score(w);
  }

  /// No node may come: takes the one with the smallest neighbours against the rule.
  void force(Ordering& result) {
    const int node = forced_rows_.least();
    ++result.forced;
    result.sequence.push_back({node});
    touched_.clear();
    eliminate(node);
    refresh();
  }

  const BlockGraph& graph_;
  Eligibility rule_;
  QuotientGraph rest_;
  Segments segments_;
  Components components_;
  std::vector<char> costless_;  ///< per component: are there semidefinite nodes?
  std::vector<int> guests_;       ///< saddle neighbours that are left
  std::vector<Waiting> waiting_;  ///< nodes that may come next
  Numbers wasteful_;              ///< those that may, but are wasteful; with some that no longer are
  std::size_t wasteful_left_ = 0;
  std::vector<Waiting> candidates_;
  std::vector<Pick> round_;
  std::vector<int> blocked_;  ///< last round in which a neighbour was picked
  std::vector<int> seen_;     ///< last round that touched it
  int stamp_ = 0;
  LeastRows forced_rows_;
  std::int64_t looked_at_ = 0;  ///< entries of waiting_, over all rounds
  int left_;               ///< nodes
  bool complete_ = false;  ///< is each of them coupled with each?
  std::vector<int> touched_, around_, narrow_;
  std::vector<NodeId> freed_;
};

}  // namespace

CountedOrdering counted_wide_ordering(const BlockGraph& graph) {
  Wide wide(graph);
  CountedOrdering result{wide.run()};
  result.walked = wide.walked();
  result.waiting = wide.waiting();
  hold_networks_early(graph, result.ordering);
  return result;
}

Ordering wide_ordering(const BlockGraph& graph) { return counted_wide_ordering(graph).ordering; }

}  // namespace graphsolve
