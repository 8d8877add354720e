#include "graphsolve_solver.hpp"

#include <algorithm>
#include <numeric>

#include "graphsolve/cheapest_ordering.hpp"
#include "graphsolve/io/eigen.hpp"

namespace bench {

using namespace graphsolve;

namespace {

std::vector<int> rows_as_given(int rows) {
  std::vector<int> same(rows);
  std::iota(same.begin(), same.end(), 0);
  return same;
}

EntryMap map_of(const Eigen::SparseMatrix<double>& a, const BlockGraph& graph, std::vector<int> row_of,
                const Symbolic& symbolic, FactorizationKind kind) {
  return {io::from_eigen(a), BlockStructure{.graph = graph, .row_of = std::move(row_of)}, symbolic, kind};
}

}  // namespace

baselines::Status GraphsolveSolver::analyze(const Eigen::SparseMatrix<double>& a) {
  pattern_ = &a;
  map_.reset();
  simd::use_instruction_set(way_.set.value_or(simd::instruction_sets().back()));
  std::shared_ptr<const Symbolic> symbolic;
  if (way_.path == Path::packs) {
    symbolic = std::make_shared<const Symbolic>(graph_, cheapest_in_packs(graph_, way_.kind));
  } else {
    const Ordering ordering = minimum_fill_ordering(graph_);
    if (way_.nodes == Nodes::merged) {
      merged_ = merge_supernodes(graph_, ordering);
      symbolic = std::make_shared<const Symbolic>(merged_.graph, merged_.ordering, Packs::off);
    } else {
      symbolic = std::make_shared<const Symbolic>(graph_, ordering, Packs::off);
    }
  }
  factorization_ = std::make_unique<Factorization>(std::move(symbolic), way_.kind);
  right_.resize(graph_.rows());
  x_.resize(graph_.rows());
  return {};
}

void GraphsolveSolver::write(std::span<const double> values) {
  if (!map_)
    map_ = way_.nodes == Nodes::merged ? map_of(*pattern_, merged_.graph, merged_.row_of, symbolic(), way_.kind)
                                       : map_of(*pattern_, graph_, rows_as_given(graph_.rows()), symbolic(), way_.kind);
  map_->write(values, factorization_->values());
}

baselines::Status GraphsolveSolver::refactor() {
  outcome_ = factorization_->factorize();
  return status();
}

baselines::Status GraphsolveSolver::refactor_and_solve(std::span<const double> b, std::span<double> x) {
  const bool as_given = way_.nodes == Nodes::as_given;
  const std::span<double> here = as_given ? x : std::span<double>(x_);
  if (as_given) std::copy(b.begin(), b.end(), x.begin());
  else into_merged(b);
  outcome_ = factorization_->factorize_and_solve(here);
  if (!as_given) out_of_merged(x);
  return status();
}

void GraphsolveSolver::into_merged(std::span<const double> b) {
  for (std::size_t i = 0; i < b.size(); ++i) x_[merged_.row_of[i]] = b[i];
}

void GraphsolveSolver::out_of_merged(std::span<double> x) const {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[merged_.row_of[i]];
}

baselines::Status GraphsolveSolver::status() const {
  if (outcome_.ok()) return {};
  const BlockGraph& graph = way_.nodes == Nodes::merged ? merged_.graph : graph_;
  return {false, "singular at " + std::string(graph.name(symbolic().node(outcome_.first_bad_pivot)))};
}

baselines::Status GraphsolveSolver::solve(std::span<const double> b, std::span<double> x) {
  if (way_.nodes == Nodes::as_given) {
    std::copy(b.begin(), b.end(), x.begin());
    factorization_->solve(x);
    return {};
  }
  into_merged(b);
  factorization_->solve(x_);
  out_of_merged(x);
  return {};
}

void GraphsolveSolver::allow_refinement() {
  factorization_->allow_refinement();
  factorization_->keep_matrix(true);
}

Factorization::Refinement GraphsolveSolver::refine(std::span<const double> b, std::span<double> x) {
  constexpr int sweeps = 10;
  if (way_.nodes == Nodes::as_given) return factorization_->refine(b, x, sweeps);
  for (std::size_t i = 0; i < b.size(); ++i) {
    right_[merged_.row_of[i]] = b[i];
    x_[merged_.row_of[i]] = x[i];
  }
  const auto refined = factorization_->refine(right_, x_, sweeps);
  for (std::size_t i = 0; i < b.size(); ++i) x[i] = x_[merged_.row_of[i]];
  return refined;
}

baselines::Status RobustGraphsolve::analyze(const Eigen::SparseMatrix<double>& a) {
  solver_.emplace(graph_, RobustSolver::Options{.kind = kind_, .acceptable = 1e-15, .max_sweeps = 20});
  map_ = map_of(a, graph_, rows_as_given(graph_.rows()), solver_->symbolic(), FactorizationKind::ldu);  // both triangles
  return {};
}

void RobustGraphsolve::write(std::span<const double> values) {
  map_->write(values, solver_->values());
}

baselines::Status RobustGraphsolve::refactor() {
  (void)solver_->factorize();
  return {};
}

baselines::Status RobustGraphsolve::solve(std::span<const double> b, std::span<double> x) {
  report_ = solver_->solve(b, x);
  if (report_.status == Status::solved) return {};
  return {false, std::string(graphsolve::name(report_.status)) + ": " + report_.why};
}

}  // namespace bench
