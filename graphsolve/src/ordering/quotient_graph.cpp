#include "ordering/quotient_graph.hpp"

#include <algorithm>

namespace graphsolve {

namespace {

constexpr int long_list = 64;  ///< lists of more entries are not walked at every elimination

/// Order of a list with entries ~node that are gone.
bool before(int entry, int node) { return (entry < 0 ? ~entry : entry) < node; }

}  // namespace

QuotientGraph::QuotientGraph(const BlockGraph& graph) : nodes_(graph.size()), mark_(graph.size(), 0) {
  int end = 0;
  for (int i = 0; i < graph.size(); ++i) {
    Node& node = nodes_[i];
    node.dimension = graph.dimension({i});
    node.variables = static_cast<int>(graph.edges({i}).size());
    node.begin = end;
    end += 2 * node.variables + 2;  // both lists need at most one entry per edge; the rest is for entries that are gone
    node.end = end;
  }
  lists_.resize(end);
  elements_.reserve(graph.size());
  for (int i = 0; i < graph.size(); ++i) {
    Node& node = nodes_[i];
    const auto list = variables(node);
    std::transform(graph.edges({i}).begin(), graph.edges({i}).end(), list.begin(),
                   [](const BlockGraph::Edge& edge) { return edge.to.index; });
    std::sort(list.begin(), list.end());
    for (const int j : list) node.sum += nodes_[j].dimension;
  }
}

std::span<const int> QuotientGraph::eliminate(int index) {
  gather_clique(index);
  nodes_[index].alive = false;
  eliminated_ = index;
  const int element = static_cast<int>(elements_.size());
  store_clique();
  for (const int i : clique_) {
    Node& node = nodes_[i];
    prune(node);
    if (node.elements_gone > 0 && (node.elements <= long_list || 2 * node.elements_gone > node.elements))
      compact_elements(node);
    if (clique_.size() < 2) continue;
    if (node.begin + node.elements + node.variables == node.end) {
      compact_elements(node);
      compact_variables(node);
    }
    lists_[node.begin + node.elements++] = element;
  }
  measure_overlaps();
  return clique_;
}

/// clique_ := neighbours of the node; they and the node are marked with the new stamp. Its elements are dropped.
void QuotientGraph::gather_clique(int index) {
  clique_.clear();
  mark_[index] = ++stamp_;
  const auto take = [&](int i) {
    if (mark_[i] == stamp_) return;
    mark_[i] = stamp_;
    clique_.push_back(i);
  };
  const Node& node = nodes_[index];
  for (const int i : variables(node))
    if (i >= 0) take(i);
  for (const int e : elements(node)) {
    for (const int i : members(elements_[e])) take(i);
    drop(elements_[e]);
  }
}

void QuotientGraph::drop(Element& element) {
  for (const int i : members(element)) ++nodes_[i].elements_gone;
  members_left_ -= element.size;
  element.size = 0;
}

/// Removes the eliminated node and what the new clique shows from the variables of one of its members.
void QuotientGraph::prune(Node& node) {
  if (node.variables == 0) return;
  if (node.variables > long_list && node.variables > 8 * static_cast<int>(clique_.size())) {
    for (const int i : clique_) remove_variable(node, i);
    remove_variable(node, eliminated_);
    if (2 * node.variables_gone > node.variables) compact_variables(node);
    return;
  }
  for (int& entry : variables(node)) {
    if (entry < 0 || mark_[entry] != stamp_) continue;
    node.sum -= nodes_[entry].dimension;
    ++node.variables_gone;
    entry = ~entry;
  }
  if (node.variables_gone > 0) compact_variables(node);
}

void QuotientGraph::remove_variable(Node& node, int other) {
  const auto list = variables(node);
  const auto found = std::lower_bound(list.begin(), list.end(), other, before);
  if (found == list.end() || *found != other) return;
  node.sum -= nodes_[other].dimension;
  ++node.variables_gone;
  *found = ~other;
}

void QuotientGraph::compact_elements(Node& node) {
  int kept = node.begin;
  for (const int e : elements(node))
    if (elements_[e].size > 0) lists_[kept++] = e;
  node.elements = kept - node.begin;
  node.elements_gone = 0;
}

void QuotientGraph::compact_variables(Node& node) {
  int kept = node.end;
  for (int k = node.end; k-- > node.end - node.variables;)
    if (lists_[k] >= 0) lists_[--kept] = lists_[k];
  node.variables = node.end - kept;
  node.variables_gone = 0;
}

/// Makes the clique an element. One of a single node couples nothing and is gone at once.
void QuotientGraph::store_clique() {
  if (static_cast<std::int64_t>(members_.size()) > 2 * members_left_ + size()) {  // elements lie in order of their age
    std::int64_t end = 0;
    for (Element& element : elements_) {
      if (element.size == 0) continue;
      std::copy_n(members_.begin() + element.begin, element.size, members_.begin() + end);
      element.begin = end;
      end += element.size;
    }
    members_.resize(end);
  }
  Element element{.begin = static_cast<std::int64_t>(members_.size())};
  for (const int i : clique_) element.weight += nodes_[i].dimension;
  if (clique_.size() > 1) {
    element.size = static_cast<int>(clique_.size());
    members_.insert(members_.end(), clique_.begin(), clique_.end());
    members_left_ += element.size;
  }
  elements_.push_back(element);
}

/// How much of every element around lies outside the newest clique; drops those of which nothing does.
void QuotientGraph::measure_overlaps() {
  const int newest = static_cast<int>(elements_.size()) - 1;
  const bool all = std::ranges::none_of(clique_, [&](int i) { return nodes_[i].elements > long_list; });
  scratch_.clear();
  for (const int i : clique_) {
    const Node& node = nodes_[i];
    if (node.elements > long_list) continue;  // their elements seem to reach further out than they do
    for (const int e : elements(node)) {
      Element& element = elements_[e];
      if (e == newest || element.size == 0) continue;
      if (element.seen != newest) {
        element.seen = newest;
        element.compared = all ? newest : -1;
        element.outside = element.weight;
      }
      element.outside -= node.dimension;
      if (element.outside == 0) scratch_.push_back(e);
    }
  }
  for (const int e : scratch_) drop(elements_[e]);
}

void QuotientGraph::neighbours(int index, std::size_t limit, std::vector<int>& out) {
  out.clear();
  mark_[index] = ++stamp_;
  const Node& node = nodes_[index];
  for (const int i : variables(node)) {
    ++walked_;
    if (i < 0) continue;
    mark_[i] = stamp_;
    out.push_back(i);
    if (out.size() > limit) return;
  }
  for (const int e : elements(node))
    for (const int i : members(elements_[e])) {
      ++walked_;
      if (mark_[i] == stamp_) continue;
      mark_[i] = stamp_;
      out.push_back(i);
      if (out.size() > limit) return;
    }
}

/// Variables are in no element of the node, and whoever is eliminated takes its elements along: weights are those of nodes
/// that are left. Only where several elements meet must their members be walked.
std::int64_t QuotientGraph::rows_around(int index) {
  const Node& node = nodes_[index];
  const Element* found[2] = {};
  int newer = 0, count = 0;
  for (const int e : elements(node)) {
    if (elements_[e].size == 0) continue;
    if (count == 2) return walk_rows_around(index);
    found[count++] = &elements_[e];
    newer = e;
  }
  if (count == 0) return node.sum;
  if (count == 1) return node.sum + found[0]->weight - node.dimension;
  if (found[0]->compared != newer) return walk_rows_around(index);
  return node.sum + found[0]->outside + found[1]->weight - node.dimension;
}

std::int64_t QuotientGraph::walk_rows_around(int index) {
  neighbours(index, nodes_.size(), scratch_);
  std::int64_t sum = 0;
  for (const int i : scratch_) sum += nodes_[i].dimension;
  return sum;
}

}  // namespace graphsolve
