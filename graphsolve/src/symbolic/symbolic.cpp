#include "graphsolve/symbolic.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "symbolic/equal_couplings.hpp"
#include "graphsolve/factorization.hpp"
#include "symbolic/operations.hpp"
#include "simd/program.hpp"

namespace graphsolve {

Symbolic::Symbolic(const BlockGraph& graph, const Ordering& ordering, Packs packs)
    : rows_(graph.rows()), packs_(packs) {
  const int n = graph.size();
  if (static_cast<int>(ordering.sequence.size()) != n)
    throw std::invalid_argument("ordering has " + std::to_string(ordering.sequence.size()) + " nodes, the graph " +
                                std::to_string(n));
  const Components components = connected_components(graph);
  component_of_ = components.of_node;
  component_begin_.assign(components.count + 1, 0);
  for (const int c : component_of_) ++component_begin_[c + 1];
  for (int c = 0; c < components.count; ++c) component_begin_[c + 1] += component_begin_[c];

  pivots_.resize(n);
  position_.assign(n, -1);
  std::vector<int> next = component_begin_;
  for (const NodeId node : ordering.sequence) {
    if (node.index < 0 || node.index >= n || position_[node.index] >= 0)
      throw std::invalid_argument("ordering is not a permutation of the nodes");
    const int k = next[component_of_[node.index]]++;
    position_[node.index] = k;
    pivots_[k] = {.node = node,
                  .dimension = graph.dimension(node),
                  .row = graph.row(node),
                  .parent = -1,
                  .saddle = graph.kind(node) == NodeKind::saddle,
                  .may_depend = graph.kind(node) == NodeKind::saddle,
                  .leaf = true,
                  .begin = 0, .end = 0, .coupled_rows = 0, .stride = 1,
                  .diagonal = 0, .lower = 0, .upper = 0, .targets = -1, .target_stride = 0};
  }
  find_uncertain(graph);
  find_structure(graph);
  const auto program = std::make_shared<simd::Program>(*this, packs);
  lay_out(*program);
  plan_updates();
  program->find_targets(*this);
  program_ = program;
  count();
  count_memory();
}

void Symbolic::count_memory() {
  const auto bytes = [](std::int64_t count, std::size_t size) { return count * static_cast<std::int64_t>(size); };
  int largest = 0, spread = 0, uncertain = 0, uncertain_rows = 0;
  for (int k = 0; k < pivots(); ++k) {
    largest = std::max(largest, dimension(k));
    spread = std::max(spread, spread_size(*this, k));
    uncertain += may_depend(k) ? 1 : 0;
    uncertain_rows += may_depend(k) ? dimension(k) : 0;
  }
  const std::int64_t plan = sizeof(Symbolic) + bytes(pivots(), sizeof(Pivot) + 2 * sizeof(int)) +
                            bytes(components() + 1, sizeof(int)) +
                            bytes(coupled_.size(), sizeof(int) + sizeof(char) + sizeof(std::int64_t)) +
                            bytes(targets_.size(), sizeof(std::int64_t)) + program_->memory();
  const std::int64_t numbers =
      sizeof(Factorization) + bytes(values_size_, sizeof(double)) +
      bytes(rows_ + (uncertain > 0 ? rows_ : 0), sizeof(int)) +
      bytes(uncertain > 0 ? 2 * (packs_ == Packs::on ? program_->lane_rows() : rows_) : 0, sizeof(double)) +
      bytes(uncertain_rows, sizeof(Factorization::DroppedRow)) +
      bytes(pivots(), 2 * sizeof(int) + 4 * sizeof(char)) + bytes(uncertain, sizeof(int)) + bytes(spread, sizeof(double)) +
      bytes(2 * std::int64_t{largest} * largest + 3 * largest, sizeof(double)) +
      bytes(components(), sizeof(Factorization::Outcome) + 2 * sizeof(int));
  const std::int64_t packed = bytes(program_->scratch_size() + program_->lane_rows(), sizeof(double)) + program_->packs() +
                              static_cast<std::int64_t>(program_->groups().size());
  counts_.memory = plan + numbers + packed;
}

/// A saddle node is safe when a regular neighbour, across a full-row-rank edge, is eliminated before it and after
/// all other saddle neighbours of its own: what it gets from there alone is definite.
///
/// It is also safe when its rows cannot be part of any dependence. Take away, one after the other, saddle nodes that
/// are the last one left at some regular host, across a full-row-rank edge: in y^T J = 0 the columns of that host say
/// y = 0 there, given y = 0 at those taken before. With the hosts eliminated earlier this holds for the eliminated
/// part of J too.
void Symbolic::find_uncertain(const BlockGraph& graph) {
  const auto full_row = [](EdgeRank rank) { return rank == EdgeRank::full_row || rank == EdgeRank::full; };
  std::vector<int> left(pivots(), 0), ready;  // by host: saddle neighbours not taken yet
  for (int k = 0; k < pivots(); ++k) {
    const NodeId host = pivots_[k].node;
    if (graph.kind(host) != NodeKind::regular) continue;
    int waiting = 0, guest = -1;
    for (const auto& edge : graph.edges(host)) {
      if (graph.kind(edge.to) != NodeKind::saddle) continue;
      ++left[k];
      if (position_[edge.to.index] < k) continue;
      ++waiting;
      guest = full_row(edge.rank) ? position_[edge.to.index] : -1;
    }
    if (waiting == 1 && guest >= 0) pivots_[guest].may_depend = false;
    if (left[k] == 1) ready.push_back(k);
  }
  std::vector<char> taken(pivots(), 0), safe(pivots(), 0);
  while (!ready.empty()) {
    const int k = ready.back();
    ready.pop_back();
    int guest = -1;
    bool earlier_are_safe = true;
    for (const auto& edge : graph.edges(pivots_[k].node)) {
      const int i = position_[edge.to.index];
      if (graph.kind(edge.to) != NodeKind::saddle) continue;
      if (!taken[i]) guest = full_row(edge.rank) ? i : -1;
      else earlier_are_safe &= safe[i] != 0;
    }
    if (guest < 0) continue;  // taken from its other side, or not known to be independent here
    taken[guest] = 1;
    safe[guest] = earlier_are_safe && k < guest;
    if (safe[guest]) pivots_[guest].may_depend = false;
    for (const auto& edge : graph.edges(pivots_[guest].node)) {
      const int host = position_[edge.to.index];
      if (graph.kind(edge.to) == NodeKind::regular && --left[host] == 1) ready.push_back(host);
    }
  }
}

/// Column structure of the factor: what the graph couples to the pivot, joined with what its children in the
/// elimination tree pass up.
void Symbolic::find_structure(const BlockGraph& graph) {
  const int n = pivots();
  std::vector<int> mark(n, -1), first_child(n, -1), next_sibling(n, -1), height(n, 1);
  std::vector<int> column;
  for (int k = 0; k < n; ++k) {
    column.clear();
    mark[k] = k;
    for (const auto& edge : graph.edges(pivots_[k].node)) {
      const int i = position_[edge.to.index];
      if (i < k) continue;
      mark[i] = k;
      column.push_back(i);
    }
    const std::size_t original = column.size();
    for (int child = first_child[k]; child >= 0; child = next_sibling[child])
      for (const int i : coupled(child)) {
        if (mark[i] == k) continue;
        mark[i] = k;
        column.push_back(i);
      }
    for (std::size_t i = 0; i < original; ++i) mark[column[i]] = -2 - k;  // in the graph: not fill
    std::sort(column.begin(), column.end());
    pivots_[k].begin = static_cast<int>(coupled_.size());
    for (const int i : column) {
      coupled_.push_back(i);
      fill_.push_back(mark[i] == k ? 1 : 0);
      pivots_[k].coupled_rows += pivots_[i].dimension;
    }
    if (coupled_.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw std::length_error("the factor would have more than 2147483647 blocks: take another ordering");
    pivots_[k].end = static_cast<int>(coupled_.size());
    if (column.empty()) continue;
    const int parent = column.front();
    pivots_[k].parent = parent;
    pivots_[parent].leaf = false;
    next_sibling[k] = first_child[parent];
    first_child[parent] = k;
    height[parent] = std::max(height[parent], height[k] + 1);
  }
  coupled_.shrink_to_fit();
  fill_.shrink_to_fit();
  for (const int h : height) counts_.tree_height = std::max(counts_.tree_height, h);
}

/// One arena, group after group of the program.
void Symbolic::lay_out(simd::Program& program) {
  for (int i = 0; i < static_cast<int>(program.groups().size()); ++i) lay_out_group(program, i);
  block_offset_.resize(coupled_.size());
  for (const Pivot& p : pivots_) {
    std::int64_t offset = 0;
    for (int e = p.begin; e < p.end; ++e) {
      block_offset_[e] = offset;
      offset += static_cast<std::int64_t>(p.dimension) * pivots_[coupled_[e]].dimension;
    }
  }
}

/// In the order of the steps: of each the diagonal block and the blocks below, of a pack interleaved; then of each the blocks
/// to the right. Symmetric factorizations leave most of those alone: cache lines and pages hold nothing else.
void Symbolic::lay_out_group(simd::Program& program, int group) {
  const auto round_up = [&](int to) { values_size_ = (values_size_ + to - 1) / to * to; };
  // f(pivot, place, stride) for each pivot of a step; its scalars are so many from that place on.
  const auto give_place = [&](const simd::Program::Step& step, std::int64_t (Pivot::*scalars)() const, auto&& f) {
    if (step.pack < 0) {
      f(pivots_[step.pivot], values_size_, 1);
      values_size_ += (pivots_[step.pivot].*scalars)();
      return;
    }
    const simd::PivotPack& pack = program.pack(step.pack);
    round_up(pack.lanes);
    for (int l = 0; l < pack.lanes; ++l)
      if (pack.used >> l & 1u) f(pivots_[pack.pivot[l]], values_size_ + l, pack.lanes);
    values_size_ += (pivots_[pack.pivot[0]].*scalars)() * pack.lanes;
  };
  const auto steps = program.steps(program.groups()[group]);
  if (packs_ == Packs::on) round_up(simd::lanes);
  const std::int64_t begin = values_size_;
  for (const auto& step : steps)
    give_place(step, &Pivot::lower_scalars, [](Pivot& p, std::int64_t place, int stride) {
      p.stride = stride;
      p.diagonal = place;
      p.lower = place + static_cast<std::int64_t>(p.dimension) * p.dimension * stride;
    });
  if (packs_ == Packs::on) round_up(simd::lanes);
  const std::int64_t upper = values_size_;
  for (const auto& step : steps)
    give_place(step, &Pivot::upper_scalars, [](Pivot& p, std::int64_t place, int) { p.upper = place; });
  program.set_extent(group, begin, upper, values_size_);
}

void Symbolic::count() {
  for (const Pivot& p : pivots_) {
    const std::int64_t d = p.dimension, r = p.coupled_rows;
    for (int e = p.begin; e < p.end; ++e) {
      if (fill_[e]) ++counts_.fill_blocks;
      else counts_.matrix_scalars += 2 * d * pivots_[coupled_[e]].dimension;
    }
    counts_.matrix_scalars += d * d;
    counts_.stored_scalars += p.scalars();
    add_operations(counts_.operations, lu_pivot_operations(d, r));
    add_operations(counts_.symmetric_operations, ldlt_pivot_operations(d, r));
    counts_.solve_operations += d * d + 2 * d * r;
    counts_.largest_front = std::max(counts_.largest_front, p.dimension + p.coupled_rows);
  }
  counts_.stored_blocks = pivots() + 2 * static_cast<std::int64_t>(coupled_.size());
  for (const auto& step : program_->steps()) {
    const Pivot& p = pivots_[step.pack < 0 ? step.pivot : program_->pack(step.pack).pivot[0]];
    const std::int64_t d = p.dimension, m = p.coupled_rows;
    const bool by_rows = step.pack < 0 && p.dimension > simd::largest_lone;
    const auto weighed = [by_rows](std::int64_t operations) {
      return by_rows && operations < std::numeric_limits<std::int64_t>::max() ? operations / Counts::rows_at_once : operations;
    };
    add_operations(counts_.pack_operations, weighed(lu_pivot_operations(d, m)));
    add_operations(counts_.symmetric_pack_operations, weighed(ldlt_pivot_operations(d, m)));
  }
}

/// Offsets of the blocks that the elimination of each pivot updates: for couplings i, j the block (i, j). A pivot often
/// couples what one of its children couples, but for itself: then it finds its table in the child's, less the first row
/// and column. In the dense end of an elimination a single table serves all pivots.
void Symbolic::plan_updates() {
  std::vector<int> owners;
  std::int64_t size = 0;
  for (int k = 0; k < pivots(); ++k) {
    Pivot& p = pivots_[k];
    const int m = p.end - p.begin;
    if (p.targets < 0) {
      p.targets = size;
      p.target_stride = m;
      size += static_cast<std::int64_t>(m) * m;
      owners.push_back(k);
    }
    if (m < 2) continue;
    Pivot& parent = pivots_[p.parent];
    if (parent.end - parent.begin != m - 1) continue;
    parent.targets = p.targets + p.target_stride + 1;
    parent.target_stride = p.target_stride;
  }
  targets_.resize(size);
  for (const int k : owners) {
    const Pivot& p = pivots_[k];
    const int m = p.end - p.begin;
    const int* later = coupled_.data() + p.begin;
    std::int64_t* target = targets_.data() + p.targets;
    for (int i = 0; i < m; ++i) {
      const Pivot& pi = pivots_[later[i]];
      target[i * m + i] = pi.diagonal;
      int e = pi.begin;
      for (int j = i + 1; j < m; ++j) {
        while (coupled_[e] != later[j]) ++e;  // the coupling exists: that is what fill means
        target[i * m + j] = pi.upper + block_offset_[e] * pi.stride;
        target[j * m + i] = pi.lower + block_offset_[e] * pi.stride;
      }
    }
  }
}

std::span<const int> Symbolic::coupled(int pivot) const {
  return {coupled_.data() + pivots_[pivot].begin, coupled_.data() + pivots_[pivot].end};
}

int Symbolic::find(int pivot, int later) const {
  const auto begin = coupled_.begin() + pivots_[pivot].begin, end = coupled_.begin() + pivots_[pivot].end;
  const auto found = std::lower_bound(begin, end, later);
  return found != end && *found == later ? static_cast<int>(found - coupled_.begin()) : -1;
}

BlockHandle Symbolic::block(NodeId a, NodeId b) const {
  for (const NodeId node : {a, b})
    if (node.index < 0 || node.index >= pivots()) throw std::invalid_argument("there is no node " + std::to_string(node.index));
  const int i = position_[a.index], j = position_[b.index];
  const Pivot &pi = pivots_[i], &pj = pivots_[j];
  if (i == j) return {pi.diagonal, pi.dimension, pi.dimension, pi.stride};
  const int e = i < j ? find(i, j) : find(j, i);
  if (e < 0 || fill_[e] != 0)  // what is written to fill is in no copy of the matrix
    throw std::invalid_argument("no block between nodes " + std::to_string(a.index) + " and " + std::to_string(b.index) +
                                ": the graph has no such edge");
  const Pivot& owner = i < j ? pi : pj;
  return {(i < j ? pi.upper : pj.lower) + block_offset_[e] * owner.stride, pi.dimension, pj.dimension, owner.stride};
}

}  // namespace graphsolve
