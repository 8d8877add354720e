#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "graphsolve/diagnosis.hpp"
#include "graphsolve/io/block_view.hpp"
#include "factorization/kept_matrix.hpp"
#include "robust/robust_rungs.hpp"

namespace graphsolve {

namespace {

constexpr double consistent = 1e-9;
constexpr double certain = 1e3;     ///< a contradiction is that many times larger than the doubt about the dependency
constexpr double rounding = 1e-14;  ///< rows that miss a dependency by more are independent, if only just

}  // namespace

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

/// How far y^T A is from zero: largest |y^T A|_j over largest (|y|^T |A|)_j, each column being measured by its own
/// largest entry.
double RobustSolver::Impl::remainder(const Eigen::VectorXd& y) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(y.size()), magnitude = sum, size = sum;
  each_matrix_block(first.symbolic(), [&](NodeId r, NodeId c, const BlockHandle& h) {
    const ConstBlockView block = block_view(first.matrix(), h);
    const auto part = y.segment(graph->row(r), h.rows);
    const Eigen::Index column = graph->row(c);
    sum.segment(column, h.columns) += block.transpose() * part;
    magnitude.segment(column, h.columns) += block.cwiseAbs().transpose() * part.cwiseAbs();
    for (int j = 0; j < h.columns; ++j)
      size[column + j] = std::max(size[column + j], block.col(j).cwiseAbs().maxCoeff());
  });
  double left = 0, of = 0;
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    if (!(size[j] > 0)) continue;
    left = std::max(left, std::abs(sum[j]) / size[j]);
    of = std::max(of, magnitude[j] / size[j]);
  }
  return of > 0 ? left / of : 0;
}

/// Names, for each column, the redundant rows whose right-hand sides contradict each other.
void RobustSolver::Impl::find_contradictions(const Columns& columns) {
  contradictions.resize(std::max(contradictions.size(), static_cast<std::size_t>(columns.count)));
  for (std::string& text : contradictions) text.clear();
  if (first.dropped_rows().empty()) return;
  null.resize(rows());
  const Eigen::Map<const Eigen::VectorXd> y(null.data(), graph->rows());
  for (const auto& dropped : first.dropped_rows()) {
    first.dependency(dropped, null);
    for (int c = 0; c < columns.count; ++c) {
      const Eigen::Map<const Eigen::VectorXd> b(columns.right(c).data(), graph->rows());
      const double against = std::abs(y.dot(b)), size = y.cwiseAbs().dot(b.cwiseAbs());
      if (!contradictions[c].empty() || !(against > consistent * size)) continue;
      // Rows left out because rounding took what made them independent do not contradict anything.
      const double missed = remainder(y);
      if (missed > rounding || !(against > certain * missed * size)) continue;
      std::string names;
      for (int k = 0; k < graph->size(); ++k) {
        const auto part = y.segment(graph->row({k}), graph->dimension({k}));
        if (part.cwiseAbs().maxCoeff() > consistent * y.cwiseAbs().maxCoeff())
          names += (names.empty() ? "'" : ", '") + std::string(graph->name({k})) + "'";
      }
      contradictions[c] = std::string("no solution: the ") + (side == Side::plain ? "rows" : "columns") + " of " + names +
                          " depend on each other, and the right-hand side contradicts that";
    }
  }
}

/// The first number of the matrix that is not one; empty: there is none.
std::string RobustSolver::Impl::not_finite() const {
  std::string found;
  each_matrix_block(first.symbolic(), [&](NodeId r, NodeId c, const BlockHandle& h) {
    for (int i = 0; i < h.rows * h.columns && found.empty(); ++i)
      if (const double value = first.matrix()[h.place(i % h.rows, i / h.rows)]; !std::isfinite(value))
        found = "entry (" + std::to_string(i % h.rows) + ", " + std::to_string(i / h.rows) + ") of block ('" +
                std::string(graph->name(r)) + "', '" + std::string(graph->name(c)) + "') is " + short_number(value);
  });
  return found;
}

std::string RobustSolver::Impl::not_finite(std::span<const double> b) const {
  for (int k = 0; k < graph->size(); ++k)
    for (int i = 0; i < graph->dimension({k}); ++i)
      if (const double value = b[graph->row({k}) + i]; !std::isfinite(value))
        return "right-hand side " + std::to_string(i) + " of '" + std::string(graph->name({k})) + "' is " +
               short_number(value);
  return {};
}

/// What it is called when no rung was good enough. A matrix is not singular because numbers outgrew the range of doubles.
Status RobustSolver::Impl::unsolved(Search& search) const {
  const bool singular = is_singular(first, outcome);
  search.why += singular ? "; the matrix is singular" : "; the matrix is not singular";  // every rung has said something
  if (singular) return Status::singular;
  if (!search.best) return Status::stalled;
  if (!search.best->x.allFinite() || !std::isfinite(search.best->error)) {
    search.why += ", numbers on the way to the solution are too large for doubles";
    return Status::not_finite;
  }
  if (search.best->x.cwiseAbs().maxCoeff() < std::numeric_limits<double>::min())
    search.why += ", its solution is too small for doubles";
  return Status::stalled;
}

}  // namespace graphsolve
