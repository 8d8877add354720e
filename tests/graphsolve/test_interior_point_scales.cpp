#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "graphsolve/interior_point.hpp"
#include "graphsolve/io/block_view.hpp"
#include "graphsolve/ordering.hpp"

/// Rows without a scale of the caller's are judged by the diagonal where x is, not by that of another point.
namespace test_interior_point_scales {

using namespace graphsolve;

/// One unknown, one equation.
class Equation final : public Term {
 public:
  using Function = std::function<double(double)>;
  Equation(Function f, Function derivative) : f_(std::move(f)), derivative_(std::move(derivative)) {}
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] std::span<const NodeId> nodes(int) const override { return nodes_; }
  void wire(const Wiring& wiring) override { block_ = wiring.block({0}, {0}); }
  void evaluate(Instances instances, std::span<const double> x, std::span<double> residual, double* values) override {
    if (instances.index.empty()) return;
    residual[0] += f_(x[0]);
    if (values) values[block_.place(0, 0)] += derivative_(x[0]);
  }

 private:
  Function f_, derivative_;
  std::array<NodeId, 1> nodes_{NodeId{0}};
  BlockHandle block_;
};

class OneEquation {
 public:
  OneEquation(Equation::Function f, Equation::Function derivative) : term_(std::move(f), std::move(derivative)), problem_(graph()) {
    problem_.add(term_);
    solver_ = std::make_unique<InteriorPoint>(
        problem_, std::make_shared<const Symbolic>(problem_.graph(), natural_ordering(problem_.graph())));
  }
  Status solve(double& x) { return solver_->solve({&x, 1}); }
  InteriorPoint& solver() { return *solver_; }

 private:
  static BlockGraph graph() {
    BlockGraph graph;
    (void)graph.add_node("x", 1);
    return graph;
  }
  Equation term_;
  Problem problem_;
  std::unique_ptr<InteriorPoint> solver_;
};

TEST(InteriorPointScales, ASteepStartIsNoMeasureOfTheEnd) {
  for (const double start : {1.0, 5.0, 30.0, 100.0}) {
    OneEquation one([](double x) { return std::exp(x) - 2; }, [](double x) { return std::exp(x); });
    double x = start;
    const Status status = one.solve(x);
    EXPECT_EQ(status, start < 10 ? Status::solved : Status::max_iterations) << start;
    if (status == Status::solved) {
      EXPECT_NEAR(x, std::log(2.0), 1e-7) << start;
    } else {
      EXPECT_EQ(x, start) << "Newton's way is longer than its iterations: the start is kept";
    }
  }
}

TEST(InteriorPointScales, AFailedSolveLeavesNoScaleBehind) {
  OneEquation one([](double x) { return x * x * x - 1; }, [](double x) { return 3 * x * x; });
  double x = 1e6;
  ASSERT_NE(one.solve(x), Status::solved);
  x = 1.5;
  ASSERT_EQ(one.solve(x), Status::solved);
  EXPECT_NEAR(x, 1, 1e-7);
}

TEST(InteriorPointScales, ADiagonalThatIsNoNumberIsNoSolution) {
  OneEquation one([](double x) { return std::sqrt(x) - 2; }, [](double x) { return 0.5 / std::sqrt(x); });
  double x = 0;
  EXPECT_EQ(one.solve(x), Status::not_finite);
  EXPECT_EQ(x, 0);
  x = 1;
  ASSERT_EQ(one.solve(x), Status::solved);
  EXPECT_NEAR(x, 4, 1e-6);
}

/// The caller's scale is the one that counts, whenever it was given.
TEST(InteriorPointScales, OfTheCallerStay) {
  OneEquation one([](double x) { return std::exp(x) - 2; }, [](double x) { return std::exp(x); });
  const std::vector<double> loose{1e-9};
  one.solver().set_row_scale({0}, loose);
  double x = 1;
  ASSERT_EQ(one.solve(x), Status::solved);
  EXPECT_EQ(x, 1) << "a residual of 0.7 counts for 7e-10";
}

}  // namespace test_interior_point_scales
