#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "graphsolve/bound.hpp"
#include "graphsolve/cheapest_ordering.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"
#include "support/problem_families.hpp"

namespace test_threads {

using namespace graphsolve;

constexpr int threads_at_once = 4, rounds = 8, jobs = threads_at_once * rounds;

std::vector<families::Problem> equal_graphs(families::Family family, families::Values values) {
  std::vector<families::Problem> problems;
  for (int seed = 1; seed <= jobs; ++seed)
    problems.push_back(families::make_problem({.family = family, .n = 60, .values = values, .seed = static_cast<std::uint64_t>(seed)}));
  return problems;
}

/// own() makes what belongs to one thread, a function that does job k. The results of one thread, and those of several at once
/// must be the same in bits.
template <class Own>
void expect_the_bits_of_a_serial_run(Own&& own, const std::string& what) {
  std::vector<std::vector<double>> serial(jobs), parallel(jobs);
  auto alone = own();
  for (int k = 0; k < jobs; ++k) serial[k] = alone(k);
  std::vector<std::thread> threads;
  for (int t = 0; t < threads_at_once; ++t)
    threads.emplace_back([&, t] {
      auto mine = own();
      for (int k = t; k < jobs; k += threads_at_once) parallel[k] = mine(k);
    });
  for (std::thread& thread : threads) thread.join();
  for (int k = 0; k < jobs; ++k) {
    EXPECT_EQ(parallel[k], serial[k]) << what << ", job " << k;
    if (k > 0) {
      EXPECT_NE(serial[k], serial[0]) << what << ": different values were to be solved";
    }
  }
}

/// Everything a Factorization does with a matrix, one result after the other.
std::vector<double> work(const families::Problem& problem, Factorization& factorization) {
  const Symbolic& symbolic = factorization.symbolic();
  const auto load = [&] {
    factorization.set_zero();
    families::load(problem.matrix, problem.graph, symbolic, factorization.values());
  };
  load();
  EXPECT_TRUE(factorization.factorize().ok());
  std::vector<double> result(problem.right.begin(), problem.right.end());
  const std::vector<double> right = result;
  factorization.solve(result);
  const auto append = [&](const std::vector<double>& more) { result.insert(result.end(), more.begin(), more.end()); };
  std::vector<double> x = result;
  result.push_back(factorization.refine(right, x).backward_error);
  append(x);
  x = right;
  factorization.solve_transposed(x);
  append(x);
  load();
  x = right;
  EXPECT_TRUE(factorization.factorize_and_solve(x).ok());
  append(x);
  return result;
}

// Run under the thread sanitizer too (.ci/run): the Symbolic is only read, a Factorization belongs to one thread.
TEST(Threads, ShareOneSymbolicAndGiveTheBitsOfASerialRun) {
  for (const families::Family family : {families::Family::loop, families::Family::ladder, families::Family::grid})
    for (const FactorizationKind kind : {FactorizationKind::ldu, FactorizationKind::ldlt})
      for (const Packs packs : {Packs::off, Packs::on}) {
        const auto problems = equal_graphs(
            family, kind == FactorizationKind::ldu ? families::Values::unsymmetric : families::Values::symmetric);
        const BlockGraph& graph = problems[0].graph;
        const auto symbolic = std::make_shared<const Symbolic>(
            graph, packs == Packs::on ? cheapest_in_packs(graph, kind) : minimum_fill_ordering(graph), packs);
        expect_the_bits_of_a_serial_run(
            [&] {
              auto own = std::make_shared<Factorization>(symbolic, kind);
              own->allow_refinement();
              own->keep_matrix(true);
              return [&problems, own](int k) { return work(problems[k], *own); };
            },
            problems[0].name + (packs == Packs::on ? ", in packs, kind " : ", kind ") + std::to_string(static_cast<int>(kind)));
      }
}

TEST(Threads, FactorSomeNodesAgainOnOneSymbolic) {
  const auto problems = equal_graphs(families::Family::tree, families::Values::unsymmetric);
  const auto symbolic = std::make_shared<const Symbolic>(problems[0].graph, minimum_fill_ordering(problems[0].graph));
  expect_the_bits_of_a_serial_run(
      [&] {
        auto own = std::make_shared<Factorization>(symbolic);
        own->allow_refactorization();
        own->keep_matrix(true);
        return [&, own](int k) {
          own->set_zero();
          families::load(problems[k].matrix, problems[k].graph, *symbolic, own->values());
          EXPECT_TRUE(own->factorize().ok());
          const NodeId changed{k};
          own->kept_entry(symbolic->block(changed, changed)) *= 1.5;
          EXPECT_TRUE(own->refactorize({&changed, 1}).ok());
          std::vector<double> x(problems[k].right.begin(), problems[k].right.end());
          own->solve(x);
          return x;
        };
      },
      "refactorize");
}

/// A chain of unknowns between bounds, pulled up and down; problem, terms and solver belong to one thread.
struct Chain {
  static constexpr int nodes = 30;
  BlockGraph graph;
  QuadraticCost cost;
  PortLawBatch<Bound, Nonnegative> bounds;

  explicit Chain(int seed) {
    for (int i = 0; i < nodes; ++i) graph.add_node("x" + std::to_string(i), 1);
    for (int i = 0; i < nodes; ++i) {
      const NodeId x{i};
      const double pull = 3 * std::sin(0.7 * i + seed);
      cost.add_diagonal(x, std::vector<double>{1.0}, std::vector<double>{pull});
      if (i > 0) {
        graph.add_edge({i - 1}, x);
        cost.add(std::vector<NodeId>{{i - 1}, x}, std::vector<double>{1, -1, -1, 1});
      }
      bounds.add(Bound(x, 0, Bound::Side::lower, -0.5), Nonnegative());
      bounds.add(Bound(x, 0, Bound::Side::upper, 0.5), Nonnegative());
    }
  }
};

TEST(Threads, SolveInequalitiesOnOneSymbolic) {
  const Chain any(0);
  const auto symbolic = std::make_shared<const Symbolic>(any.graph, minimum_fill_ordering(any.graph));
  expect_the_bits_of_a_serial_run(
      [&] {
        return [&](int k) {
          Chain chain(k);
          Problem problem(chain.graph);
          problem.add(chain.cost);
          problem.add(chain.bounds);
          InteriorPoint solver(problem, symbolic);
          std::vector<double> x(Chain::nodes, 0.0);
          EXPECT_EQ(solver.solve(x), Status::solved);
          EXPECT_NEAR(*std::ranges::max_element(x), 0.5, 1e-6);
          return x;
        };
      },
      "interior point");
}

}  // namespace test_threads
