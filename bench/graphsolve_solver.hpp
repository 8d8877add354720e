#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "baselines/baselines.hpp"
#include "graphsolve/block_graph.hpp"
#include "graphsolve/entry_map.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/robust_solver.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "graphsolve/supernodes.hpp"

namespace bench {

/// Nodes as they are, or merged into larger ones where that promises to be faster (supernodes.hpp).
enum class Nodes { as_given, merged };

/// One pivot after the other in the order of minimum fill; or eight equal ones at once where there are as many, in the
/// order that is cheapest then (cheapest_in_packs).
enum class Path { scalar, packs };

/// How graphsolve is used.
struct Way {
  graphsolve::FactorizationKind kind = graphsolve::FactorizationKind::ldu;
  Nodes nodes = Nodes::as_given;
  Path path = Path::scalar;
  std::optional<graphsolve::simd::InstructionSet> set = {};  ///< for the whole process, from `analyze` on; default: the best
};

/// graphsolve behind the interface of the packages it is compared with. `write` puts the numbers into the storage of
/// the factorization, as a term does; `refactor` then works in place.
class GraphsolveSolver final : public baselines::Baseline {
 public:
  /// Refers to the graph, which must outlive it.
  GraphsolveSolver(const graphsolve::BlockGraph& graph, const Way& way) : graph_(graph), way_(way) {}

  [[nodiscard]] std::string_view name() const override { return "graphsolve"; }
  [[nodiscard]] baselines::Demand demand() const override {
    return way_.kind == graphsolve::FactorizationKind::ldu ? baselines::Demand::any : baselines::Demand::symmetric;
  }
  [[nodiscard]] baselines::Status analyze(const Eigen::SparseMatrix<double>& a) override;
  void write(std::span<const double> values) override;
  [[nodiscard]] baselines::Status refactor() override;
  [[nodiscard]] baselines::Status solve(std::span<const double> b, std::span<double> x) override;

  [[nodiscard]] bool has_one_pass() const override { return true; }
  [[nodiscard]] baselines::Status refactor_and_solve(std::span<const double> b, std::span<double> x) override;

  /// Keeps the matrix from the next `refactor` on, so that `refine` may be called.
  void allow_refinement();
  graphsolve::Factorization::Refinement refine(std::span<const double> b, std::span<double> x);

  [[nodiscard]] Path path() const { return way_.path; }
  [[nodiscard]] const graphsolve::Symbolic& symbolic() const { return factorization_->symbolic(); }
  [[nodiscard]] const graphsolve::Factorization::Outcome& outcome() const { return outcome_; }

 private:
  const graphsolve::BlockGraph& graph_;
  Way way_;
  [[nodiscard]] baselines::Status status() const;
  void into_merged(std::span<const double> b);
  void out_of_merged(std::span<double> x) const;

  graphsolve::Supernodes merged_;  ///< empty when nodes are as given
  std::unique_ptr<graphsolve::Factorization> factorization_;
  const Eigen::SparseMatrix<double>* pattern_ = nullptr;
  std::optional<graphsolve::EntryMap> map_;  ///< made by the first `write`: analysis does without
  std::vector<double> right_, x_;    ///< in the numbering of the merged graph
  graphsolve::Factorization::Outcome outcome_;
};

/// RobustSolver behind the same interface: refined, on whatever rung it takes. `refactor` is its first rung, `solve` has
/// the others.
class RobustGraphsolve final : public baselines::Baseline {
 public:
  RobustGraphsolve(const graphsolve::BlockGraph& graph, graphsolve::FactorizationKind kind) : graph_(graph), kind_(kind) {}

  [[nodiscard]] std::string_view name() const override { return "graphsolve robust"; }
  [[nodiscard]] baselines::Demand demand() const override {
    return kind_ == graphsolve::FactorizationKind::ldu ? baselines::Demand::any : baselines::Demand::symmetric;
  }
  [[nodiscard]] baselines::Status analyze(const Eigen::SparseMatrix<double>& a) override;
  void write(std::span<const double> values) override;
  [[nodiscard]] baselines::Status refactor() override;
  [[nodiscard]] baselines::Status solve(std::span<const double> b, std::span<double> x) override;

  [[nodiscard]] const graphsolve::RobustSolver::Report& report() const { return report_; }

 private:
  const graphsolve::BlockGraph& graph_;
  graphsolve::FactorizationKind kind_;
  std::optional<graphsolve::RobustSolver> solver_;
  std::optional<graphsolve::EntryMap> map_;
  graphsolve::RobustSolver::Report report_;
};

}  // namespace bench
