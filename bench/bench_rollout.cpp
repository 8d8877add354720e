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
/// env_steps_per_s (here), and where the time went, in ns per step of a copy here, of runs
/// beside these with SimulatorSettings::time_phases: prepare, evaluate, factorize, solve, finish;
/// iterations (mean per step of a copy), failed (copies).
namespace {

using namespace physics;

struct Sum {
  double time = 0;  ///< [s]
  long long env_steps = 0, iterations = 0;
  int failed = 0;
  PhaseTimes phases;
};

/// Steps of a new batch, added.
void run(const Mechanism& scene, int lanes, int steps, const SimulatorSettings& settings, Sum& sum) {
  BatchSimulator simulator(scene, lanes, settings);
  for (int lane = 0; lane < lanes; ++lane) {
    Mechanism copy = scene;
    for (Body& body : copy.bodies) body.velocity.x() += 0.01 * lane;
    simulator.load(lane, copy);
  }
  const double begin = timing::thread_time();
  for (int k = 0; k < steps; ++k) {
    simulator.step();
    for (int lane = 0; lane < lanes; ++lane) sum.iterations += simulator.result(lane).iterations;
  }
  sum.time += timing::thread_time() - begin;
  for (int lane = 0; lane < lanes; ++lane) {
    sum.env_steps += simulator.step_index(lane);
    sum.failed += !simulator.running(lane);
  }
  sum.phases += simulator.phase_times();
}

void batch(benchmark::State& state, const std::string& spec, int steps) {
  const int lanes = static_cast<int>(state.range(0));
  const Mechanism scene = built_in_scene(spec);
  Sum sum, timed;
  timing::Units units;
  for (auto _ : state) {
    units.measure();
    const double before = sum.time;
    run(scene, lanes, steps, {}, sum);
    state.SetIterationTime(sum.time - before);
  }
  SimulatorSettings with_phases;
  with_phases.time_phases = true;
  for (int k = 0; k < 10; ++k) run(scene, lanes, steps, with_phases, timed);
  const auto n = static_cast<double>(sum.env_steps);
  state.counters["env_steps_per_s_ref"] = n / sum.time * units.slowness();
  state.counters["env_steps_per_s"] = n / sum.time;
  const auto phase = [&](const char* name, double time) {
    state.counters[name] = 1e9 * time / static_cast<double>(timed.env_steps);
  };
  phase("prepare", timed.phases.prepare);
  phase("evaluate", timed.phases.evaluate);
  phase("factorize", timed.phases.factorize);
  phase("solve", timed.phases.solve);
  phase("finish", timed.phases.finish);
  state.counters["iterations"] = static_cast<double>(sum.iterations) / n;
  state.counters["failed"] = sum.failed;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
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
