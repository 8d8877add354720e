#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <string>

#include "graphsolve/robust_solver.hpp"
#include "robust/scales.hpp"

namespace graphsolve {

/// The last rung of RobustSolver: the matrix without its blocks, factored by Eigen::SparseLU after its rows and columns
/// were scaled to largest entries near 1, or left to the given solver as it is; then refined.
class ThresholdPivoting {
 public:
  /// `why` says what is wrong; empty: nothing, and x solves A x = b up to the componentwise backward error.
  struct Result {
    std::string why;
    Eigen::VectorXd x;
    double backward_error = 0;
  };
  ThresholdPivoting(Eigen::SparseMatrix<double> matrix, RobustSolver::Fallback given);
  [[nodiscard]] Result solve(const Eigen::VectorXd& b, int max_sweeps);

 private:
  bool solve_once(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  Eigen::SparseMatrix<double> matrix_;
  RobustSolver::Fallback given_;
  Scales scales_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu_;
  bool regular_ = true;
};

}  // namespace graphsolve
