#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ordering/quotient_graph.hpp"

namespace graphsolve {

/// Long paths cut into as many equal segments as a pack has lanes, with single nodes between them and at free ends, which
/// wait until the segments are gone. What is done in one segment is done in all: eight pivots of one shape, whose
/// couplings lie side by side too.
class Segments {
 public:
  explicit Segments(int nodes);

  /// Looks for paths among these nodes, each of two neighbours at most, and cuts those that are long and new.
  void find(std::span<const int> narrow, QuotientGraph& rest);

  /// Does it wait for the segments of its path?
  [[nodiscard]] bool waits(int node) const { return waits_[node] != 0; }
  /// Where a node comes among others: by number, but along a path that was cut in the path's order.
  [[nodiscard]] int rank(int node) const { return rank_[node]; }
  void eliminate(int node);
  /// Nobody waits any longer.
  void give_up();

 private:
  struct Path {
    int begin, end;  ///< in nodes_
    int in_segments; ///< nodes that are left in them
  };

  /// Collects the nodes that follow `from` through `next`, as long as they are narrow and unseen.
  void walk(int from, int next, QuotientGraph& rest);
  void neighbours(int node, QuotientGraph& rest);
  void cut(std::span<const int> path, QuotientGraph& rest);
  void sort_ranks(std::span<const int> path);
  void release(const Path& path);

  std::vector<char> waits_;
  std::vector<char> narrow_, seen_;  ///< of the call of find() that is going on
  std::vector<int> rank_;
  std::vector<int> path_;            ///< of a node in a segment, else -1
  std::vector<char> taken_;          ///< part of a path that was cut
  std::vector<Path> paths_;
  std::size_t given_up_ = 0;         ///< of them, from the front
  std::vector<int> nodes_;           ///< of all paths
  std::vector<int> along_, around_, ranks_;
};

}  // namespace graphsolve
