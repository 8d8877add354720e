#pragma once

#include <Eigen/Dense>
#include <array>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/io/block_view.hpp"
#include "graphsolve/term.hpp"

/// Terms on a chain of nodes of two unknowns, for tests of the interior point and of the derivative check.
namespace cases {

using namespace graphsolve;

/// Gradient of 1/2 x' H x + g' x on a chain of nodes of two unknowns: diagonal and coupling blocks of H.
class ChainQuadratic final : public Term {
 public:
  ChainQuadratic(int nodes, std::uint64_t seed) : h(2 * nodes, 2 * nodes), g(2 * nodes), nodes_(nodes) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    h.setZero();
    for (int i = 0; i < nodes; ++i) {
      const int rows = i + 1 < nodes ? 4 : 2;
      const Eigen::MatrixXd m = Eigen::MatrixXd::NullaryExpr(rows, rows, [&] { return normal(random); });
      h.block(2 * i, 2 * i, rows, rows) += m * m.transpose() + 0.1 * Eigen::MatrixXd::Identity(rows, rows);
    }
    for (auto& value : g) value = 3 * normal(random);
    for (int i = 0; i + 1 < nodes; ++i) pairs_.push_back({NodeId{i}, NodeId{i + 1}});
  }
  Eigen::MatrixXd h;
  Eigen::VectorXd g;

  [[nodiscard]] int size() const override { return static_cast<int>(pairs_.size()); }
  [[nodiscard]] std::span<const NodeId> nodes(int i) const override { return pairs_[i]; }
  void wire(const Wiring& wiring) override {
    blocks_.clear();
    for (int i = 0; i < nodes_; ++i)
      for (int j = std::max(0, i - 1); j <= std::min(nodes_ - 1, i + 1); ++j)
        blocks_.push_back({i, j, wiring.block({i}, {j})});
  }
  /// All instances belong to one component: the first carries the whole product.
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override {
    if (instances.index.empty()) return;
    const Eigen::Map<const Eigen::VectorXd> at(x.data(), h.rows());
    Eigen::Map<Eigen::VectorXd>(residual.data(), h.rows()) += h * at + g;
    for (const auto& b : blocks_)
      if (values) block_view(values, b.handle) += h.block<2, 2>(2 * b.row, 2 * b.column);
  }

 private:
  struct Block {
    int row, column;
    BlockHandle handle;
  };
  int nodes_;
  std::vector<std::array<NodeId, 2>> pairs_;
  std::vector<Block> blocks_;
};

inline BlockGraph chain(int nodes) {
  BlockGraph graph;
  for (int i = 0; i < nodes; ++i) graph.add_node("x" + std::to_string(i), 2);
  return graph;
}

/// Adds nothing; its residual in row 0 is not a number.
class Spoils final : public Term {
 public:
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] std::span<const NodeId> nodes(int) const override { return {&node_, 1}; }
  void wire(const Wiring&) override {}
  void evaluate(Instances, std::span<const double>, std::span<double> residual, double*) override {
    residual[0] = std::numeric_limits<double>::quiet_NaN();
  }

 private:
  NodeId node_{0};
};

}  // namespace cases
