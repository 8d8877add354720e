// Minimise |x|^2 + 2 |y|^2 subject to x + y = (3, 6). Prints: x = 2 4, y = 1 2, multiplier = 4 8, fill blocks: 0
#include <cstdio>
#include <exception>

#include "graphsolve/factorization.hpp"

using namespace graphsolve;

int main() try {
  BlockGraph graph;  // the pattern: blocks of any size, here 2
  const NodeId x = graph.add_node("x", 2), y = graph.add_node("y", 2);
  const NodeId sum = graph.add_node("sum", 2, NodeKind::saddle);  // a constraint: no pivot of its own
  graph.add_edge(sum, x, EdgeRank::full);
  graph.add_edge(sum, y, EdgeRank::full);

  const auto symbolic = std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph));
  Factorization factorization(symbolic);
  const auto set = [&](NodeId row, NodeId column, double value) {  // value times the identity
    for (int i = 0; i < 2; ++i) factorization.entry(symbolic->block(row, column), i, i) = value;
  };
  set(x, x, 2), set(y, y, 4);        // Hessian
  set(sum, x, 1), set(sum, y, 1);    // constraint
  set(x, sum, -1), set(y, sum, -1);  // its multipliers
  if (!factorization.factorize().ok()) return 1;
  std::vector<double> v{0, 0, 0, 0, 3, 6};  // right-hand side in, solution out
  factorization.solve(v);
  std::printf("x = %g %g, y = %g %g, multiplier = %g %g, fill blocks: %lld\n", v[0], v[1], v[2], v[3], v[4], v[5],
              static_cast<long long>(symbolic->counts().fill_blocks));
} catch (const std::exception& error) {
  std::fprintf(stderr, "solver_minimal: %s\n", error.what());
  return 2;
}
