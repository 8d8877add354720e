#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/symbolic.hpp"

/// Linear systems that tests and benchmarks share: graphs of graph_families.hpp with seeded values.
namespace families {

enum class Family { chain, tree, quadruped, loop, ladder, grid, random, control };
std::span<const Family> all_families();
std::string_view name(Family family);

/// A leaf is a regular node of 3 rows that hangs on one regular node.
enum class Leaves { none, one_each };

enum class Difficulty {
  plain,           ///< C = 1e-3 of the identity
  mass_ratio,      ///< H scaled per node by 1e-3 .. 1e3
  wide_diagonals,  ///< H scaled per node by 1e-12 .. 1e12
  redundant,       ///< C = 0, and every fifth saddle node stands twice, the second time with its rows recombined
  exact_saddle,    ///< C = 0
};
std::span<const Difficulty> all_difficulties();
std::string_view name(Difficulty difficulty);

enum class Values {
  symmetric,    ///< [H J'; J -C], H symmetric
  unsymmetric,  ///< [H -J'; G C], G near J but not equal, H with a skew part
};

struct Spec {
  Family family = Family::chain;
  int n = 100;  ///< regular nodes, without leaves; stages of `control`; the quadruped has 13 always, a grid the next square
  Leaves leaves = Leaves::none;
  Difficulty difficulty = Difficulty::plain;
  Values values = Values::symmetric;
  std::uint64_t seed = 1;
};

/// "ladder 1000, leaves, 20 % redundant rows"
std::string describe(const Spec& spec);

struct Problem {
  std::string name;  ///< what `describe` says
  graphsolve::BlockGraph graph;
  /// Compressed and sorted, both triangles. H full within its blocks, C with its diagonal (also where that is zero).
  Eigen::SparseMatrix<double> matrix;
  Eigen::VectorXd solution;  ///< one solution; the only one unless rows are redundant
  Eigen::VectorXd right;     ///< matrix * solution
};

/// Regular nodes of 6 rows hang together by saddle nodes of 3 (`control`: states 12, controls 4, dynamics 12).
/// Equal specs give equal bits.
Problem make_problem(const Spec& spec);

/// The graph of make_problem, without numbers.
graphsolve::BlockGraph make_graph(const Spec& spec);

/// `copies` disjoint systems as one graph, copy after copy.
Problem repeated(const Problem& problem, int copies);

/// Optimal control of `stages` steps, 12 states, 4 inputs: nodes u_k, dynamics k, x_(k+1).
graphsolve::BlockGraph control_12_4(int stages);

/// Scatters a sparse matrix into the value array of a factorization, whose symbolic phase saw `graph`.
void load(const Eigen::SparseMatrix<double>& matrix, const graphsolve::BlockGraph& graph,
          const graphsolve::Symbolic& symbolic, std::span<double> values);

/// Componentwise backward error max_i |b - A x|_i / (|A| |x| + |b|)_i, residual in extended precision; NaN stays.
double backward_error(const Eigen::SparseMatrix<double>& a, std::span<const double> x, std::span<const double> b);

}  // namespace families
