// A Term, a Port and a Law of one's own: a rectifier. docs/write_a_term.md explains them line by line.
//
//   a generator with its middle at ground feeds two nodes, `plus` (+E) and `minus` (-E), each through 2 ohm; from each a
//   diode (0.7 V) leads to `out`; there hang a lamp and a limiting diode (5.1 V) to ground.
//
// Run: build/release/bin/write_a_term. Expected: the derivative checkers are content; then the voltage over the lamp for a
// sweep of E, next to the value found by bisection of the same circuit by hand, min(v, 5.1) with
// (|E| - 0.7 - v) / 2 = i_lamp(v); and the sum of currents at every node.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <vector>

#include "../no_arguments.hpp"
#include "across.hpp"
#include "branch.hpp"
#include "graphsolve/bound.hpp"
#include "graphsolve/derivative_check.hpp"
#include "graphsolve/interior_point.hpp"
#include "graphsolve/nonnegative.hpp"
#include "interval.hpp"

using namespace graphsolve;

namespace {

constexpr double inner_ohm = 2, diode_volt = 0.7, limit_volt = 5.1;
const Branch lamp{{2}, {}, 5, 0, 3};  // out to ground: 5 ohm when cold, saturates from 3 V

struct Circuit {
  explicit Circuit(double emf) {
    const NodeId plus = graph.add_node("plus", 1), minus = graph.add_node("minus", 1), out = graph.add_node("out", 1);
    branches.add({plus, {}, inner_ohm, emf});
    branches.add({minus, {}, inner_ohm, -emf});
    branches.add(lamp);
    diodes.add(Across(plus, out, diode_volt), Nonnegative());
    diodes.add(Across(minus, out, diode_volt), Nonnegative());
    limiter.add(Bound(out, 0, Bound::Side::lower, 0), Interval(limit_volt));
  }
  BlockGraph graph;
  Branches branches;
  PortLawBatch<Across, Nonnegative> diodes;
  PortLawBatch<Bound, Interval> limiter;
};

const char* verdict(const DerivativeReport& report, double tolerance) {
  if (report.largest_error <= tolerance) return "right";
  std::printf("error %.1e at %s: ", report.largest_error, report.where.c_str());
  return "WRONG";
}

void check_derivatives() {
  Circuit circuit(3);
  Problem problem(circuit.graph);
  problem.add(circuit.branches);
  const std::vector<double> x{2.5, -1.5, 1.7};
  std::printf("term: %s\n", verdict(check_terms(problem, x), 1e-8));

  BlockGraph pair;
  const NodeId a = pair.add_node("a", 1), b = pair.add_node("b", 1);
  pair.add_edge(a, b);
  const Symbolic symbolic(pair, natural_ordering(pair));
  Across port(a, b, diode_volt);
  port.wire(Wiring(symbolic, pair));
  std::printf("port: %s\n", verdict(check_port(port, symbolic, std::vector{0.4, 0.1}), 1e-9));

  Interval law(limit_volt);
  law.start_cold(0.7, 1);
  std::printf("law: %s\n", verdict(check_law(law, std::vector{1.3}, std::vector{-0.2}, 0.01), 1e-4));
}

/// The voltage over the lamp, without the solver.
double by_hand(double emf) {
  double low = 0, high = std::max(std::abs(emf) - diode_volt, 0.0);
  for (int k = 0; k < 100; ++k) {
    const double v = 0.5 * (low + high);
    ((std::abs(emf) - diode_volt - v) / inner_ohm > lamp.current(v) ? low : high) = v;
  }
  return std::min(low, limit_volt);
}

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words,
               "A rectifier, of a term, a port and a law of one's own; docs/write_a_term.md explains them.");
  check_derivatives();
  double worst = 0, lost = 0;
  for (const double emf : {-9.0, -6.0, -3.0, -0.5, 0.0, 0.5, 3.0, 6.0, 9.0}) {
    Circuit circuit(emf);
    Problem problem(circuit.graph);
    problem.add(circuit.branches);
    problem.add(circuit.diodes);
    problem.add(circuit.limiter);
    InteriorPoint solver(problem,
                         std::make_shared<const Symbolic>(problem.graph(), minimum_fill_ordering(problem.graph())));
    std::vector<double> x(3, 0.0);
    const Status status = solver.solve(x);
    if (status != Status::solved) {
      std::printf("E = %g V: %s: %s\n", emf, name(status).data(), explanation(status).data());
      return 1;
    }
    const double through[2] = {circuit.diodes.law(0).force(), circuit.diodes.law(1).force()};
    const double limited = -circuit.limiter.law(0).force();
    std::printf("E = %4.1f V: lamp %.6f V, by hand %.6f V; diodes %.4f A and %.4f A, limiter %.4f A\n", emf, x[2],
                by_hand(emf), through[0], through[1], limited);
    worst = std::max(worst, std::abs(x[2] - by_hand(emf)));
    lost = std::max({lost, std::abs((x[0] - emf) / inner_ohm + through[0]),
                     std::abs((x[1] + emf) / inner_ohm + through[1]),
                     std::abs(lamp.current(x[2]) + limited - through[0] - through[1])});
  }
  std::printf("largest difference %s, current lost at a node %s\n", worst < 1e-7 ? "< 1e-7 V" : "too large",
              lost < 1e-7 ? "< 1e-7 A" : "too large");
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "write_a_term: %s\n", error.what());
  return 2;
}
