#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <numeric>
#include <random>

#include "graphsolve/bound.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/linear_quadratic.hpp"
#include "graphsolve/nonnegative.hpp"
#include "graphsolve/ordering.hpp"

namespace test_interior_point_components {

// A component of the graph goes its own way, whatever becomes of the others beside it.

using namespace graphsolve;

/// Quadratic programs side by side, one component each: some with bounds of very different size, some that contradict
/// themselves and use up every attempt, some without any curvature.
struct Programs {
  explicit Programs(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    BlockGraph graph;
    for (int c = 0; c < components; ++c) {
      const NodeId a = graph.add_node("a", 2), b = graph.add_node("b", 2);
      graph.add_edge(a, b);
      const int kind = c % 4;  // 0, 1: can be solved; 2: no point within the bounds; 3: singular
      std::array<double, 16> h{};
      for (int i = 0; i < 4; ++i) h[5 * i] = kind == 3 ? 0 : std::pow(10, 4 * draw() - 2) + 1;
      if (kind != 3) h[1] = h[4] = h[11] = h[14] = 0.5 * draw();
      const double size = std::pow(10, 6 * draw() - 3);
      std::array<double, 4> g{};
      for (double& value : g) value = size * (draw() - 0.5);
      const NodeId both[] = {a, b};
      cost.add(both, h, g);
      if (kind == 3) continue;
      for (const NodeId node : both) {
        bounds.add(Bound(node, 0, Bound::Side::lower, kind == 2 ? 1 : -0.1 * draw()), Nonnegative());
        bounds.add(Bound(node, 0, Bound::Side::upper, kind == 2 ? -1 : 0.1 * draw()), Nonnegative());
      }
    }
    problem = std::make_unique<Problem>(std::move(graph));
    problem->add(cost);
    problem->add(bounds);
    solver = std::make_unique<InteriorPoint>(
        *problem, std::make_shared<const Symbolic>(problem->graph(), natural_ordering(problem->graph())));
  }
  static constexpr int components = 16;
  QuadraticCost cost;
  PortLawBatch<Bound, Nonnegative> bounds;
  std::unique_ptr<Problem> problem;
  std::unique_ptr<InteriorPoint> solver;
};

TEST(InteriorPointComponents, AreSolvedInTheSameBitsAloneAndBesideOthersThatFail) {
  int solved = 0, restarted = 0, singular = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Programs together(seed);
    std::vector<double> all(together.problem->graph().rows(), 0.0);
    (void)together.solver->solve(all);
    for (int c = 0; c < Programs::components; ++c) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", component " + std::to_string(c));
      Programs alone(seed);
      alone.solver->select({&c, 1});
      std::vector<double> x(all.size(), 0.0);
      (void)alone.solver->solve(x);
      const ComponentReport &one = alone.solver->reports()[c], &beside = together.solver->reports()[c];
      EXPECT_EQ(one.status, beside.status);
      EXPECT_EQ(one.iterations, beside.iterations);
      EXPECT_EQ(one.attempts, beside.attempts);
      EXPECT_EQ(one.residual, beside.residual);
      for (int i = 4 * c; i < 4 * c + 4; ++i) EXPECT_EQ(x[i], all[i]);
      solved += one.status == Status::solved;
      restarted += one.attempts > 1;
      singular += one.status == Status::singular;
    }
  }
  EXPECT_GT(solved, 100) << "the test shows nothing";
  EXPECT_GT(restarted, 20) << "the test shows nothing";
  EXPECT_GT(singular, 20) << "the test shows nothing";
}

TEST(InteriorPointComponents, SelectedLaterAreMeasuredByTheirOwnScaleAsThoseSelectedAtFirst) {
  BlockGraph graph;
  QuadraticCost cost;
  const double stiff[] = {1e6, 0}, slope[] = {10, 0};  // singular, so that no step hides what the start is measured by
  for (const char* name : {"a", "b"}) cost.add_diagonal(graph.add_node(name, 2), stiff, slope);
  Problem problem(std::move(graph));
  problem.add(cost);
  InteriorPoint solver(problem, std::make_shared<const Symbolic>(problem.graph(), natural_ordering(problem.graph())),
                       {.tolerance = 1e-3});
  std::vector<double> x(4, 0.0);
  for (const int c : {0, 1}) {
    solver.select({&c, 1});
    ASSERT_EQ(solver.solve(x), Status::solved);
    EXPECT_DOUBLE_EQ(solver.reports()[c].residual, 1e-5);  // slope over stiffness
  }
}

/// With nothing selected there is nothing to do: laws of components that ran before keep their forces.
TEST(InteriorPointComponents, OfWhichNoneIsSelectedAreLeftAsTheyAre) {
  Programs p(11);
  std::vector<double> x(p.problem->graph().rows(), 0.0);
  const std::vector<int> some{0, 1}, none;
  p.solver->select(some);
  ASSERT_EQ(p.solver->solve(x), Status::solved);
  const auto forces = [&] {
    std::vector<double> all;
    for (int i = 0; i < p.bounds.size(); ++i) all.push_back(p.bounds.law(i).force());
    return all;
  };
  const std::vector<double> before = forces(), at = x;
  p.solver->select(none);
  EXPECT_EQ(p.solver->solve(x, 10), Status::solved);
  EXPECT_EQ(forces(), before);
  EXPECT_EQ(x, at);
}

}  // namespace test_interior_point_components
