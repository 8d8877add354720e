// A membrane stretched over a ball: the obstacle problem.
//
//   minimise  1/2 int |grad u|^2   over u on the square [-2, 2]^2   subject to  u >= psi,  u given on the rim
//
// The obstacle is the upper half of a unit ball. With the right values on the rim the solution is symmetric about
// the centre and known: u = psi for r < a, and u = a^2 / sqrt(1 - a^2) log(2 / r) outside, where a = 0.697965148...
// makes the slope continuous. Five-point differences on a grid; every inner grid point is a node with one inequality.
// Run: build/release/bin/obstacle. Expected: a picture of where the membrane lies on the ball (#); the radius of that
// region, from the force on the ball, and the largest error for two grids: both errors fall more than fourfold.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <string>
#include <vector>

#include "../no_arguments.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"

using namespace graphsolve;

namespace {

constexpr double contact_radius = 0.697965148223374;

/// The ball, continued by its tangent where it gets steep; the membrane never gets there.
double obstacle(double r) {
  constexpr double steep = 0.9;
  if (r <= steep) return std::sqrt(1 - r * r);
  const double height = std::sqrt(1 - steep * steep);
  return height - steep / height * (r - steep);
}

double exact(double r) {
  constexpr double a = contact_radius;
  return r <= a ? obstacle(r) : a * a / std::sqrt(1 - a * a) * std::log(2 / r);
}

struct Membrane {
  int points;  ///< inner grid points along one side
  std::vector<double> u;
  std::vector<char> touches;
  double force = 0;  ///< with which the ball holds the membrane up
  int iterations = 0;
  [[nodiscard]] double radius(int i, int j) const {
    const double h = 4.0 / (points + 1);
    return std::hypot(h * (i + 1) - 2, h * (j + 1) - 2);
  }
};

Membrane solve(int points) {
  Membrane membrane{points, {}, {}};
  BlockGraph graph;
  QuadraticCost energy;
  PortLawBatch<Bound, Nonnegative> bounds;
  const auto inside = [&](int k) { return k >= 0 && k < points; };
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < points; ++j) {
      const NodeId node = graph.add_node("u " + std::to_string(i) + " " + std::to_string(j), 1);
      bounds.add(Bound(node, 0, Bound::Side::lower, obstacle(membrane.radius(i, j))), Nonnegative());
      // Edges to the neighbours before this one, and to the rim, where u is a number.
      for (const auto& [di, dj] : {std::pair{-1, 0}, {0, -1}, {1, 0}, {0, 1}}) {
        const int ni = i + di, nj = j + dj;
        if (!inside(ni) || !inside(nj)) {
          energy.add_diagonal(node, std::vector{1.0}, std::vector{-exact(membrane.radius(ni, nj))});
        } else if (di + dj < 0) {
          const NodeId pair[] = {node, NodeId{ni * points + nj}};
          energy.add(pair, std::vector{1.0, -1.0, -1.0, 1.0});
        }
      }
    }
  Problem problem(graph);
  problem.add(energy);
  problem.add(bounds);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
  membrane.u.assign(graph.rows(), 1.0);
  const Status status = solver.solve(membrane.u);
  if (status != Status::solved) std::printf("%s: %s\n", name(status).data(), explanation(status).data());
  membrane.iterations = solver.reports()[0].iterations;
  for (int k = 0; k < bounds.size(); ++k) {
    membrane.touches.push_back(bounds.law(k).force() > bounds.law(k).slack());
    membrane.force += bounds.law(k).force();
  }
  return membrane;
}

void report(const Membrane& m) {
  double error = 0;
  for (int i = 0; i < m.points; ++i)
    for (int j = 0; j < m.points; ++j)
      error = std::max(error, std::abs(m.u[i * m.points + j] - exact(m.radius(i, j))));
  // The membrane leaves the ball with slope -a / sqrt(1 - a^2) at r = a: the force is 2 pi a^2 / sqrt(1 - a^2).
  const double t = std::pow(m.force / (2 * std::numbers::pi), 2);
  const double radius = std::sqrt(0.5 * (std::sqrt(t * t + 4 * t) - t));
  std::printf("mesh width %.4f: contact radius %.4f (exact %.4f), largest error %.5f, %d iterations\n",
              4.0 / (m.points + 1), radius, contact_radius, error, m.iterations);
}

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words,
               "A membrane stretched over a ball, and the region where it lies on it: the obstacle problem.");
  const Membrane coarse = solve(31);
  for (int i = 0; i < coarse.points; ++i) {
    for (int j = 0; j < coarse.points; ++j) std::putchar(coarse.touches[i * coarse.points + j] ? '#' : '.');
    std::putchar('\n');
  }
  report(coarse);
  report(solve(63));
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "obstacle: %s\n", error.what());
  return 2;
}
