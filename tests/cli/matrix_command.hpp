#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "graphsolve/io/matrix_market.hpp"
#include "program.hpp"

/// What tests of `analyze` and `solve` share.
namespace matrix_command {

namespace fs = std::filesystem;
using graphsolve::SparseMatrix;
using graphsolve::Triplet;
namespace io = graphsolve::io;

class MatrixCommand : public Program {
 protected:
  using Program::write;
  void write(const std::string& name, int n, const std::vector<Triplet>& triplets) const {
    write(name, io::matrix_market(graphsolve::from_triplets(n, n, triplets)));
  }
};

/// A ring of n rows, symmetric and positive definite; without the closing link a chain.
enum class Shape { chain, ring };
inline std::vector<Triplet> line(int n, Shape shape) {
  std::vector<Triplet> t;
  for (int i = 0; i < n; ++i) {
    t.push_back({i, i, 4});
    const int next = (i + 1) % n;
    if (next != 0 || shape == Shape::ring) t.insert(t.end(), {{i, next, -1}, {next, i, -1}});
  }
  return t;
}

/// Two variables held by constraints: x0, and x0 again when `twice`.
inline std::vector<Triplet> saddle(bool twice) {
  std::vector<Triplet> t{{0, 0, 2}, {1, 1, 3}, {0, 1, 1}, {1, 0, 1}, {2, 0, 1}, {0, 2, 1}};
  if (twice) t.insert(t.end(), {{3, 0, 2}, {0, 3, 2}});
  else t.insert(t.end(), {{3, 1, 1}, {1, 3, 1}});
  return t;
}

}  // namespace matrix_command
