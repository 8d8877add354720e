#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "context.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "unit.hpp"

/// The kernels of the factorization by themselves: small equal systems side by side, few enough for the second-level cache,
/// so that one and the same kernel runs again and again. A system is a pivot and the blocks it couples to, which couple to
/// nothing else. Names: kernels/<rows of the pivot>[ with <rows of each coupled block>]/<kind>[ alone][ <instruction set>];
/// alone: pivots one by one, not in packs. Counters, per system: factor_ns, solve_ns (both where the unit takes 149 ns),
/// operations (multiplications and divisions, as counted), per_ns (operations per nanosecond of the factorization).
namespace {

using namespace graphsolve;

struct Shape {
  int pivot;
  std::vector<int> coupled;
};

struct Way {
  FactorizationKind kind;
  Packs packs;
  simd::InstructionSet set;
};

constexpr int systems = 64;

BlockGraph make_graph(const Shape& shape) {
  BlockGraph graph;
  for (int k = 0; k < systems; ++k) {
    const NodeId pivot = graph.add_node("pivot " + std::to_string(k), shape.pivot);
    for (std::size_t i = 0; i < shape.coupled.size(); ++i)
      graph.add_edge(pivot, graph.add_node("block " + std::to_string(i) + " of " + std::to_string(k), shape.coupled[i]));
  }
  return graph;
}

/// Dominant diagonals and entries between -1 and 1.
void fill(const BlockGraph& graph, const Symbolic& symbolic, std::span<double> values) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int k = 0; k < graph.size(); ++k) {
    const BlockHandle own = symbolic.block({k}, {k});
    for (int j = 0; j < own.columns; ++j)
      for (int i = 0; i <= j; ++i) values[own.place(i, j)] = values[own.place(j, i)] = number(random) + (i == j ? 40.0 : 0.0);
    for (const auto& edge : graph.edges({k})) {
      if (edge.to.index < k) continue;
      const BlockHandle right = symbolic.block({k}, edge.to), below = symbolic.block(edge.to, {k});
      for (int j = 0; j < right.columns; ++j)
        for (int i = 0; i < right.rows; ++i) values[right.place(i, j)] = values[below.place(j, i)] = number(random);
    }
  }
}

void kernel(benchmark::State& state, const Shape& shape, const Way& way) {
  const simd::InstructionSet before = simd::instruction_set();
  simd::use_instruction_set(way.set);
  const BlockGraph graph = make_graph(shape);
  const auto symbolic = std::make_shared<const Symbolic>(graph, natural_ordering(graph), way.packs);
  Factorization factorization(symbolic, way.kind);
  std::vector<double> values(factorization.values().size()), right(static_cast<std::size_t>(graph.rows()), 1.0), x = right;
  fill(graph, *symbolic, values);
  constexpr int rounds = 20;  // of one reading of the clock
  std::vector<double> factor, solve;
  timing::Units units;
  Factorization::Outcome outcome;
  for (auto _ : state) {
    if (factor.size() % 64 == 0) units.measure();
    double copying = 0, begin = timing::thread_time();
    for (int k = 0; k < rounds; ++k) std::copy(values.begin(), values.end(), factorization.values().begin());
    copying = timing::thread_time() - begin;
    begin = timing::thread_time();
    for (int k = 0; k < rounds; ++k) {
      std::copy(values.begin(), values.end(), factorization.values().begin());
      outcome = factorization.factorize();
    }
    factor.push_back(timing::thread_time() - begin - copying);
    begin = timing::thread_time();
    for (int k = 0; k < rounds; ++k) {
      std::copy(right.begin(), right.end(), x.begin());
      factorization.solve(x);
    }
    solve.push_back(timing::thread_time() - begin);
    state.SetIterationTime(factor.back() + solve.back());
  }
  simd::use_instruction_set(before);
  if (!outcome.ok()) return state.SkipWithError("the factorization failed");
  const double each = 1e9 / (rounds * systems) / units.slowness();
  const double factor_ns = each * timing::median(factor);
  state.counters["factor_ns"] = factor_ns;
  state.counters["solve_ns"] = each * timing::median(solve);
  state.counters["operations"] = static_cast<double>(outcome.operations) / systems;
  state.counters["per_ns"] = static_cast<double>(outcome.operations) / systems / factor_ns;
}

std::string name_of(const Shape& shape) {
  std::string text = std::to_string(shape.pivot);
  for (std::size_t i = 0; i < shape.coupled.size(); ++i) text += (i == 0 ? " with " : "+") + std::to_string(shape.coupled[i]);
  return text;
}

void add(const Shape& shape, const Way& way) {
  std::string name = "kernels/" + name_of(shape) + (way.kind == FactorizationKind::ldu ? "/ldu" : "/ldlt");
  if (way.packs == Packs::off) name += " alone";
  name += " " + std::string(simd::name(way.set));
  benchmark::RegisterBenchmark(name.c_str(), [shape, way](benchmark::State& state) { kernel(state, shape, way); })
      ->UseManualTime()
      ->MinTime(0.02)
      ->Unit(benchmark::kMicrosecond);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  (void)bench::set_up();
  const std::vector<Shape> shapes{{1, {}}, {3, {}}, {6, {}}, {12, {}}, {3, {6}}, {3, {6, 6}}, {5, {6, 6}}, {6, {3}}, {6, {6}}, {6, {6, 6}}, {12, {4}}};
  for (const Shape& shape : shapes)
    for (const FactorizationKind kind : {FactorizationKind::ldlt, FactorizationKind::ldu})
      for (const Packs packs : {Packs::on, Packs::off})
        for (const simd::InstructionSet set : simd::instruction_sets()) add(shape, {kind, packs, set});
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
