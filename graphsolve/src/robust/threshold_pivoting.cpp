#include "robust/threshold_pivoting.hpp"

#include <cmath>

#include "factorization/twice_precision.hpp"

namespace graphsolve {

namespace {

constexpr int patience = 3;        ///< sweeps in a row that may bring nothing

/// max |b - A x|_i / (|A| |x| + |b|)_i, and the residual, taken in twice the precision; NaN stays.
double backward_error(const Eigen::SparseMatrix<double>& a, const Eigen::VectorXd& b, const Eigen::VectorXd& x,
                      Eigen::VectorXd& residual) {
  Eigen::VectorXd magnitude = b.cwiseAbs(), low = Eigen::VectorXd::Zero(b.size());
  residual = b;
  for (int j = 0; j < a.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry) {
      subtract_product(residual[entry.row()], low[entry.row()], entry.value(), x[j]);
      magnitude[entry.row()] += std::abs(entry.value() * x[j]);
    }
  residual += low;
  double error = 0;
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    if (magnitude[i] == 0) continue;
    const double e = std::abs(residual[i]) / magnitude[i];
    if (e > error || std::isnan(e)) error = e;
  }
  return error;
}

}  // namespace

ThresholdPivoting::ThresholdPivoting(Eigen::SparseMatrix<double> matrix, RobustSolver::Fallback given)
    : matrix_(std::move(matrix)), given_(std::move(given)) {
  if (given_) return;
  scales_ = scales_of(matrix_);  // a pivot is chosen by size: without these by the units of its row
  lu_.compute(scales_.applied_to(matrix_));
  regular_ = lu_.info() == Eigen::Success;
}

bool ThresholdPivoting::solve_once(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  if (!given_) {
    x = scales_.column.cwiseProduct(lu_.solve(scales_.row.cwiseProduct(b)).eval());
    return true;
  }
  const auto n = static_cast<std::size_t>(b.size());
  const auto nonzeros = static_cast<std::size_t>(matrix_.nonZeros());
  x.setZero(b.size());
  return given_({.rows = static_cast<int>(n),
                 .column_begin = {matrix_.outerIndexPtr(), n + 1},
                 .row_index = {matrix_.innerIndexPtr(), nonzeros},
                 .values = {matrix_.valuePtr(), nonzeros}},
                {b.data(), n}, {x.data(), n});
}

ThresholdPivoting::Result ThresholdPivoting::solve(const Eigen::VectorXd& b, int max_sweeps) {
  Result result;
  Eigen::VectorXd x, residual, correction;
  if (!regular_) result.why = "no usable pivot is left";
  else if (!solve_once(b, x)) result.why = "the given solver failed";
  if (!result.why.empty()) return result;
  const double at_first = backward_error(matrix_, b, x, residual);
  if (given_ && !(x.allFinite() && std::isfinite(at_first))) {  // not the fault of the input
    result.why = x.allFinite() ? "the given solver returned numbers too large to be checked"
                               : "the given solver returned numbers that are not finite";
    return result;
  }
  result.x = x;
  result.backward_error = at_first;
  for (int sweep = 0, in_vain = 0; sweep < max_sweeps && in_vain < patience && result.backward_error > 1e-16; ++sweep) {
    if (!solve_once(residual, correction)) break;
    x += correction;
    const double error = backward_error(matrix_, b, x, residual);
    in_vain = error <= 0.9 * result.backward_error ? 0 : in_vain + 1;
    if (!(error < result.backward_error) && !std::isnan(result.backward_error)) continue;
    result.x = x;
    result.backward_error = error;
  }
  return result;
}

}  // namespace graphsolve
