#pragma once

#include <cstddef>
#include <functional>
#include <queue>
#include <span>
#include <tuple>
#include <vector>

#include "ordering/quotient_graph.hpp"

namespace graphsolve {

/// Which node of a quotient graph has the fewest rows around it? Costs nothing until somebody asks; then each question
/// looks again at the nodes whose neighbours changed, and at no more than a few neighbours of each until they matter.
class LeastRows {
 public:
  explicit LeastRows(QuotientGraph& graph) : graph_(graph) {}

  /// The neighbours of these nodes have changed.
  void change(std::span<const int> nodes) {
    for (const int i : nodes)
      if (asked_ && !changed_mark_[i]) note(i);
  }

  /// The first of the nodes that are left with the fewest; there must be one.
  int least() {
    if (!asked_) start();
    for (const int i : changed_) {
      changed_mark_[i] = 0;
      if (graph_.alive(i)) look(i);
    }
    changed_.clear();
    for (;;) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (!graph_.alive(entry.node) || entry.look != looks_[entry.node]) continue;
      if (entry.exact) {
        queue_.push(entry);
        return entry.node;
      }
      queue_.push({static_cast<int>(graph_.rows_around(entry.node)), entry.node, entry.look, true});
    }
  }

 private:
  static constexpr std::size_t few = 16;  ///< neighbours; of more, the sum so far is a bound

  struct Entry {
    int rows, node;
    int look;  ///< the entry counts while this is the node's last one
    bool exact;
    bool operator>(const Entry& other) const { return std::tie(rows, node) > std::tie(other.rows, other.node); }
  };

  void start() {
    asked_ = true;
    looks_.assign(graph_.size(), 0);
    changed_mark_.assign(graph_.size(), 0);
    for (int i = 0; i < graph_.size(); ++i) note(i);
  }
  void note(int node) {
    changed_mark_[node] = 1;
    changed_.push_back(node);
  }
  void look(int node) {
    graph_.neighbours(node, few, around_);
    int rows = 0;
    for (const int i : around_) rows += graph_.dimension(i);
    queue_.push({rows, node, ++looks_[node], around_.size() <= few});
  }

  QuotientGraph& graph_;
  bool asked_ = false;
  std::vector<int> looks_;
  std::vector<char> changed_mark_;
  std::vector<int> changed_, around_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace graphsolve
