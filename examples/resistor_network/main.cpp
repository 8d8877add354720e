// Resistances between nodes of electrical networks, held against closed forms.
//
//   L v = i,   L = sum over resistors of 1/R (e_a - e_b)(e_a - e_b)'   with one node grounded (left out)
//
// The resistance between a and b is v_a - v_b when one ampere enters at a and leaves at b.
// Run: build/release/bin/resistor_network. Expected: a torus (every resistor of an edge-transitive network of N nodes and
// E equal resistors sees (N - 1) / E), a ladder (quotients of Fibonacci numbers), a cube (5/6); the current balance at every
// node; and a network with a part that hangs in the air, which is named.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "../no_arguments.hpp"
#include "graphsolve/diagnosis.hpp"

using namespace graphsolve;

namespace {

struct Resistor {
  int a, b;
  double ohm = 1;
};

/// Node 0 is ground. Potentials of all nodes when one ampere enters at `in` and leaves at `out`.
class Network {
 public:
  Network(int nodes, std::vector<Resistor> resistors) : resistors_(std::move(resistors)) {
    for (int k = 1; k < nodes; ++k) graph_.add_node("node " + std::to_string(k), 1);
    for (const auto& [a, b, ohm] : resistors_)
      if (a > 0 && b > 0) graph_.add_edge(node(a), node(b));
    symbolic_ = std::make_shared<const Symbolic>(graph_, minimum_fill_ordering(graph_));
    factorization_.emplace(symbolic_, FactorizationKind::cholesky);
    Factorization& f = *factorization_;
    f.allow_refinement();
    f.keep_matrix(true);  // for the diagnosis
    for (const auto& [a, b, ohm] : resistors_) {
      if (a > 0) f.entry(symbolic_->block(node(a), node(a))) += 1 / ohm;
      if (b > 0) f.entry(symbolic_->block(node(b), node(b))) += 1 / ohm;
      if (a == 0 || b == 0) continue;
      f.entry(symbolic_->block(node(a), node(b))) -= 1 / ohm;
      f.entry(symbolic_->block(node(b), node(a))) -= 1 / ohm;
    }
    outcome_ = f.factorize();
  }

  /// Names of the nodes whose potentials the equations leave open: those of the null vector. Empty when there are none.
  [[nodiscard]] std::vector<std::string> floating_part() const {
    const Diagnosis diagnosis = diagnose(graph_, *factorization_, outcome_);
    std::vector<std::string> names;
    if (diagnosis.smallest_singular <= 1e-12 * diagnosis.largest_singular)
      for (const Diagnosis::Share& share : diagnosis.near_null) names.push_back(share.node);
    std::sort(names.begin(), names.end());
    return names;
  }

  [[nodiscard]] double resistance(int in, int out) {
    std::vector<double> v(symbolic_->rows(), 0.0);
    if (in > 0) v[in - 1] += 1;
    if (out > 0) v[out - 1] -= 1;
    factorization_->solve(v);
    v.insert(v.begin(), 0.0);
    std::vector<double> balance(v.size(), 0.0);
    balance[in] -= 1, balance[out] += 1;
    for (const auto& [a, b, ohm] : resistors_) {
      const double current = (v[a] - v[b]) / ohm;
      balance[a] += current, balance[b] -= current;
    }
    for (const double b : balance) worst_balance = std::max(worst_balance, std::abs(b));
    return v[in] - v[out];
  }
  double worst_balance = 0;

 private:
  static NodeId node(int k) { return {k - 1}; }
  std::vector<Resistor> resistors_;
  BlockGraph graph_;
  std::shared_ptr<const Symbolic> symbolic_;
  std::optional<Factorization> factorization_;
  Factorization::Outcome outcome_;
};

Network torus(int side) {
  std::vector<Resistor> resistors;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      resistors.push_back({i * side + j, i * side + (j + 1) % side});
      resistors.push_back({i * side + j, (i + 1) % side * side + j});
    }
  return {side * side, resistors};
}

/// Node k is joined to k + 1 and to ground.
Network ladder(int rungs) {
  std::vector<Resistor> resistors;
  for (int k = 1; k <= rungs; ++k) {
    resistors.push_back({k, 0});
    resistors.push_back({k, k + 1});
  }
  return {rungs + 2, resistors};
}

Network cube() {
  std::vector<Resistor> resistors;
  for (int k = 0; k < 8; ++k)
    for (const int bit : {1, 2, 4})
      if (!(k & bit)) resistors.push_back({k, k | bit});
  return {8, resistors};
}

void compare(const char* name, double computed, double closed_form, const Network& network) {
  std::printf("%s: %.12f, closed form %.12f, current balance %s\n", name, computed, closed_form,
              network.worst_balance < 1e-13 ? "< 1e-13" : "violated");
}

}  // namespace

int main(int count, char** words) try {
  no_arguments(count, words, "Resistances between nodes of electrical networks, held against closed forms.");
  Network t = torus(30), l = ladder(6), c = cube();
  compare("torus of 30 x 30, neighbours", t.resistance(0, 1), 899.0 / 1800.0, t);
  compare("torus of 30 x 30, others", t.resistance(437, 438), 899.0 / 1800.0, t);
  double f[2] = {0, 1};  // Fibonacci numbers F(2n), F(2n + 1)
  for (int k = 0; k < 6; ++k) f[0] += f[1], f[1] += f[0];
  // Rungs and rails of 1 ohm, open end: F(2n+1) / F(2n) seen from a rail.
  compare("ladder of 6 rungs", l.resistance(7, 0), f[1] / f[0], l);
  compare("cube, corner to corner", c.resistance(0, 7), 5.0 / 6.0, c);
  const Network floating(6, {{0, 1}, {1, 2, 0.3}, {3, 4, 0.3}, {4, 5, 0.7}, {5, 3, 1.1}});
  std::printf("without a way to ground:");
  for (const std::string& name : floating.floating_part()) std::printf(" '%s'", name.c_str());
  std::printf("\nopen potentials in the cube: %zu\n", c.floating_part().size());
} catch (const std::exception& error) {  // a word in GRAPHSOLVE_SIMD or behind its name that it does not know
  std::fprintf(stderr, "resistor_network: %s\n", error.what());
  return 2;
}
