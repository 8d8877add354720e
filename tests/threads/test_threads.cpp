#include <gtest/gtest.h>

#include <thread>

#include "graphsolve/factorization.hpp"
#include "support/problem_families.hpp"

namespace test_threads {

using namespace graphsolve;

std::vector<families::Problem> equal_graphs(families::Family family, int count) {
  std::vector<families::Problem> problems;
  for (int seed = 1; seed <= count; ++seed)
    problems.push_back(families::make_problem(
        {.family = family, .n = 60, .values = families::Values::unsymmetric, .seed = static_cast<std::uint64_t>(seed)}));
  return problems;
}

/// Everything a Factorization does with a matrix, one result after the other.
std::vector<double> work(const families::Problem& problem, Factorization& factorization) {
  const Symbolic& symbolic = factorization.symbolic();
  factorization.set_zero();
  families::load(problem.matrix, problem.graph, symbolic, factorization.values());
  EXPECT_TRUE(factorization.factorize().ok());
  std::vector<double> result(problem.right.begin(), problem.right.end());
  factorization.solve(result);
  std::vector<double> refined = result, transposed(problem.right.begin(), problem.right.end());
  result.push_back(factorization.refine({problem.right.data(), transposed.size()}, refined).backward_error);
  factorization.solve_transposed(transposed);
  result.insert(result.end(), refined.begin(), refined.end());
  result.insert(result.end(), transposed.begin(), transposed.end());
  return result;
}

/// Run under the thread sanitizer too (.ci/run): the Symbolic is only read, a Factorization belongs to one thread.
TEST(Threads, ShareOneSymbolicAndGiveTheBitsOfASerialRun) {
  constexpr int count = 4, rounds = 8;
  for (const families::Family family : {families::Family::loop, families::Family::ladder, families::Family::grid}) {
    const std::vector<families::Problem> problems = equal_graphs(family, count * rounds);
    const auto symbolic =
        std::make_shared<const Symbolic>(problems[0].graph, minimum_fill_ordering(problems[0].graph));
    std::vector<std::vector<double>> serial;
    Factorization alone(symbolic);
    alone.allow_refinement();
    alone.keep_matrix(true);
    for (const families::Problem& problem : problems) serial.push_back(work(problem, alone));

    std::vector<std::vector<double>> parallel(problems.size());
    std::vector<std::thread> threads;
    for (int t = 0; t < count; ++t)
      threads.emplace_back([&, t] {
        Factorization own(symbolic);
        own.allow_refinement();
        own.keep_matrix(true);
        for (int k = t; k < count * rounds; k += count) parallel[k] = work(problems[k], own);
      });
    for (std::thread& thread : threads) thread.join();
    for (std::size_t k = 0; k < problems.size(); ++k) {
      EXPECT_EQ(parallel[k], serial[k]) << problems[k].name << ", seed " << k + 1;
      if (k > 0) {
        EXPECT_NE(serial[k], serial[0]) << "different values were to be solved";
      }
    }
  }
}

}  // namespace test_threads
