#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/symbolic.hpp"

/// Graphs that tests and benchmarks share. Regular nodes of 6 rows hang together by saddle nodes of 3 rows, whose
/// rows are independent on either neighbour.
namespace families {

graphsolve::BlockGraph chain(int n);
graphsolve::BlockGraph anchored_chain(int n);  ///< a saddle node to the ground at either end: a loop
graphsolve::BlockGraph balanced_tree(int n);   ///< two children each
graphsolve::BlockGraph quadruped();            ///< a trunk and four legs of three
graphsolve::BlockGraph star(int leaves);
graphsolve::BlockGraph loop(int n);
graphsolve::BlockGraph ladder(int n);                           ///< two rails of n / 2 and a rung at every pair
graphsolve::BlockGraph grid(int side, int rows = 1);            ///< saddle nodes of so many rows
graphsolve::BlockGraph random_tree(int n, std::uint64_t seed);  ///< dimensions 1 .. 6
graphsolve::BlockGraph random_with_loops(int n, int extra, std::uint64_t seed);
/// Linear dynamics x' = A x + B u over n steps, A and x' square, as saddle nodes of 2; controls u of 1 are regular. A
/// state costs (regular) or not (semidefinite), as the seed has it; the last one always costs.
graphsolve::BlockGraph control(int n, std::uint64_t seed);

/// A regular saddle system on the graph: F = [H -J^T; J 0], H block diagonal and positive definite, J random with
/// full row rank on each neighbour. With more saddle rows than the regular ones can carry it is singular.
Eigen::MatrixXd saddle_matrix(const graphsolve::BlockGraph& graph, std::uint64_t seed);

/// Random values with the graph's structure, diagonal blocks made dominant: regular whatever the order.
Eigen::MatrixXd dominant_matrix(const graphsolve::BlockGraph& graph, std::uint64_t seed);

/// Scatters a dense matrix into the value array of a factorization.
void load(const Eigen::MatrixXd& dense, const graphsolve::BlockGraph& graph, const graphsolve::Symbolic& symbolic,
          std::span<double> values);

/// Scalars of the factor over scalars of the matrix, one triangle with diagonal.
double fill_factor(const graphsolve::Symbolic& symbolic);

}  // namespace families
