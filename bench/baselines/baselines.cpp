#include "baselines/baselines.hpp"

#include <SuiteSparse_config.h>

#include <cmath>

namespace baselines {

std::vector<std::unique_ptr<Baseline>> all() {
  std::vector<std::unique_ptr<Baseline>> list;
  list.push_back(cholmod_simplicial());
  list.push_back(cholmod_supernodal());
  list.push_back(umfpack());
  list.push_back(klu());
  list.push_back(eigen_ldlt());
  list.push_back(eigen_lu());
  return list;
}

Eigen::SparseMatrix<double> positive_definite_twin(const Eigen::SparseMatrix<double>& a) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(a.cols());
  for (int j = 0; j < a.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry)
      if (entry.row() != j) sum[j] += std::abs(entry.value());
  Eigen::SparseMatrix<double> twin = a;
  for (int j = 0; j < twin.outerSize(); ++j) twin.coeffRef(j, j) = 1 + 2 * sum[j];
  twin.makeCompressed();
  return twin;
}

std::string versions() {
  const auto dotted = [](int a, int b, int c) {
    return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
  };
  return "SuiteSparse " + dotted(SUITESPARSE_MAIN_VERSION, SUITESPARSE_SUB_VERSION, SUITESPARSE_SUBSUB_VERSION) +
         ", Eigen " + dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
}

}  // namespace baselines
