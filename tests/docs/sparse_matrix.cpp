#include <algorithm>
#include <cstdio>
#include <exception>
#include <vector>

#include "graphsolve/block_detection.hpp"
#include "graphsolve/entry_map.hpp"
#include "graphsolve/robust_solver.hpp"

using namespace graphsolve;

int main() try {
  // A string of beads, pulled down and held at both ends. Or: io::from_eigen(matrix), from "graphsolve/io/eigen.hpp".
  const int n = 9;
  std::vector<Triplet> entries;
  for (int i = 0; i < n; ++i) {
    entries.push_back({i, i, 2});
    if (i > 0) entries.push_back({i, i - 1, -1}), entries.push_back({i - 1, i, -1});
  }
  const SparseMatrix a = from_triplets(n, n, entries);
  const BlockStructure blocks = detect_blocks(a);  // or make_blocks, with blocks that you know
  RobustSolver solver(blocks.graph, {.kind = FactorizationKind::ldlt});
  const EntryMap entry_map(a, blocks, solver.symbolic());  // once per pattern

  entry_map.write(a.value, solver.values());  // again and again, with new numbers
  std::vector<double> b(n, 1.0), x(n), in_blocks(n);
  blocks.to_graph(b, in_blocks);  // the graph numbers rows block by block
  const auto report = solver.solve(in_blocks, in_blocks);
  if (report.status != Status::solved) {
    std::printf("%s\n", report.why.c_str());
    return 1;
  }
  blocks.to_matrix(in_blocks, x);
  std::printf("deepest: %g, backward error below 1e-12: %s\n", *std::ranges::max_element(x),
              backward_error(a, b, x).componentwise < 1e-12 ? "yes" : "no");
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
