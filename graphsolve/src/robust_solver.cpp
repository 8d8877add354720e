#include "graphsolve/robust_solver.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>

#include "graphsolve/io/block_view.hpp"
#include "kept_matrix.hpp"
#include "threshold_pivoting.hpp"

namespace graphsolve {

namespace {

constexpr double stiff = 1e6;    ///< a node this much larger than its neighbours is eliminated later
constexpr double shift = 1e-8;   ///< of what was added to a saddle row; 1e-6 spoils it (algorithm.md 5)
constexpr double consistent = 1e-9;
constexpr double certain = 1e3;  ///< a contradiction is that many times larger than the doubt about the dependency
constexpr double rounding = 1e-14;  ///< rows that miss a dependency by more are independent, if only just

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

bool better(double error, double than) { return error < than || std::isnan(than); }

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

struct RobustSolver::Impl {
  BlockGraph graph;
  Options options;
  Ordering ordering;
  Factorization first;
  std::vector<double> values;
  std::vector<double> factored;  ///< values as they were factored; empty: not yet
  Factorization::Outcome outcome;
  // Made when needed, dropped when the values change.
  struct Retry {
    Factorization factorization;
    Factorization::Outcome outcome;
  };
  std::optional<Retry> reordered, shifted;
  std::optional<ThresholdPivoting> general;

  struct Attempt {
    Rung rung;
    Eigen::VectorXd x;
    double error;
  };
  struct Search {
    Eigen::VectorXd b;
    std::optional<Attempt> best;
    std::string why;
  };

  Impl(BlockGraph g, Options o)
      : graph(std::move(g)), options(std::move(o)), ordering(minimum_fill_ordering(graph)),
        first(std::make_shared<const Symbolic>(graph, ordering), options.kind), values(first.values().size()) {
    first.allow_refinement();
    first.keep_matrix(true);
  }

  void note(Search& search, Rung rung, const std::string& what) const {
    if (!search.why.empty()) search.why += "; ";
    search.why += std::string(name(rung)) + ": " + what;
  }

  void factorize() {
    std::copy(values.begin(), values.end(), first.values().begin());
    reordered.reset();
    shifted.reset();
    general.reset();
    outcome = first.factorize();
    factored = values;
  }

  std::string bad_pivot(const Factorization& f, const Factorization::Outcome& o) const {
    return "block '" + std::string(graph.name(f.symbolic().node(o.first_bad_pivot))) + "' " +
           (f.kind() == FactorizationKind::cholesky ? "is not positive definite" : "has no usable pivot");
  }

  /// True when this attempt is good enough.
  bool judge(Search& search, Attempt attempt) const {
    const bool good = attempt.error <= options.acceptable;
    if (!good) note(search, attempt.rung, "backward error " + number(attempt.error));
    if (!search.best || better(attempt.error, search.best->error)) search.best = std::move(attempt);
    return good;
  }

  bool try_factors(Search& search, Rung rung, Factorization& f, const Factorization::Outcome& o) const {
    if (!o.ok()) {
      note(search, rung, bad_pivot(f, o));
      return false;
    }
    Eigen::VectorXd x = search.b;
    const auto size = static_cast<std::size_t>(x.size());
    f.solve({x.data(), size});
    const auto refined = f.refine({search.b.data(), size}, {x.data(), size}, options.max_sweeps);
    return judge(search, {rung, std::move(x), refined.backward_error});
  }

  /// The matrix factored in another order, or with a shift.
  Retry retry(const Ordering& order, double saddle_shift) const {
    Factorization f(std::make_shared<const Symbolic>(graph, order), options.kind);
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

  double largest_diagonal(NodeId node) const {
    const BlockHandle h = first.symbolic().block(node, node);
    double largest = 0;
    for (int i = 0; i < h.rows; ++i) largest = std::max(largest, std::abs(values[h.place(i, i)]));
    return largest;
  }

  /// Nodes that should wait: much larger than some neighbour of their kind of unknown, or where the elimination ended.
  std::vector<char> late_nodes() const {
    std::vector<char> late(graph.size());
    for (int k = 0; k < graph.size(); ++k)
      for (const auto& edge : graph.edges({k})) {
        const double own = largest_diagonal({k}), other = largest_diagonal(edge.to);
        if (other > 0 && own > stiff * other) late[k] = 1;
      }
    if (!outcome.ok()) late[first.symbolic().node(outcome.first_bad_pivot).index] = 1;
    return late;
  }

  bool try_reordered(Search& search) {
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
    reordered.emplace(retry(user_ordering(graph, sequence), 0));
    return try_factors(search, Rung::reordered, reordered->factorization, reordered->outcome);
  }

  bool try_shifted(Search& search) {
    bool saddle = false;
    for (int k = 0; k < graph.size(); ++k) saddle = saddle || graph.kind({k}) == NodeKind::saddle;
    if (!saddle || options.kind == FactorizationKind::cholesky) return false;
    if (!shifted) shifted.emplace(retry(ordering, shift));
    return try_factors(search, Rung::shifted, shifted->factorization, shifted->outcome);
  }

  bool try_general(Search& search) {
    if (!general) general.emplace(sparse_matrix(first.symbolic(), first.matrix()), options.fallback);
    auto result = general->solve(search.b, options.max_sweeps);
    if (result.why.empty()) return judge(search, {Rung::threshold_pivoting, std::move(result.x), result.backward_error});
    note(search, Rung::threshold_pivoting, result.why);
    return false;
  }

  /// How far y^T A is from zero: largest |y^T A|_j over largest (|y|^T |A|)_j, each column being measured by its own
  /// largest entry.
  double remainder(const Eigen::VectorXd& y) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(y.size()), magnitude = sum, size = sum;
    each_matrix_block(first.symbolic(), [&](NodeId r, NodeId c, const BlockHandle& h) {
      const ConstBlockView block = block_view(first.matrix(), h);
      const auto part = y.segment(graph.row(r), h.rows);
      const Eigen::Index column = graph.row(c);
      sum.segment(column, h.columns) += block.transpose() * part;
      magnitude.segment(column, h.columns) += block.cwiseAbs().transpose() * part.cwiseAbs();
      for (int j = 0; j < h.columns; ++j) size[column + j] = std::max(size[column + j], block.col(j).cwiseAbs().maxCoeff());
    });
    double left = 0, of = 0;
    for (Eigen::Index j = 0; j < y.size(); ++j) {
      if (!(size[j] > 0)) continue;
      left = std::max(left, std::abs(sum[j]) / size[j]);
      of = std::max(of, magnitude[j] / size[j]);
    }
    return of > 0 ? left / of : 0;
  }

  /// Names the redundant rows whose right-hand sides contradict each other; empty: none.
  std::string contradiction(const Eigen::VectorXd& b) const {
    Eigen::VectorXd y(b.size());
    for (const auto& dropped : first.dropped_rows()) {
      first.dependency(dropped, {y.data(), static_cast<std::size_t>(y.size())});
      const double against = std::abs(y.dot(b)), size = y.cwiseAbs().dot(b.cwiseAbs());
      if (!(against > consistent * size)) continue;
      // Rows left out because rounding took what made them independent do not contradict anything.
      const double missed = remainder(y);
      if (missed > rounding || !(against > certain * missed * size)) continue;
      std::string names;
      for (int k = 0; k < graph.size(); ++k) {
        const auto part = y.segment(graph.row({k}), graph.dimension({k}));
        if (part.cwiseAbs().maxCoeff() > consistent * y.cwiseAbs().maxCoeff())
          names += (names.empty() ? "'" : ", '") + std::string(graph.name({k})) + "'";
      }
      return "no solution: the rows of " + names + " depend on each other, and the right-hand side contradicts that";
    }
    return {};
  }

  /// The first number that is not one.
  std::string not_finite(const Eigen::VectorXd& b) const {
    std::string found;
    each_matrix_block(first.symbolic(), [&](NodeId r, NodeId c, const BlockHandle& h) {
      for (int i = 0; i < h.rows * h.columns && found.empty(); ++i)
        if (const double value = first.matrix()[h.place(i % h.rows, i / h.rows)]; !std::isfinite(value))
          found = "entry (" + std::to_string(i % h.rows) + ", " + std::to_string(i / h.rows) + ") of block ('" +
                  std::string(graph.name(r)) + "', '" + std::string(graph.name(c)) + "') is " + number(value);
    });
    for (int k = 0; k < graph.size() && found.empty(); ++k)
      for (int i = 0; i < graph.dimension({k}) && found.empty(); ++i)
        if (const double value = b[graph.row({k}) + i]; !std::isfinite(value))
          found = "right-hand side " + std::to_string(i) + " of '" + std::string(graph.name({k})) + "' is " + number(value);
    return found;
  }
};

RobustSolver::RobustSolver(BlockGraph graph, Options options)
    : impl_(std::make_unique<Impl>(std::move(graph), std::move(options))) {}
RobustSolver::~RobustSolver() = default;
RobustSolver::RobustSolver(RobustSolver&&) noexcept = default;
RobustSolver& RobustSolver::operator=(RobustSolver&&) noexcept = default;

const BlockGraph& RobustSolver::graph() const { return impl_->graph; }
const Symbolic& RobustSolver::symbolic() const { return impl_->first.symbolic(); }
std::span<double> RobustSolver::values() { return impl_->values; }
const Factorization& RobustSolver::factorization() const { return impl_->first; }

const Factorization::Outcome& RobustSolver::factorize() {
  impl_->factorize();
  return impl_->outcome;
}

RobustSolver::Report RobustSolver::solve(std::span<const double> b, std::span<double> x) {
  Impl& s = *impl_;
  const auto rows = static_cast<std::size_t>(s.graph.rows());
  if (b.size() != rows || x.size() != rows)
    throw std::invalid_argument("b has " + std::to_string(b.size()) + " numbers and x " + std::to_string(x.size()) +
                                ", expected " + std::to_string(rows) + " in each");
  if (s.factored != s.values) s.factorize();
  Report report;
  report.outcome = s.outcome;
  Impl::Search search;
  search.b = Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size()));
  const auto fail = [&](Status status, std::string why) {
    report.status = status;
    report.why = std::move(why);
    return report;
  };
  if (std::string found = s.not_finite(search.b); !found.empty()) return fail(Status::not_finite, std::move(found));
  if (s.outcome.ok())
    if (std::string found = s.contradiction(search.b); !found.empty()) return fail(Status::singular, std::move(found));
  const bool solved = s.try_factors(search, Rung::factorization, s.first, s.outcome) || s.try_reordered(search) ||
                      s.try_shifted(search) || s.try_general(search);
  if (search.best) {
    report.rung = search.best->rung;
    report.backward_error = search.best->error;
  }
  if (!solved) return fail(Status::singular, std::move(search.why));
  report.why = std::move(search.why);
  std::copy(search.best->x.begin(), search.best->x.end(), x.begin());
  return report;
}

}  // namespace graphsolve
