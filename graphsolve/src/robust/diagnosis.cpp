#include "graphsolve/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "factorization/kept_matrix.hpp"
#include "graph/structural_rank.hpp"
#include "robust/near_null.hpp"
#include "symbolic/same_nodes.hpp"

namespace graphsolve {

namespace {

std::vector<Diagnosis::Entry> find_not_finite(const BlockGraph& graph, const Factorization& f) {
  std::vector<Diagnosis::Entry> found;
  each_matrix_block(f.symbolic(), [&](NodeId a, NodeId b, const BlockHandle& h) {
    for (int j = 0; j < h.columns; ++j)
      for (int i = 0; i < h.rows; ++i)
        if (const double value = f.matrix()[h.place(i, j)]; !std::isfinite(value))
          found.push_back({std::string(graph.name(a)), std::string(graph.name(b)), i, j, value});
  });
  return found;
}

/// Rows left out whose groups share a node are one group.
std::vector<Diagnosis::Group> find_redundant(const BlockGraph& graph, const Factorization& f) {
  struct Set {
    std::vector<int> nodes;
    int rows;
  };
  std::vector<Set> sets;
  std::vector<double> y(f.symbolic().rows());
  for (const auto& dropped : f.dropped_rows()) {
    f.dependency(dropped, y);
    double largest = 0;
    for (const double value : y) largest = std::max(largest, std::abs(value));
    Set set{{}, 1};
    for (int k = 0; k < graph.size(); ++k) {
      const auto block = std::span(y).subspan(graph.row({k}), graph.dimension({k}));
      if (std::ranges::any_of(block, [&](double value) { return std::abs(value) > 1e-9 * largest; })) set.nodes.push_back(k);
    }
    std::erase_if(sets, [&](const Set& other) {
      const bool shared = std::ranges::any_of(other.nodes, [&](int k) { return std::ranges::binary_search(set.nodes, k); });
      if (!shared) return false;
      std::vector<int> joined;
      std::ranges::set_union(set.nodes, other.nodes, std::back_inserter(joined));
      set.nodes = std::move(joined);
      set.rows += other.rows;
      return true;
    });
    sets.push_back(std::move(set));
  }
  std::vector<Diagnosis::Group> groups;
  for (const Set& set : sets) {
    groups.push_back({{}, set.rows});
    for (const int k : set.nodes) groups.back().nodes.emplace_back(graph.name({k}));
  }
  return groups;
}

void find_near_null(const BlockGraph& graph, const Eigen::SparseMatrix<double>& a, Diagnosis& result) {
  const NearNull found = near_null(a);
  result.largest_singular = found.column;
  result.smallest_singular = found.shortened;
  if (found.vector.size() == 0) return;
  for (int k = 0; k < graph.size(); ++k) {
    const double share = found.vector.segment(graph.row({k}), graph.dimension({k})).squaredNorm();
    if (share > 1e-6) result.near_null.push_back({std::string(graph.name({k})), share});
  }
  std::ranges::stable_sort(result.near_null, std::greater{}, &Diagnosis::Share::share);
}

void find_zero_rows(const BlockGraph& graph, const Eigen::SparseMatrix<double>& a, Diagnosis& result) {
  std::vector<char> filled(a.rows());
  for (int j = 0; j < a.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry) filled[entry.row()] = 1;
  for (int k = 0; k < graph.size(); ++k)
    for (int i = 0; i < graph.dimension({k}); ++i)
      if (!filled[graph.row({k}) + i]) result.zero_rows.push_back({std::string(graph.name({k})), i});
}

}  // namespace

Diagnosis diagnose(const BlockGraph& graph, const Factorization& f, const Factorization::Outcome& outcome) {
  if (f.matrix().empty()) throw std::invalid_argument("diagnose: the factorization did not keep its matrix");
  check_same_nodes(f.symbolic(), graph, "diagnose");
  Diagnosis result;
  result.rows = graph.rows();
  result.not_finite = find_not_finite(graph, f);
  if (!result.not_finite.empty()) return result;
  if (!outcome.ok()) {
    const NodeId node = f.symbolic().node(outcome.first_bad_pivot);
    result.failed = graph.name(node);
    for (const auto& edge : graph.edges(node)) result.failed_neighbours.emplace_back(graph.name(edge.to));
  } else {
    result.redundant = find_redundant(graph, f);
    if (f.kind() != FactorizationKind::ldu) result.inertia = outcome.inertia;
    result.boosts = outcome.boosts;
  }
  const Eigen::SparseMatrix<double> a = sparse_matrix(f.symbolic(), f.matrix());
  find_zero_rows(graph, a, result);
  result.structural_rank = structural_rank(a);
  find_near_null(graph, a, result);
  return result;
}

}  // namespace graphsolve
