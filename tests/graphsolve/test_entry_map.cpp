#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "graphsolve/entry_map.hpp"
#include "graphsolve/cheapest_ordering.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/io/eigen.hpp"
#include "support/problem_families.hpp"

/// Places of a matrix in a factorization: whatever stood there before, what is read is the matrix and zeros.
namespace test_entry_map {

using namespace graphsolve;

using families::Family;
using families::Problem;

std::vector<int> rows_as_given(const BlockGraph& graph) {
  std::vector<int> rows(static_cast<std::size_t>(graph.rows()));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<int>(i);
  return rows;
}

TEST(EntryMap, WritesWhatEveryKindReadsOverWhateverStoodThere) {
  for (const Family family : {Family::chain, Family::tree, Family::ladder, Family::grid, Family::control})
    for (const int copies : {1, 3, 8})
      for (const Packs packs : {Packs::on, Packs::off})
        for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
          const Problem problem = families::repeated(families::make_problem({.family = family, .n = 9}), copies);
          SCOPED_TRACE(problem.name + (packs == Packs::on ? ", packs" : "") + (kind == FactorizationKind::ldlt ? ", ldlt" : ""));
          const auto symbolic = std::make_shared<const Symbolic>(problem.graph, cheapest_in_packs(problem.graph, kind), packs);
          const SparseMatrix matrix = io::from_eigen(problem.matrix);
          const BlockStructure structure{.graph = problem.graph, .row_of = rows_as_given(problem.graph)};
          const EntryMap map(matrix, structure, *symbolic, kind);
          Factorization factor(symbolic, kind);
          std::ranges::fill(factor.values(), std::numeric_limits<double>::quiet_NaN());
          for (const double scale : {1.0, 0.5}) {  // once more over the factors
            std::vector<double> values = matrix.value, x(problem.right.begin(), problem.right.end());
            for (double& value : values) value *= scale;
            map.write(values, factor.values());
            ASSERT_TRUE(factor.factorize().ok());
            factor.solve(x);
            double worst = 0;
            for (std::size_t i = 0; i < x.size(); ++i)
              worst = std::max(worst, std::abs(scale * x[i] - problem.solution[static_cast<Eigen::Index>(i)]));
            EXPECT_LE(worst, 1e-9 * (1 + problem.solution.cwiseAbs().maxCoeff()));
          }
        }
}

TEST(EntryMap, OfASymmetricKindLeavesTheBlocksOfTheOtherTriangle) {
  const Problem problem = families::make_problem({.family = Family::chain, .n = 4});
  const Symbolic symbolic(problem.graph, cheapest_in_packs(problem.graph, FactorizationKind::ldlt), Packs::off);
  const SparseMatrix matrix = io::from_eigen(problem.matrix);
  const BlockStructure structure{.graph = problem.graph, .row_of = rows_as_given(problem.graph)};
  const auto untouched = [&](const EntryMap& map) {
    std::vector<double> values(static_cast<std::size_t>(symbolic.values_size()), -7.5);
    map.write(matrix.value, values);
    return std::ranges::count(values, -7.5);
  };
  EXPECT_EQ(untouched(EntryMap(matrix, structure, symbolic)), 0);
  EXPECT_EQ(untouched(EntryMap(matrix, structure, symbolic, FactorizationKind::ldlt)), 6 * 18);  // six couplings of 3 x 6
}

}  // namespace test_entry_map
