#pragma once

#include <memory>
#include <string_view>

#include "baselines/baselines.hpp"
#include "graphsolve/block_graph.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/supernodes.hpp"

namespace bench {

/// Nodes as they are, or merged into larger ones where that promises to be faster (supernodes.hpp).
enum class Nodes { as_given, merged };

/// graphsolve behind the interface of the packages it is compared with. `write` puts the numbers into the storage of
/// the factorization, as a term does; `refactor` then works in place.
class GraphsolveSolver final : public baselines::Baseline {
 public:
  /// Refers to the graph, which must outlive it.
  GraphsolveSolver(const graphsolve::BlockGraph& graph, graphsolve::FactorizationKind kind, Nodes nodes = Nodes::as_given)
      : graph_(graph), kind_(kind), nodes_(nodes) {}

  [[nodiscard]] std::string_view name() const override { return "graphsolve"; }
  [[nodiscard]] baselines::Demand demand() const override {
    return kind_ == graphsolve::FactorizationKind::ldu ? baselines::Demand::any : baselines::Demand::symmetric;
  }
  [[nodiscard]] baselines::Status analyze(const Eigen::SparseMatrix<double>& a) override;
  void write(std::span<const double> values) override;
  [[nodiscard]] baselines::Status refactor() override;
  [[nodiscard]] baselines::Status solve(std::span<const double> b, std::span<double> x) override;

  /// Keeps the matrix from the next `refactor` on, so that `refine` may be called.
  void allow_refinement();
  graphsolve::Factorization::Refinement refine(std::span<const double> b, std::span<double> x);

  [[nodiscard]] const graphsolve::Symbolic& symbolic() const { return factorization_->symbolic(); }
  [[nodiscard]] const graphsolve::Factorization::Outcome& outcome() const { return outcome_; }

 private:
  const graphsolve::BlockGraph& graph_;
  graphsolve::FactorizationKind kind_;
  Nodes nodes_;
  graphsolve::Supernodes merged_;  ///< empty when nodes are as given
  std::unique_ptr<graphsolve::Factorization> factorization_;
  const Eigen::SparseMatrix<double>* pattern_ = nullptr;
  std::vector<std::int64_t> place_;  ///< per entry of the matrix: its place in the factorization's values
  std::vector<double> right_, x_;    ///< in the numbering of the merged graph
  graphsolve::Factorization::Outcome outcome_;
};

}  // namespace bench
