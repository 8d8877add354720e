#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "support/graph_families.hpp"

/// What the tests of the factorizations have in common: graphs by name, a right-hand side, vectors as spans.
namespace cases {

struct Case {
  std::string name;
  graphsolve::BlockGraph graph;
};

/// Every family once, small enough for dense Eigen, and ten seeds of the random ones.
inline std::vector<Case> all() {
  std::vector<Case> list;
  list.push_back({"chain", families::chain(12)});
  list.push_back({"anchored chain", families::anchored_chain(8)});
  list.push_back({"tree", families::balanced_tree(15)});
  list.push_back({"quadruped", families::quadruped()});
  list.push_back({"star", families::star(9)});
  list.push_back({"loop", families::loop(10)});
  list.push_back({"ladder", families::ladder(12)});
  list.push_back({"grid", families::grid(4)});
  for (int seed = 1; seed <= 10; ++seed) {
    list.push_back({"random tree " + std::to_string(seed), families::random_tree(14, seed)});
    list.push_back({"random loops " + std::to_string(seed), families::random_with_loops(12, 4, seed)});
  }
  return list;
}

/// No entry is zero, none equals another.
inline Eigen::VectorXd right_hand_side(Eigen::Index n) {
  return Eigen::VectorXd::NullaryExpr(n, [](Eigen::Index i) { return std::cos(1.7 * static_cast<double>(i) + 0.3); });
}

inline double relative(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return (a - b).norm() / b.norm(); }

inline std::span<double> view(Eigen::VectorXd& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }
inline std::span<const double> view(const Eigen::VectorXd& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

}  // namespace cases
