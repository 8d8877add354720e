#include <Eigen/SparseCore>
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "graphsolve/factorization.hpp"
#include "graphsolve/supernodes.hpp"
#include "support/dense.hpp"
#include "support/problem_families.hpp"
#include "support/real_problems.hpp"
#include "unit.hpp"

/// Fits the weights of predicted_time (supernodes.hpp) to this machine: times the LDU of families and of the real
/// matrices where they are, with all settings that merge_supernodes tries, pivots one by one, and prints the weights, how
/// far the predictions are off, and what the choice by prediction costs against the best choice. Takes
/// about ten seconds.
namespace {

using namespace graphsolve;
using families::Family;
using families::Problem;

std::vector<Problem> problems() {
  std::vector<Problem> list;
  for (const Family family : {Family::chain, Family::ladder, Family::grid, Family::random, Family::control})
    list.push_back(families::make_problem({.family = family, .n = 400}));
  if (!families::data_directory()) return list;
  for (const std::string& name : families::real_matrices()) list.push_back(families::real_matrix(name));
  for (const std::string& name : families::pose_graphs())
    if (name != "sphere2500") list.push_back(families::pose_graph(name));  // takes as long as all others
  return list;
}

struct Sample {
  std::string problem;
  FactorWork work;
  double predicted, measured;  ///< [ns]
};

double measure(const Problem& problem, const Supernodes& nodes) {
  Factorization f(std::make_shared<const Symbolic>(nodes.graph, nodes.ordering, Packs::off));
  Eigen::PermutationMatrix<Eigen::Dynamic> permutation(nodes.graph.rows());
  std::copy(nodes.row_of.begin(), nodes.row_of.end(), permutation.indices().data());
  Eigen::SparseMatrix<double> a;
  a = problem.matrix.twistedBy(permutation);
  std::vector<double> values(f.values().size());
  families::load(a, nodes.graph, f.symbolic(), values);
  std::vector<double> times;
  for (double begin = timing::thread_time(); times.size() < 5 || timing::thread_time() - begin < 0.05;) {
    std::copy(values.begin(), values.end(), f.values().begin());
    const double start = timing::thread_time();
    if (!f.factorize().ok()) return 0;
    times.push_back(1e9 * (timing::thread_time() - start));
  }
  return timing::median(std::move(times));
}

std::vector<Sample> samples() {
  std::vector<Sample> list;
  for (const Problem& problem : problems()) {
    const Ordering ordering = minimum_fill_ordering(problem.graph);
    for (const SupernodeSettings& settings : supernode_candidates()) {
      const Supernodes nodes = merge_supernodes(problem.graph, ordering, settings);
      if (const double time = measure(problem, nodes); time > 0)  // some need another order
        list.push_back({problem.name, factor_work(nodes.graph, nodes.ordering), predicted_time(nodes.graph, nodes.ordering), time});
    }
  }
  return list;
}

/// Least squares of predicted / measured - 1, without negative weights.
FactorWork fit(const std::vector<Sample>& list) {
  constexpr int n = static_cast<int>(FactorWork{}.size());
  Eigen::MatrixXd a(list.size(), n);
  for (std::size_t i = 0; i < list.size(); ++i)
    for (int j = 0; j < n; ++j) a(static_cast<Eigen::Index>(i), j) = list[i].work[j] / list[i].measured;
  std::vector<char> taken(n, 1);
  while (true) {
    Eigen::MatrixXd some = a;
    for (int j = 0; j < n; ++j)
      if (!taken[j]) some.col(j).setZero();
    const Eigen::VectorXd x = dense::least_squares(some, Eigen::VectorXd::Ones(a.rows()));
    Eigen::Index least = 0;
    if (x.minCoeff(&least) >= -1e-9) {
      FactorWork weights{};
      for (int j = 0; j < n; ++j) weights[j] = std::max(0.0, x[j]);
      return weights;
    }
    taken[least] = 0;
  }
}

double dot(const FactorWork& a, const FactorWork& b) {
  double sum = 0;
  for (std::size_t j = 0; j < a.size(); ++j) sum += a[j] * b[j];
  return sum;
}

template <class Predict>
void report(const char* what, const std::vector<Sample>& list, Predict&& predict) {
  std::vector<double> off;
  std::map<std::string, std::pair<const Sample*, const Sample*>> choice;  // best by prediction, best in truth
  for (const Sample& s : list) {
    off.push_back(std::abs(predict(s) / s.measured - 1));
    auto& [chosen, best] = choice[s.problem];
    // Settings that merge the same are the same, whatever the clock says.
    if (!chosen || std::pair(predict(s), s.measured) < std::pair(predict(*chosen), chosen->measured)) chosen = &s;
    if (!best || s.measured < best->measured) best = &s;
  }
  double lost = 0, worst = 0;
  for (const auto& [name, pair] : choice) {
    const double loss = pair.first->measured / pair.second->measured - 1;
    lost += loss / static_cast<double>(choice.size());
    worst = std::max(worst, loss);
  }
  std::printf("%s: off by %.0f %% in the median, %.0f %% at most; the choice costs %.1f %% on average, %.0f %% at most\n", what,
              100 * timing::median(off), 100 * *std::max_element(off.begin(), off.end()), 100 * lost, 100 * worst);
}

}  // namespace

int main(int argc, char**) {
  if (argc > 1) {
    std::fprintf(stderr, "fit_supernodes: takes no arguments; it measures for a minute, then prints the weights of this machine\n");
    return 2;
  }
  const std::vector<Sample> list = samples();
  const FactorWork weights = fit(list);
  std::printf("unit %.0f ns, %zu factorizations; weights [ns]:", 1e9 * timing::measure_unit(), list.size());
  for (const double weight : weights) std::printf(" %.3g", weight);
  std::printf("\n");
  report("as built", list, [](const Sample& s) { return s.predicted; });
  report("refitted", list, [&](const Sample& s) { return dot(weights, s.work); });
}
