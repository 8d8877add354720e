#include "solve_engine.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "graphsolve/diagnosis.hpp"
#include "graphsolve/entry_map.hpp"
#include "graphsolve/io/draw.hpp"
#include "graphsolve/largest.hpp"
#include "graphsolve/robust_solver.hpp"
#include "timing.hpp"

namespace cli {

using namespace graphsolve;

namespace {

const char* name_of(FactorizationKind kind) {
  return kind == FactorizationKind::cholesky ? "cholesky" : kind == FactorizationKind::ldlt ? "ldlt" : "ldu";
}

std::vector<FactorizationKind> ladder(const MatrixSource& source, const SolveRequest& request) {
  using enum FactorizationKind;
  if (request.kind) return {*request.kind};
  if (!source.blocks.symmetric) return {ldu};
  bool positive = true;  // can it be positive definite at all?
  const SparseMatrix& matrix = source.file.matrix;
  std::vector<double> diagonal(static_cast<std::size_t>(matrix.rows), 0.0);
  for (int j = 0; j < matrix.columns; ++j)
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k)
      if (matrix.row[k] == j) diagonal[j] = matrix.value[k];
  for (const double d : diagonal) positive = positive && d > 0;
  if (positive) return {cholesky, ldlt, ldu};
  return {ldlt, ldu};
}

/// Throws std::invalid_argument where the factor alone would take more memory than the machine has. Each fill block has its numbers
/// and at least three words in tables.
void expect_to_fit(const BlockGraph& graph, const Ordering& ordering) {
  const double machine = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  const double words = machine / sizeof(double);
  if (!(machine > 0)) return;  // not known
  std::int64_t ends = 0;
  for (int k = 0; k < graph.size(); ++k) ends += static_cast<std::int64_t>(graph.edges({k}).size());
  constexpr int tables = 3, numbers = 2;
  const PredictedCost cost = predict_cost(graph, ordering, static_cast<std::int64_t>(words / (tables + numbers)) + ends / 2 + 1);
  if (static_cast<double>(cost.stored_scalars) + tables * static_cast<double>(cost.fill_blocks) <= words) return;
  throw std::invalid_argument(
      fmt::format("in the order '{}' the matrix fills so much that its factor would take more than the {:.0f} GB of this machine; "
                  "take another --ordering ('graphsolve analyze' compares them), or merge rows into blocks with --blocks",
                  name(ordering.method), machine / 1e9));
}

/// Everything one run works on.
struct Run {
  const MatrixSource& source;
  const SparseMatrix& of_system;  ///< A or A^T: what solutions are judged by
  std::span<const double> b;
  int columns;
  System system;
  SolveResult& result;
  [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(source.file.matrix.rows); }
  [[nodiscard]] std::span<const double> column_of_b(int c) const { return b.subspan(c * rows(), rows()); }
  [[nodiscard]] std::span<double> column_of_x(int c) const { return std::span(result.x).subspan(c * rows(), rows()); }
};

void judge(const Run& run, Attempt& attempt) {
  for (int c = 0; c < run.columns; ++c) {
    const BackwardError error = backward_error(run.of_system, run.column_of_b(c), run.column_of_x(c));
    // The worst of all; NaN stays.
    keep_largest(attempt.error.normwise, error.normwise);
    keep_largest(attempt.error.componentwise, error.componentwise);
  }
  if (!(attempt.error.normwise <= solved_below))
    attempt.trouble = fmt::format("backward error {:.1e} after refinement", attempt.error.normwise);
}

/// As the matrix counts: from 1.
std::string zero_row(const BlockStructure& blocks, const Diagnosis::Row& row) {
  int node = 0;
  while (blocks.graph.name({node}) != row.node) ++node;
  return fmt::format("row {} has no entry\n", blocks.matrix_rows({node})[row.row] + 1);
}

/// The lines of graphsolve's own diagnosis.
void explain(const Run& run, Diagnosis diagnosis) {
  constexpr std::size_t most = 8;
  std::string rows;
  for (std::size_t i = 0; i < std::min(diagnosis.zero_rows.size(), most); ++i)
    rows += zero_row(run.source.blocks, diagnosis.zero_rows[i]);
  if (diagnosis.zero_rows.size() > most) rows += fmt::format("and {} more rows have none\n", diagnosis.zero_rows.size() - most);
  diagnosis.zero_rows.clear();  // theirs are counted within a block
  const std::string text = rows + to_string(diagnosis);
  run.result.diagnosis.clear();
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end > at) run.result.diagnosis.push_back(text.substr(at, end - at));
    at = end + 1;
  }
}

std::string bad_pivot(const Run& run, const Symbolic& symbolic, int pivot) {
  const BlockGraph& graph = run.source.blocks.graph;
  const NodeId node = symbolic.node(pivot);
  std::string neighbours;
  for (const auto& edge : graph.edges(node).first(std::min<std::size_t>(4, graph.edges(node).size())))
    neighbours += fmt::format("{}'{}'", neighbours.empty() ? "" : ", ", graph.name(edge.to));
  return fmt::format("block '{}' ({})", graph.name(node),
                     neighbours.empty() ? "without neighbours" : "neighbours " + neighbours);
}

/// Returns the sweeps of refinement.
int solve_refined(System system, Factorization& factor, std::span<const double> right, std::vector<double>& solution) {
  constexpr int most = 10;
  if (system == System::plain) {
    factor.solve(solution);
    return factor.refine(right, solution, most).sweeps;
  }
  factor.solve_transposed(solution);
  return factor.refine_transposed(right, solution, most).sweeps;
}

bool try_graph(const Run& run, const std::shared_ptr<const Symbolic>& symbolic, FactorizationKind kind) {
  Attempt attempt{.method = name_of(kind), .trouble = {}, .outcome = {}, .error = {}};
  const double start = timing::thread_time();
  Factorization factor(symbolic, kind);
  factor.allow_refinement();
  factor.keep_matrix(true);
  EntryMap(run.source.file.matrix, run.source.blocks, *symbolic).write(run.source.file.matrix.value, factor.values());
  const double ready = timing::thread_time();
  attempt.outcome = factor.factorize();
  const double factored = timing::thread_time();
  attempt.setup_seconds = ready - start;
  attempt.factor_seconds = factored - ready;
  if (!attempt.outcome.ok()) {
    const std::string where = bad_pivot(run, *symbolic, attempt.outcome.first_bad_pivot);
    attempt.trouble = kind == FactorizationKind::cholesky ? "not positive definite at " + where : "singular pivot at " + where;
    attempt.error = {std::nan(""), std::nan("")};
  } else {
    std::vector<double> right(run.rows()), solution(run.rows());
    for (int c = 0; c < run.columns; ++c) {
      run.source.blocks.to_graph(run.column_of_b(c), right);
      solution = right;
      attempt.sweeps = std::max(attempt.sweeps, solve_refined(run.system, factor, right, solution));
      run.source.blocks.to_matrix(solution, run.column_of_x(c));
    }
    attempt.solve_seconds = timing::thread_time() - factored;
    judge(run, attempt);
    run.result.singular = is_singular(factor, attempt.outcome);
    if (run.result.singular) explain(run, diagnose(run.source.blocks.graph, factor, attempt.outcome));
    else if (attempt.outcome.dropped_rows > 0) attempt.trouble = "left out rows that do not depend on others";
  }
  run.result.attempts.push_back(attempt);
  return attempt.trouble.empty();
}

/// graphsolve's own chain: reordering, proximal shift, threshold pivoting; and its diagnosis when all fail.
bool try_robust(const Run& run, OrderingMethod ordering) {
  Attempt attempt{.method = "robust", .trouble = {}, .outcome = {}, .error = {}};
  const double start = timing::thread_time();
  RobustSolver solver(run.source.blocks.graph,
                      {.kind = run.source.blocks.symmetric ? FactorizationKind::ldlt : FactorizationKind::ldu,
                       .ordering = ordering});
  EntryMap(run.source.file.matrix, run.source.blocks, solver.symbolic()).write(run.source.file.matrix.value, solver.values());
  const double ready = timing::thread_time();
  attempt.outcome = solver.factorize();
  const double factored = timing::thread_time();
  attempt.setup_seconds = ready - start;
  attempt.factor_seconds = factored - ready;
  std::vector<double> right(run.b.size()), solution(run.b.size());
  for (int c = 0; c < run.columns; ++c)
    run.source.blocks.to_graph(run.column_of_b(c), std::span(right).subspan(c * run.rows(), run.rows()));
  const RobustSolver::Report report = run.system == System::plain  // of the worst
                                          ? solver.solve(right, solution, run.columns)
                                          : solver.solve_transposed(right, solution, run.columns);
  attempt.method = fmt::format("robust: {}", name(report.rung));
  attempt.reason = report.why;
  if (run.columns > 1 && !report.why.empty()) attempt.reason = fmt::format("right-hand side {}: {}", report.column + 1, report.why);
  attempt.solve_seconds = timing::thread_time() - factored;
  if (report.unsolved == 0) {
    for (int c = 0; c < run.columns; ++c)
      run.source.blocks.to_matrix(std::span(solution).subspan(c * run.rows(), run.rows()), run.column_of_x(c));
    judge(run, attempt);
  } else {
    attempt.trouble = "no solution found";
    if (run.columns > 1) attempt.trouble += fmt::format(" for {} of {} right-hand sides", report.unsolved, run.columns);
    attempt.error = {std::nan(""), std::nan("")};
  }
  run.result.singular = is_singular(solver.factorization(), attempt.outcome);
  if (!attempt.trouble.empty() || run.result.singular)
    explain(run, diagnose(run.source.blocks.graph, solver.factorization(), attempt.outcome));
  run.result.attempts.push_back(attempt);
  return attempt.trouble.empty();
}

}  // namespace

SolveResult solve_system(const MatrixSource& source, std::span<const double> b, const SolveRequest& request) {
  SolveResult result;
  result.x.assign(b.size(), 0.0);
  const bool transposed = request.system == System::transposed;
  const SparseMatrix turned = transposed ? transpose(source.file.matrix) : SparseMatrix();
  const Run run{source, transposed ? turned : source.file.matrix, b, request.columns, request.system, result};
  const BlockGraph& graph = source.blocks.graph;
  const Ordering ordering = make_ordering(graph, request.ordering);
  expect_to_fit(graph, ordering);
  const auto symbolic = std::make_shared<const Symbolic>(graph, ordering);
  result.fill_ratio = io::fill_ratio(*symbolic);
  bool good = false;
  for (const FactorizationKind kind : ladder(source, request)) {
    result.diagnosis.clear();
    if ((good = try_graph(run, symbolic, kind))) break;
  }
  if (!good) {
    result.diagnosis.clear();
    good = try_robust(run, request.ordering);
  }
  result.good = good;
  return result;
}

}  // namespace cli
