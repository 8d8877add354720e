#include "gradients/normals_first.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

/// Part of a disturbance of a normal's rate that it lets pass, from which on it counts as yielding. Stiffness alone
/// lets 1e-7 pass, where masses differ by 1e6 some 1e-4.
constexpr double yields = 1e-4;
/// Normals that hold one motion twice, and those that joints hold, have no share of their own.
constexpr double no_share = 1e-6;

using ConstMap6 = Eigen::Map<const Vector6>;
using Map6 = Eigen::Map<Vector6>;

}  // namespace

void NormalsFirst::find(const graphsolve::Factorization& matrix, const Sensitivity& sensitivity,
                        std::span<double> probe, std::span<double> scratch) {
  yielding_.clear();
  const auto& pressing = sensitivity.pressing;
  if (pressing.empty() || !sensitivity.something_sticks) return;
  const auto pressed = [](const Press& p, std::span<const double> z) { return p.force.dot(ConstMap6(z.data() + p.row)); };
  const auto answer = [&](std::span<const double> z) {  // scratch := S^T J^T C^T z
    std::fill(scratch.begin(), scratch.end(), 0.0);
    for (const Press& p : pressing) Map6(scratch.data() + p.row) += p.rate * pressed(p, z);
    matrix.solve_transposed(scratch);
  };
  matrix.solve_transposed(probe);
  answer(probe);
  for (std::size_t i = 0; i < probe.size(); ++i) probe[i] -= scratch[i];
  double largest = 0;  // of what the normals let pass
  for (const Press& p : pressing) largest = std::max(largest, std::abs(pressed(p, probe)));
  if (largest <= yields) return;
  answer(probe);  // part of which may be what no normal could hold
  const double least = std::max(yields, no_share * largest);
  for (std::size_t i = 0; i < pressing.size(); ++i)
    if (std::abs(pressed(pressing[i], scratch)) > least) yielding_.push_back(static_cast<int>(i));
  if (!yielding_.empty()) make_rigid(matrix, sensitivity, probe.size());
}

void NormalsFirst::make_rigid(const graphsolve::Factorization& matrix, const Sensitivity& sensitivity,
                              std::size_t rows) {
  const auto& pressing = sensitivity.pressing;
  const auto count = static_cast<Eigen::Index>(yielding_.size());
  response_.setZero(static_cast<Eigen::Index>(rows), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Press& p = pressing[yielding_[j]];
    response_.col(j).segment<6>(p.row) = p.rate;
  }
  matrix.solve_transposed({response_.data(), static_cast<std::size_t>(response_.size())}, static_cast<int>(count));
  Eigen::MatrixXd shares(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Press& p = pressing[yielding_[i]];
    shares.row(i).noalias() = p.force.transpose() * response_.middleRows<6>(p.row);
  }
  shares_.setThreshold(no_share);
  shares_.compute(shares);
}

void NormalsFirst::apply(const Sensitivity& sensitivity, std::span<double> adjoint, std::span<double> state) const {
  const auto count = static_cast<Eigen::Index>(yielding_.size());
  Eigen::VectorXd pressed(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Press& p = sensitivity.pressing[yielding_[i]];
    pressed[i] = p.force.dot(ConstMap6(adjoint.data() + p.row));
  }
  const Eigen::VectorXd alpha = shares_.solve(pressed);
  Eigen::Map<Eigen::VectorXd>(adjoint.data(), response_.rows()).noalias() -= response_ * alpha;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Press& p = sensitivity.pressing[yielding_[i]];
    Map6(state.data() + 12 * p.body) -= alpha[i] * p.by_pose;
  }
}

void NormalsFirst::apply(const Sensitivity& sensitivity, Pass& adjoints) {
  const auto count = static_cast<Eigen::Index>(yielding_.size());
  Eigen::MatrixXd pressed(count, pass_columns);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Press& p = sensitivity.pressing[yielding_[i]];
    pressed.row(i).noalias() = (adjoints.middleCols<6>(p.row) * p.force).transpose();
  }
  alpha_ = shares_.solve(pressed);
  adjoints.noalias() -= alpha_.transpose() * response_.transpose();
}

void NormalsFirst::subtract_poses(const Sensitivity& sensitivity, Pass& by_state) const {
  for (std::size_t i = 0; i < yielding_.size(); ++i) {
    const Press& p = sensitivity.pressing[yielding_[i]];
    by_state.middleCols<6>(12 * p.body).noalias() -=
        alpha_.row(static_cast<Eigen::Index>(i)).transpose() * p.by_pose.transpose();
  }
}

}  // namespace physics
