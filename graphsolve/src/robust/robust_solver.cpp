#include "graphsolve/robust_solver.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "factorization/kept_matrix.hpp"
#include "graphsolve/overlap.hpp"
#include "robust/robust_rungs.hpp"

namespace graphsolve {

namespace {

Ordering ordering_of(const BlockGraph& graph, const RobustSolver::Options& options) {
  if (options.ordering == OrderingMethod::user) return user_ordering(graph, options.sequence);
  if (!options.sequence.empty())
    throw std::invalid_argument("a sequence is given, but the ordering is '" + std::string(name(options.ordering)) +
                                "': a sequence goes with OrderingMethod::user");
  return make_ordering(graph, options.ordering);
}

constexpr double none_found = std::numeric_limits<double>::infinity();  ///< backward error of no solution at all

/// Is `a` worse news than `b`?
bool worse(const RobustSolver::Report& a, const RobustSolver::Report& b) {
  if (a.status != Status::solved || b.status != Status::solved) return b.status == Status::solved;
  if (a.rung != b.rung) return a.rung > b.rung;
  return a.backward_error > b.backward_error;
}

}  // namespace

std::string_view name(Rung rung) {
  switch (rung) {
    case Rung::factorization: return "factorization";
    case Rung::reordered: return "reordered";
    case Rung::shifted: return "shifted";
    case Rung::threshold_pivoting: return "threshold pivoting";
  }
  return "unknown";
}

RobustSolver::Impl::Impl(BlockGraph g, Options o)
    : graph(std::make_shared<const BlockGraph>(std::move(g))), options(std::move(o)),
      ordering(ordering_of(*graph, options)), side(Side::plain), first(std::make_shared<const Symbolic>(*graph, ordering), options.kind),
      values(first.values().size()), solutions(rows()), contradictions(1) {
  first.allow_refinement();
  first.keep_matrix(true);
}

RobustSolver::Impl::Impl(const Impl& of, Side s)
    : graph(of.graph), options(of.options), ordering(of.ordering), side(s), first(of.first.twin()),
      values(of.values.size()) {
  first.allow_refinement();
  first.keep_matrix(true);
}

void RobustSolver::Impl::factorize() {
  std::copy(values.begin(), values.end(), first.values().begin());
  reordered.reset();
  shifted.reset();
  general.reset();
  twin_is_current = false;
  outcome = first.factorize();
  broken = not_finite();
  factored = values;
  ready = true;
}

/// The solver of A^T, with its numbers.
RobustSolver::Impl& RobustSolver::Impl::transposed() {
  if (!twin) twin = std::make_unique<Impl>(*this, Side::transposed);
  if (twin_is_current) return *twin;
  const Symbolic& s = first.symbolic();
  each_matrix_block(s, [&](NodeId a, NodeId b, const BlockHandle& from) {
    const BlockHandle to = s.block(b, a);
    for (int j = 0; j < from.columns; ++j)
      for (int i = 0; i < from.rows; ++i) twin->values[to.place(j, i)] = first.matrix()[from.place(i, j)];
  });
  twin->factorize();
  twin_is_current = true;
  return *twin;
}

/// After the first rung has solved for all columns, if it could.
RobustSolver::Report RobustSolver::Impl::solve_column(const Columns& columns, int c, Side of) {
  Report report;
  report.outcome = outcome;
  report.column = c;
  Search search{.b = columns.right(c)};
  const auto fail = [&](Status status, std::string why) {
    report.status = status;
    report.why = std::move(why);
    report.unsolved = 1;
    if (!search.best) report.backward_error = none_found;
    return report;
  };
  if (std::string found = not_finite(search.b); !found.empty()) return fail(Status::not_finite, std::move(found));
  bool solved = false;
  if (outcome.ok()) {
    if (of == Side::plain && !contradictions[c].empty()) return fail(Status::singular, contradictions[c]);
    const std::span<double> x = std::span(solutions).subspan(c * rows(), rows());
    const auto refined = of == Side::plain ? first.refine(search.b, x, options.max_sweeps)
                                           : first.refine_transposed(search.b, x, options.max_sweeps);
    report.backward_error = refined.backward_error;
    if (refined.backward_error <= options.acceptable) {
      std::copy(x.begin(), x.end(), columns.solution(c).begin());
      return report;
    }
    if (of == Side::plain)
      solved = judge(search, {Rung::factorization, Eigen::Map<const Eigen::VectorXd>(x.data(), graph->rows()),
                              refined.backward_error});
  } else {
    note(search, Rung::factorization, bad_pivot(first, outcome));
  }
  if (of == Side::transposed) {
    report = transposed().solve({search.b, columns.solution(c), 1, rows()}, Side::plain);
    report.column = c;
    return report;
  }
  solved = solved || try_reordered(search) || try_shifted(search) || try_general(search);
  if (search.best) {
    report.rung = search.best->rung;
    report.backward_error = search.best->error;
  }
  if (!solved) {
    const Status status = unsolved(search);
    return fail(status, std::move(search.why));
  }
  report.why = std::move(search.why);
  std::copy(search.best->x.begin(), search.best->x.end(), columns.solution(c).begin());
  return report;
}

RobustSolver::Report RobustSolver::Impl::solve(const Columns& columns, Side of) {
  if (!broken.empty()) {
    Report report;
    report.status = Status::not_finite;
    report.why = broken;
    report.backward_error = none_found;
    report.outcome = outcome;
    report.unsolved = columns.count;
    return report;
  }
  // Which rows depend is known of the matrix that was factored, not of the other.
  if (of == Side::transposed && (!outcome.ok() || outcome.dropped_rows > 0))
    return transposed().solve(columns, Side::plain);
  if (outcome.ok()) {
    if (solutions.size() < columns.b.size()) solutions.resize(columns.b.size());
    const auto all = std::span(solutions).first(columns.b.size());
    std::copy(columns.b.begin(), columns.b.end(), all.begin());
    of == Side::plain ? first.solve(all, columns.count) : first.solve_transposed(all, columns.count);
    find_contradictions(columns);
  }
  Report worst = solve_column(columns, 0, of);
  for (int c = 1; c < columns.count; ++c) {
    Report report = solve_column(columns, c, of);
    const int unsolved = worst.unsolved + report.unsolved;
    if (worse(report, worst)) worst = std::move(report);
    worst.unsolved = unsolved;
  }
  return worst;
}

RobustSolver::RobustSolver(BlockGraph graph, Options options)
    : impl_(std::make_unique<Impl>(std::move(graph), std::move(options))) {}
RobustSolver::~RobustSolver() = default;
RobustSolver::RobustSolver(RobustSolver&&) noexcept = default;
RobustSolver& RobustSolver::operator=(RobustSolver&&) noexcept = default;

const BlockGraph& RobustSolver::graph() const { return *impl_->graph; }
const Ordering& RobustSolver::ordering() const { return impl_->ordering; }
const Symbolic& RobustSolver::symbolic() const { return impl_->first.symbolic(); }
std::span<double> RobustSolver::values() { return impl_->values; }
const Factorization& RobustSolver::factorization() const { return impl_->first; }

const Factorization::Outcome& RobustSolver::factorize() {
  impl_->factorize();
  return impl_->outcome;
}

RobustSolver::Report RobustSolver::Impl::solve_checked(std::span<const double> b, std::span<double> x, int columns, Side of) {
  if (columns < 1)
    throw std::invalid_argument("there must be at least one right-hand side, not " + std::to_string(columns));
  const std::size_t expected = rows() * static_cast<std::size_t>(columns);
  if (b.size() != expected || x.size() != expected)
    throw std::invalid_argument("b has " + std::to_string(b.size()) + " numbers and x " + std::to_string(x.size()) +
                                ", expected " + std::to_string(expected) + " in each");
  if (b.data() != x.data()) check_apart("solve", b, x);  // a column of b is read to the end before its solution is written
  if (!ready || factored != values) factorize();
  return solve({b, x, columns, rows()}, of);
}

RobustSolver::Report RobustSolver::solve(std::span<const double> b, std::span<double> x, int columns) {
  return impl_->solve_checked(b, x, columns, Side::plain);
}

RobustSolver::Report RobustSolver::solve_transposed(std::span<const double> b, std::span<double> x, int columns) {
  const bool own = impl_->options.kind == FactorizationKind::ldu;
  return impl_->solve_checked(b, x, columns, own ? Side::transposed : Side::plain);
}

}  // namespace graphsolve
