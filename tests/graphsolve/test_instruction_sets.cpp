// The same numbers on every instruction set, pivots one by one and in packs, for every kind.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "support/problem_families.hpp"

namespace test_instruction_sets {

using namespace graphsolve;
using cases::relative;
using cases::view;
using families::Problem;

class InstructionSets : public testing::TestWithParam<simd::InstructionSet> {
 protected:
  void SetUp() override { simd::use_instruction_set(GetParam()); }
  void TearDown() override { simd::use_instruction_set(before_); }

 private:
  simd::InstructionSet before_ = simd::instruction_set();
};

struct Result {
  Factorization::Outcome outcome;
  Eigen::VectorXd x, transposed;
  int dropped = 0;
};

struct Way {
  FactorizationKind kind;
  Packs packs;
  bool wide;
};

Result run(const Problem& problem, const Way& way) {
  const Ordering ordering = way.wide ? wide_ordering(problem.graph) : minimum_fill_ordering(problem.graph);
  Factorization f(std::make_shared<const Symbolic>(problem.graph, ordering, way.packs), way.kind);
  families::load(problem.matrix, problem.graph, f.symbolic(), f.values());
  Result result{.outcome = f.factorize(), .x = problem.right, .transposed = problem.right};
  if (result.outcome.ok()) {
    f.solve(view(result.x));
    f.solve_transposed(view(result.transposed));
  }
  result.dropped = static_cast<int>(f.dropped_rows().size());
  const auto& counts = f.symbolic().counts();
  if (result.outcome.ok() && result.outcome.inertia.zero == 0 && result.outcome.dropped_rows == 0) {
    EXPECT_GE(result.outcome.operations,
              way.kind == FactorizationKind::ldu ? counts.operations : counts.symmetric_operations);
  }
  return result;
}

std::vector<Problem> problems(families::Values values, families::Difficulty difficulty) {
  std::vector<Problem> list;
  for (const auto family : families::all_families())
    list.push_back(families::make_problem({.family = family, .n = 60, .difficulty = difficulty, .values = values}));
  return list;
}

TEST_P(InstructionSets, SolveSymmetricAndOtherMatricesInPacksAndOneByOne) {
  for (const auto values : {families::Values::symmetric, families::Values::unsymmetric})
    for (const Problem& problem : problems(values, families::Difficulty::plain))
      for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
        if (kind == FactorizationKind::ldlt && values == families::Values::unsymmetric) continue;
        for (const Packs packs : {Packs::off, Packs::on})
          for (const bool wide : {false, true}) {
            const Result result = run(problem, {kind, packs, wide});
            ASSERT_TRUE(result.outcome.ok()) << problem.name;
            EXPECT_LE(relative(result.x, problem.solution), 1e-9) << problem.name;
            if (values == families::Values::symmetric) {
              EXPECT_LE(relative(result.transposed, problem.solution), 1e-9) << problem.name;
            }
          }
      }
}

TEST_P(InstructionSets, GiveTheResultOfThePlainOneTo1eMinus9AndTheSameCounts) {
  const auto all = problems(families::Values::symmetric, families::Difficulty::plain);
  for (const Problem& problem : all)
    for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt})
      for (const Packs packs : {Packs::off, Packs::on}) {
        const Way way{kind, packs, true};
        const Result here = run(problem, way);
        simd::use_instruction_set(simd::InstructionSet::plain);
        const Result plain = run(problem, way);
        simd::use_instruction_set(GetParam());
        EXPECT_LE(relative(here.x, plain.x), 1e-9) << problem.name;
        EXPECT_EQ(here.outcome.operations, plain.outcome.operations) << problem.name;
        EXPECT_EQ(here.outcome.pivots, plain.outcome.pivots) << problem.name;
        EXPECT_EQ(here.outcome.inertia, plain.outcome.inertia) << problem.name;
      }
}

/// Rows that depend are found in packs as they are one by one: as many, and what is left solves the system.
TEST_P(InstructionSets, FindDependentRowsInPacksAsOneByOne) {
  for (const auto values : {families::Values::symmetric, families::Values::unsymmetric})
    for (const Problem& problem : problems(values, families::Difficulty::redundant)) {
      const auto kind = values == families::Values::symmetric ? FactorizationKind::ldlt : FactorizationKind::ldu;
      for (const bool wide : {false, true}) {
        const Result alone = run(problem, {kind, Packs::off, wide}), packed = run(problem, {kind, Packs::on, wide});
        EXPECT_EQ(alone.outcome.ok(), packed.outcome.ok()) << problem.name;
        EXPECT_EQ(alone.dropped, packed.dropped) << problem.name;
        EXPECT_EQ(alone.outcome.inertia, packed.outcome.inertia) << problem.name;
        if (!packed.outcome.ok() || packed.outcome.boosts > 0) continue;
        const Eigen::VectorXd rest = problem.matrix * packed.x - problem.right;
        EXPECT_LE(rest.norm(), 1e-7 * problem.right.norm()) << problem.name;
      }
    }
}

/// Also where some rows depend, so that some lanes of a pack go alone, and several pivots of one level add to one block.
TEST_P(InstructionSets, AComponentIsTheSameInBitsInAnyCompany) {
  constexpr int copies = 5, mine = 2;
  for (const auto difficulty : {families::Difficulty::plain, families::Difficulty::redundant})
    for (const Problem& one : problems(families::Values::symmetric, difficulty)) {
      const Problem problem = families::repeated(one, copies);
      const auto symbolic = std::make_shared<const Symbolic>(problem.graph, minimum_fill_ordering(problem.graph));
      if (symbolic->components() != copies) continue;
      for (const auto kind : {FactorizationKind::ldu, FactorizationKind::ldlt}) {
        const auto solved = [&](std::vector<int> components) {
          Factorization f(symbolic, kind);
          families::load(problem.matrix, problem.graph, *symbolic, f.values());
          const auto outcomes = f.factorize(components);
          std::erase_if(components, [&](int c) { return !outcomes[c].ok(); });  // its right-hand side stays
          Eigen::VectorXd x = problem.right;
          f.solve_components(view(x), components);
          return Eigen::VectorXd(x.segment(mine * one.graph.rows(), one.graph.rows()));
        };
        const Eigen::VectorXd alone = solved({mine});
        EXPECT_EQ(alone, solved({0, 1, 2, 3, 4})) << problem.name;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(All, InstructionSets, testing::ValuesIn(simd::instruction_sets()),
                         [](const auto& instance) { return std::string(name(instance.param)); });

}  // namespace test_instruction_sets
