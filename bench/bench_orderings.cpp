#include <benchmark/benchmark.h>

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "context.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"
#include "support/graph_families.hpp"
#include "support/problem_families.hpp"
#include "unit.hpp"

/// Time to find an order and to work out the elimination: medians of thread CPU time, one thread. Making the graph is
/// not timed. Names are "setup/family" for the default ordering on every family and "orderings/family/ordering" for
/// all. Counters, per node of the graph: ordering_us, symbolic_us, us_ref (of both where the unit takes 149 ns; compare
/// this with the bars), bytes (of Symbolic and one Factorization), operations; and nodes, fill (scalars of the factor
/// over those of the matrix), forced (nodes against the eligibility rule).
namespace {

using namespace graphsolve;
using families::Family;
using families::Spec;

void setup(benchmark::State& state, const Spec& spec, OrderingMethod method) {
  const BlockGraph graph = families::make_graph(spec);
  std::vector<double> ordering_times, symbolic_times, both;
  Ordering ordering;
  std::optional<Symbolic> symbolic;
  timing::Units units;
  for (auto _ : state) {
    units.measure();
    symbolic.reset();
    const double begin = timing::thread_time();
    ordering = make_ordering(graph, method);
    const double middle = timing::thread_time();
    symbolic.emplace(graph, ordering);
    const double end = timing::thread_time();
    ordering_times.push_back(middle - begin);
    symbolic_times.push_back(end - middle);
    both.push_back(end - begin);
    state.SetIterationTime(both.back());
  }
  const double per_node = 1e6 / graph.size();
  const Symbolic::Counts& counts = symbolic->counts();
  state.counters["nodes"] = graph.size();
  state.counters["ordering_us"] = per_node * timing::median(ordering_times);
  state.counters["symbolic_us"] = per_node * timing::median(symbolic_times);
  state.counters["us_ref"] = per_node * timing::median(both) / units.slowness();
  state.counters["bytes"] = static_cast<double>(counts.memory) / graph.size();
  state.counters["operations"] = static_cast<double>(counts.operations) / graph.size();
  state.counters["fill"] = families::fill_factor(*symbolic);
  state.counters["forced"] = ordering.forced;
}

void add(const std::string& name, const Spec& spec, OrderingMethod method) {
  benchmark::RegisterBenchmark(name.c_str(), [spec, method](benchmark::State& state) { setup(state, spec, method); })
      ->UseManualTime()
      ->MinTime(0.1)
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  (void)bench::set_up();
  for (const Family family : families::all_families())
    for (const int n : {1000, 10'000}) {
      const Spec spec{.family = family, .n = n};
      if (family != Family::quadruped || n == 1000) add("setup/" + describe(spec), spec, OrderingMethod::minimum_fill);
    }
  for (const int n : {100'000, 1'000'000}) {
    const Spec spec{.family = Family::chain, .n = n};
    add("setup/" + describe(spec), spec, OrderingMethod::minimum_fill);
  }
  for (const Family family : families::all_families())
    for (const OrderingMethod method : ordering_methods()) {
      const Spec spec{.family = family, .n = 1000};
      if (available(method)) add("orderings/" + describe(spec) + "/" + std::string(name(method)), spec, method);
    }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
