#include <benchmark/benchmark.h>

#include <cstdio>
#include <string>
#include <vector>

#include "context.hpp"
#include "physics/batch_simulator.hpp"
#include "physics/scenes.hpp"
#include "unit.hpp"

/// Steps of batches: one thread, thread CPU time, default settings, through falls, impacts, sliding and rest. Counters:
/// env_steps_per_s_ref (steps of single copies per second where the unit takes 149 ns; compare this with the bars),
/// env_steps_per_s (here), and where the time went, in ns per step of a copy here: prepare, evaluate, factorize, solve, finish;
/// iterations (mean per step of a copy), failed (copies).
namespace {

using namespace physics;

void batch(benchmark::State& state, const std::string& spec, int steps) {
  const int lanes = static_cast<int>(state.range(0));
  const Mechanism scene = built_in_scene(spec);
  double time = 0;
  long long env_steps = 0, iterations = 0;
  int failed = 0;
  PhaseTimes phases;
  bench::Units units;
  for (auto _ : state) {
    units.measure();
    BatchSimulator simulator(scene, lanes);
    for (int lane = 0; lane < lanes; ++lane) {
      Mechanism copy = scene;
      for (Body& body : copy.bodies) body.velocity.x() += 0.01 * lane;
      simulator.load(lane, copy);
    }
    const double begin = bench::thread_time();
    for (int k = 0; k < steps; ++k) {
      simulator.step();
      for (int lane = 0; lane < lanes; ++lane) iterations += simulator.result(lane).iterations;
    }
    const double spent = bench::thread_time() - begin;
    for (int lane = 0; lane < lanes; ++lane) {
      env_steps += simulator.step_index(lane);
      failed += !simulator.running(lane);
    }
    const PhaseTimes& p = simulator.phase_times();
    phases.prepare += p.prepare, phases.evaluate += p.evaluate, phases.factorize += p.factorize, phases.solve += p.solve,
        phases.finish += p.finish;
    time += spent;
    state.SetIterationTime(spent);
  }
  const auto n = static_cast<double>(env_steps);
  state.counters["env_steps_per_s_ref"] = n / time * units.slowness();
  state.counters["env_steps_per_s"] = n / time;
  state.counters["prepare"] = 1e9 * phases.prepare / n;
  state.counters["evaluate"] = 1e9 * phases.evaluate / n;
  state.counters["factorize"] = 1e9 * phases.factorize / n;
  state.counters["solve"] = 1e9 * phases.solve / n;
  state.counters["finish"] = 1e9 * phases.finish / n;
  state.counters["iterations"] = static_cast<double>(iterations) / n;
  state.counters["failed"] = failed;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  (void)bench::set_up();
  const auto add = [](const char* name, const char* spec, int steps) {
    benchmark::RegisterBenchmark(name, batch, spec, steps)
        ->Arg(1)->Arg(8)->Arg(16)->Arg(64)->UseManualTime()->Unit(benchmark::kMillisecond);
  };
  add("box", "sliding_box", 100);
  add("snake_10", "snake:n=10", 100);
  add("quadruped", "quadruped", 100);
  benchmark::RunSpecifiedBenchmarks();
}
