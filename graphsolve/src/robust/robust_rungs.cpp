#include "robust/robust_rungs.hpp"

#include <algorithm>
#include <cmath>

#include "factorization/kept_matrix.hpp"

namespace graphsolve {

namespace {

constexpr double stiff = 1e6;   ///< a node this much larger than its neighbours is eliminated later
constexpr double shift = 1e-8;  ///< of what was added to a saddle row; 1e-6 spoils it

bool better(double error, double than) { return error < than || std::isnan(than); }

}  // namespace

void RobustSolver::Impl::note(Search& search, Rung rung, const std::string& what) const {
  if (!search.why.empty()) search.why += "; ";
  search.why += std::string(name(rung)) + ": " + what;
}

std::string RobustSolver::Impl::bad_pivot(const Factorization& f, const Factorization::Outcome& o) const {
  return "block '" + std::string(graph->name(f.symbolic().node(o.first_bad_pivot))) + "' " +
         (f.kind() == FactorizationKind::cholesky ? "is not positive definite" : "has no usable pivot");
}

/// True when this attempt is good enough.
bool RobustSolver::Impl::judge(Search& search, Attempt attempt) const {
  const bool good = attempt.error <= options.acceptable;
  if (!good) note(search, attempt.rung, "backward error " + short_number(attempt.error));
  if (!search.best || better(attempt.error, search.best->error)) search.best = std::move(attempt);
  return good;
}

bool RobustSolver::Impl::try_factors(Search& search, Rung rung, Factorization& f, const Factorization::Outcome& o) const {
  if (!o.ok()) {
    note(search, rung, bad_pivot(f, o));
    return false;
  }
  Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(search.b.data(), static_cast<Eigen::Index>(search.b.size()));
  const std::span<double> solution(x.data(), search.b.size());
  f.solve(solution);
  const auto refined = f.refine(search.b, solution, options.max_sweeps);
  return judge(search, {rung, std::move(x), refined.backward_error});
}

/// The matrix factored in another order, or with a shift.
RobustSolver::Impl::Retry RobustSolver::Impl::retry(const Ordering& order, double saddle_shift) const {
  Factorization f(std::make_shared<const Symbolic>(*graph, order), options.kind);
  f.allow_refinement();
  f.keep_matrix(true);
  f.set_saddle_shift(saddle_shift);
  each_matrix_block(first.symbolic(), [&](NodeId a, NodeId b, const BlockHandle& from) {
    const BlockHandle to = f.symbolic().block(a, b);
    for (int j = 0; j < from.columns; ++j)
      for (int i = 0; i < from.rows; ++i) f.entry(to, i, j) = first.matrix()[from.place(i, j)];
  });
  Factorization::Outcome o = f.factorize();
  return {std::move(f), o};
}

double RobustSolver::Impl::largest_diagonal(NodeId node) const {
  const BlockHandle h = first.symbolic().block(node, node);
  double largest = 0;
  for (int i = 0; i < h.rows; ++i) largest = std::max(largest, std::abs(values[h.place(i, i)]));
  return largest;
}

/// Nodes that should wait: much larger than some neighbour of their kind of unknown, or where the elimination ended.
std::vector<char> RobustSolver::Impl::late_nodes() const {
  std::vector<char> late(graph->size());
  for (int k = 0; k < graph->size(); ++k)
    for (const auto& edge : graph->edges({k})) {
      const double own = largest_diagonal({k}), other = largest_diagonal(edge.to);
      if (other > 0 && own > stiff * other) late[k] = 1;
    }
  if (!outcome.ok()) late[first.symbolic().node(outcome.first_bad_pivot).index] = 1;
  return late;
}

bool RobustSolver::Impl::try_reordered(Search& search) {
  if (reordered) return try_factors(search, Rung::reordered, reordered->factorization, reordered->outcome);
  const std::vector<char> late = late_nodes();
  if (std::ranges::count(late, 1) == 0) {
    note(search, Rung::reordered, "no node is stiff");
    return false;
  }
  std::vector<NodeId> sequence;
  for (const bool wanted : {false, true})
    for (const NodeId node : ordering.sequence)
      if ((late[node.index] != 0) == wanted) sequence.push_back(node);
  reordered.emplace(retry(user_ordering(*graph, sequence), 0));
  return try_factors(search, Rung::reordered, reordered->factorization, reordered->outcome);
}

bool RobustSolver::Impl::try_shifted(Search& search) {
  bool saddle = false;
  for (int k = 0; k < graph->size(); ++k) saddle = saddle || graph->kind({k}) == NodeKind::saddle;
  if (!saddle || options.kind == FactorizationKind::cholesky) return false;
  if (!shifted) shifted.emplace(retry(ordering, shift));
  return try_factors(search, Rung::shifted, shifted->factorization, shifted->outcome);
}

bool RobustSolver::Impl::try_general(Search& search) {
  if (!general) general.emplace(sparse_matrix(first.symbolic(), first.matrix()), options.fallback);
  const Eigen::Map<const Eigen::VectorXd> b(search.b.data(), static_cast<Eigen::Index>(search.b.size()));
  auto result = general->solve(b, options.max_sweeps);
  if (result.why.empty()) return judge(search, {Rung::threshold_pivoting, std::move(result.x), result.backward_error});
  note(search, Rung::threshold_pivoting, result.why);
  return false;
}

}  // namespace graphsolve
