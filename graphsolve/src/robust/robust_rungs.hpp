#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "factorization/side.hpp"
#include "graphsolve/robust_solver.hpp"
#include "robust/threshold_pivoting.hpp"

namespace graphsolve {

/// The rungs of RobustSolver, and what is kept between solves.
struct RobustSolver::Impl {
  std::shared_ptr<const BlockGraph> graph;
  Options options;
  Ordering ordering;
  Side side;  ///< transposed: this one was made for the transposed solves of another
  Factorization first;
  std::vector<double> values;
  std::vector<double> factored;  ///< values as they were factored
  bool ready = false;            ///< were any?
  Factorization::Outcome outcome;
  // Made when needed, dropped when the values change.
  struct Retry {
    Factorization factorization;
    Factorization::Outcome outcome;
  };
  std::optional<Retry> reordered, shifted;
  std::optional<ThresholdPivoting> general;
  std::unique_ptr<Impl> twin;  ///< of A^T, on the same plan
  bool twin_is_current = false;
  // Of one solve; grow with its columns.
  std::vector<double> solutions;            ///< of the first rung
  std::vector<std::string> contradictions;  ///< by column; empty: none
  std::string broken;                       ///< the first number of the matrix that is not one; empty: there is none
  std::vector<double> null;                 ///< of rows that depend

  struct Attempt {
    Rung rung;
    Eigen::VectorXd x;
    double error;
  };
  struct Search {
    std::span<const double> b;
    std::optional<Attempt> best = {};
    std::string why = {};
  };
  struct Columns {
    std::span<const double> b;
    std::span<double> x;
    int count;
    std::size_t rows;
    [[nodiscard]] std::span<const double> right(int c) const { return b.subspan(c * rows, rows); }
    [[nodiscard]] std::span<double> solution(int c) const { return x.subspan(c * rows, rows); }
  };

  Impl(BlockGraph g, Options o);
  Impl(const Impl& of, Side s);
  [[nodiscard]] std::size_t rows() const { return static_cast<std::size_t>(graph->rows()); }
  void factorize();
  [[nodiscard]] Impl& transposed();

  // robust_solver.cpp: columns.
  Report solve_checked(std::span<const double> b, std::span<double> x, int columns, Side of);
  Report solve(const Columns& columns, Side of);
  Report solve_column(const Columns& columns, int c, Side of);

  // robust_rungs.cpp. All return true when what they found is good enough.
  void note(Search& search, Rung rung, const std::string& what) const;
  [[nodiscard]] std::string bad_pivot(const Factorization& f, const Factorization::Outcome& o) const;
  bool judge(Search& search, Attempt attempt) const;
  bool try_factors(Search& search, Rung rung, Factorization& f, const Factorization::Outcome& o) const;
  [[nodiscard]] Retry retry(const Ordering& order, double saddle_shift) const;
  [[nodiscard]] double largest_diagonal(NodeId node) const;
  [[nodiscard]] std::vector<char> late_nodes() const;
  bool try_reordered(Search& search);
  bool try_shifted(Search& search);
  bool try_general(Search& search);

  // robust_checks.cpp: what no rung can mend.
  [[nodiscard]] std::string not_finite() const;
  [[nodiscard]] std::string not_finite(std::span<const double> b) const;
  [[nodiscard]] double remainder(const Eigen::VectorXd& y) const;
  void find_contradictions(const Columns& columns);
  [[nodiscard]] Status unsolved(Search& search) const;
};

/// A number for a sentence.
std::string short_number(double value);

}  // namespace graphsolve
