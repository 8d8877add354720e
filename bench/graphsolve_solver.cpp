#include "graphsolve_solver.hpp"

#include <algorithm>

namespace bench {

using namespace graphsolve;

namespace {

/// Where each entry of the matrix lies in the value array.
std::vector<std::int64_t> places(const Eigen::SparseMatrix<double>& a, const BlockGraph& graph,
                                 const Symbolic& symbolic) {
  std::vector<int> node_of(graph.rows());
  for (int i = 0; i < graph.size(); ++i) std::fill_n(node_of.begin() + graph.row({i}), graph.dimension({i}), i);
  std::vector<std::int64_t> place;
  place.reserve(a.nonZeros());
  for (int j = 0; j < a.outerSize(); ++j) {
    const NodeId column{node_of[j]};
    NodeId last;
    BlockHandle handle;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry) {
      const NodeId row{node_of[entry.row()]};
      if (row != last) handle = symbolic.block(row, column);
      last = row;
      place.push_back(handle.offset + (j - graph.row(column)) * handle.rows + entry.row() - graph.row(row));
    }
  }
  return place;
}

}  // namespace

baselines::Status GraphsolveSolver::analyze(const Eigen::SparseMatrix<double>& a) {
  pattern_ = &a;
  place_.clear();
  factorization_ = std::make_unique<Factorization>(
      std::make_shared<const Symbolic>(graph_, minimum_fill_ordering(graph_)));
  return {};
}

void GraphsolveSolver::write(std::span<const double> values) {
  if (place_.empty()) place_ = places(*pattern_, graph_, factorization_->symbolic());
  factorization_->set_zero();
  const std::span<double> to = factorization_->values();
  for (std::size_t k = 0; k < values.size(); ++k) to[place_[k]] = values[k];
}

baselines::Status GraphsolveSolver::refactor() {
  const auto outcome = factorization_->factorize();
  dropped_rows_ = outcome.dropped_rows;
  if (outcome.ok()) return {};
  return {false, "singular at " + std::string(graph_.name(symbolic().node(outcome.first_bad_pivot)))};
}

baselines::Status GraphsolveSolver::solve(std::span<const double> b, std::span<double> x) {
  std::copy(b.begin(), b.end(), x.begin());
  factorization_->solve(x);
  return {};
}

void GraphsolveSolver::allow_refinement() {
  factorization_->allow_refinement();
  factorization_->keep_matrix(true);
}

Factorization::Refinement GraphsolveSolver::refine(std::span<const double> b, std::span<double> x) {
  return factorization_->refine(b, x);
}

}  // namespace bench
