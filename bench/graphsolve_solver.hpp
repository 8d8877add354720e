#pragma once

#include <memory>
#include <string_view>

#include "baselines/baselines.hpp"
#include "graphsolve/block_graph.hpp"
#include "graphsolve/factorization.hpp"

namespace bench {

/// graphsolve behind the interface of the packages it is compared with. `write` puts the numbers into the storage of
/// the factorization, as a term does; `refactor` then works in place.
class GraphsolveSolver final : public baselines::Baseline {
 public:
  /// Refers to the graph, which must outlive it.
  explicit GraphsolveSolver(const graphsolve::BlockGraph& graph) : graph_(graph) {}

  [[nodiscard]] std::string_view name() const override { return "graphsolve ldu"; }
  [[nodiscard]] baselines::Demand demand() const override { return baselines::Demand::any; }
  [[nodiscard]] baselines::Status analyze(const Eigen::SparseMatrix<double>& a) override;
  void write(std::span<const double> values) override;
  [[nodiscard]] baselines::Status refactor() override;
  [[nodiscard]] baselines::Status solve(std::span<const double> b, std::span<double> x) override;

  /// Keeps the matrix from the next `refactor` on, so that `refine` may be called.
  void allow_refinement();
  graphsolve::Factorization::Refinement refine(std::span<const double> b, std::span<double> x);

  [[nodiscard]] const graphsolve::Symbolic& symbolic() const { return factorization_->symbolic(); }
  [[nodiscard]] int dropped_rows() const { return dropped_rows_; }

 private:
  const graphsolve::BlockGraph& graph_;
  std::unique_ptr<graphsolve::Factorization> factorization_;
  const Eigen::SparseMatrix<double>* pattern_ = nullptr;
  std::vector<std::int64_t> place_;  ///< per entry of the matrix: its place in the factorization's values
  int dropped_rows_ = 0;
};

}  // namespace bench
