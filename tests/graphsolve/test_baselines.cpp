#ifdef GRAPHSOLVE_HAS_BASELINES

#include <gtest/gtest.h>

#include "baselines/baselines.hpp"
#include "factorization_cases.hpp"
#include "support/problem_families.hpp"

namespace test_baselines {

using namespace families;
using cases::view;

/// Backward error, or -1 with the reason printed.
double solved(baselines::Baseline& baseline, const Eigen::SparseMatrix<double>& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd x(b.size());
  baselines::Status status = baseline.analyze(a);
  // Twice: the second time the numbers are new and the analysis is not.
  for (int time = 0; time < 2; ++time) {
    if (status.ok) status = baseline.refactor({a.valuePtr(), static_cast<std::size_t>(a.nonZeros())});
    if (status.ok) status = baseline.solve(view(b), view(x));
  }
  if (status.ok) return backward_error(a, view(x), view(b));
  std::printf("%s: %s\n", std::string(baseline.name()).c_str(), status.why.c_str());
  return -1;
}

TEST(Baselines, SolveWhatTheyAreMadeFor) {
  for (const Family family : all_families())
    for (const Values values : {Values::symmetric, Values::unsymmetric}) {
      const Problem problem = make_problem({.family = family, .n = 30, .values = values});
      for (const auto& baseline : baselines::all()) {
        if (values == Values::unsymmetric && baseline->demand() != baselines::Demand::any) continue;
        const bool twin = baseline->demand() == baselines::Demand::positive_definite;
        const double error = solved(*baseline, twin ? baselines::positive_definite_twin(problem.matrix) : problem.matrix,
                                    problem.right);
        EXPECT_GE(error, 0) << baseline->name() << ", " << problem.name;
        // The packages without pivoting lose digits to C = 1e-3.
        EXPECT_LE(error, 1e-8) << baseline->name() << ", " << problem.name;
      }
    }
}

TEST(Baselines, SayWhyTheyFail) {
  Eigen::SparseMatrix<double> zero_first(2, 2);  // [0 1; 1 0]
  zero_first.insert(0, 0) = 0;
  zero_first.insert(1, 0) = 1;
  zero_first.insert(0, 1) = 1;
  zero_first.insert(1, 1) = 0;
  zero_first.makeCompressed();
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(2);
  for (const auto& baseline : baselines::all()) {
    const double error = solved(*baseline, zero_first, b);
    EXPECT_EQ(error, baseline->demand() == baselines::Demand::any ? 0 : -1) << baseline->name();
  }
  Eigen::SparseMatrix<double> singular = zero_first;
  for (double* value = singular.valuePtr(); value != singular.valuePtr() + 4; ++value) *value = 1;
  for (const auto& baseline : baselines::all()) EXPECT_EQ(solved(*baseline, singular, b), -1) << baseline->name();
}

}  // namespace test_baselines

#endif
