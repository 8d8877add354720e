#include <benchmark/benchmark.h>

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "context.hpp"
#include "physics/scenes.hpp"
#include "physics/simulator.hpp"
#include "unit.hpp"

#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
#define GRAPHSOLVE_KNOWS_ITS_HEAP
#endif

/// Time of a step: medians of thread CPU time, one thread, default settings, without the time of reading the clock. Setting up
/// a simulator is not timed.
/// Counters: us (median of a step), us_ref (the same where the unit takes 149 ns; compare this with the bars),
/// mean_us_ref (of all steps, which counts the impacts that the median does not see), spread (from the 25th to the
/// 75th percentile [us]), iterations (mean), us_it (time over iterations), failed steps; where the time went, in us per step
/// here, of a run beside these with SimulatorSettings::time_phases: prepare, evaluate, factorize, solve, finish.
/// GRAPHSOLVE_SIMD=avx2 or plain shows machines without AVX-512.
namespace {

using namespace physics;

struct Measurement {
  std::vector<double> steps;  ///< [s]
  timing::Units units;
  double time = 0;            ///< of all of them [s]
  long long iterations = 0;
  int failed = 0;
};

/// Runs `steps` steps and adds them; stops at a step that fails.
void measure(Simulator& simulator, int steps, Measurement& sum) {
  static const double clock = timing::clock_time();
  for (int i = 0; i < steps; ++i) {
    const double begin = timing::thread_time();
    const StepResult result = simulator.step();
    const double time = timing::thread_time() - begin - clock;
    sum.steps.push_back(time);
    sum.time += time;
    sum.iterations += result.iterations;
    if (result.ok()) continue;
    ++sum.failed;
    return;
  }
}

void measure(const std::string& spec, int steps, Measurement& sum) {
  Simulator simulator(built_in_scene(spec));
  measure(simulator, steps, sum);
}

void report(benchmark::State& state, Measurement sum) {
  const double us = 1e6 * timing::median(sum.steps), scaled = 1 / sum.units.slowness();
  std::sort(sum.steps.begin(), sum.steps.end());
  const std::size_t n = sum.steps.size();
  state.counters["us"] = us;
  state.counters["us_ref"] = us * scaled;
  state.counters["mean_us_ref"] = 1e6 * sum.time / static_cast<double>(n) * scaled;
  state.counters["spread"] = 1e6 * (sum.steps[n * 3 / 4] - sum.steps[n / 4]);
  state.counters["iterations"] = static_cast<double>(sum.iterations) / static_cast<double>(n);
  state.counters["us_it"] = 1e6 * sum.time / static_cast<double>(std::max(sum.iterations, 1LL));
  state.counters["failed"] = sum.failed;
}

/// The scenes that have a bar. `steps` covers what the name says.
void step(benchmark::State& state, const std::string& spec, int steps) {
  Measurement sum;
  for (auto _ : state) {
    sum.units.measure();
    const double before = sum.time;
    measure(spec, steps, sum);
    state.SetIterationTime(sum.time - before);
  }
  report(state, std::move(sum));
  SimulatorSettings with_phases;
  with_phases.time_phases = true;
  Simulator timed(built_in_scene(spec), with_phases);
  Measurement unused;
  measure(timed, steps, unused);
  const PhaseTimes& phases = timed.phase_times();
  for (const auto& [phase, time] : {std::pair{"prepare", phases.prepare}, std::pair{"evaluate", phases.evaluate},
                                    std::pair{"factorize", phases.factorize}, std::pair{"solve", phases.solve},
                                    std::pair{"finish", phases.finish}})
    state.counters[phase] = 1e6 * time / static_cast<double>(unused.steps.size());
}

/// The hard case: a snake that slides, in the middle of its way, at a thousandth of the time step and the paper's
/// tolerance. Every contact presses and slips, and 1e-6 m/s over 10 us is stiff.
void sliding_at_small_steps(benchmark::State& state) {
  const Mechanism scene = built_in_scene("snake:n=100");
  StepRecord middle;
  Simulator coarse(scene);
  for (int k = 0; k < 30; ++k) (void)coarse.step();
  coarse.write_record(middle);
  Measurement sum;
  for (auto _ : state) {
    sum.units.measure();
    SimulatorSettings settings;
    settings.tolerance = 1e-6;
    settings.time_step = 1e-5;
    Simulator simulator(scene, settings);
    simulator.restart_from(middle);
    const double before = sum.time;
    measure(simulator, 300, sum);
    state.SetIterationTime(sum.time - before);
  }
  report(state, std::move(sum));
}

/// Every link carries two others by spherical joints; they swing because gravity is not along z.
Mechanism balanced_tree(int links) {
  Mechanism scene;
  scene.name = "tree";
  scene.time_step = 1e-3;
  scene.gravity = {3, 1, -9};
  for (int i = 0; i < links; ++i) {
    const int parent = (i - 1) / 2;
    const double side = i % 2 == 0 ? 0.2 : -0.2;
    Body body;
    body.name = "link " + std::to_string(i);
    body.mass = 1;
    body.inertia = Vec3(0.02, 0.02, 0.005).asDiagonal();
    body.position = i == 0 ? Vec3(0, 0, -0.2) : Vec3(scene.bodies[parent].position + Vec3(side, 0, -0.4));
    Joint joint;
    joint.name = "joint " + std::to_string(i);
    joint.type = JointType::spherical;
    joint.parent = i == 0 ? world : BodyId{parent};
    joint.child = scene.add(std::move(body));
    joint.parent_point = i == 0 ? Vec3(0, 0, 0) : Vec3(side, 0, -0.2);
    joint.child_point = {0, 0, 0.2};
    scene.add(std::move(joint));
  }
  return scene;
}

/// Counter ns_body_it_ref: nanoseconds per link and iteration where the unit takes 149 ns, median of the steps.
void tree(benchmark::State& state, int links) {
  Measurement sum;
  for (auto _ : state) {
    sum.units.measure();
    const double before = sum.time;
    Simulator simulator(balanced_tree(links));
    measure(simulator, 100, sum);
    state.SetIterationTime(sum.time - before);
  }
  const double iterations = static_cast<double>(sum.iterations) / static_cast<double>(sum.steps.size());
  state.counters["ns_body_it_ref"] = 1e9 * timing::median(sum.steps) / sum.units.slowness() / links / std::max(iterations, 1.0);
  report(state, std::move(sum));
}

std::map<std::string, std::vector<std::pair<double, double>>>& scaling_points() {
  static std::map<std::string, std::vector<std::pair<double, double>>> points;
  return points;
}

double slope(const std::vector<std::pair<double, double>>& points) {
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [size, time] : points) {
    const double a = std::log(size), b = std::log(time);
    x += a, y += b, xx += a * a, xy += a * b;
  }
  const auto n = static_cast<double>(points.size());
  return (n * xy - x * y) / (n * xx - x * x);
}

/// Time per iteration over size; the last counter is the log-log slope of all sizes so far.
void scaling(benchmark::State& state, const std::string& name, const std::string& parameter) {
  const auto size = state.range(0);
  const std::string spec = name + ":" + parameter + "=" + std::to_string(size);
  Measurement sum;
  for (auto _ : state) {
    sum.units.measure();
    const double before = sum.time;
    measure(spec, 60, sum);  // the same fall, impact and slide at every size
    state.SetIterationTime(sum.time - before);
  }
  auto& points = scaling_points()[name];
  points.emplace_back(static_cast<double>(size), sum.time / static_cast<double>(std::max(sum.iterations, 1LL)));
  report(state, std::move(sum));
  if (points.size() > 1) state.counters["slope"] = slope(points);
}

/// Spheres in a row, each on the floor by itself.
Mechanism balls(int count) {
  const Mechanism one = built_in_scene("spinning_sphere");
  Mechanism scene = one;
  scene.bodies.clear(), scene.contacts.clear();
  for (int i = 0; i < count; ++i) {
    Body body = one.bodies.front();
    Contact contact = one.contacts.front();
    body.name = "ball " + std::to_string(i);
    body.position.y() = i;
    contact.name = "floor " + std::to_string(i);
    contact.body = scene.add(std::move(body));
    scene.add(std::move(contact));
  }
  return scene;
}

#ifdef GRAPHSOLVE_KNOWS_ITS_HEAP
/// Counter bytes_body: of the heap, per body with one contact, of a simulator that has taken a step; between 750 and 1500,
/// where vectors that have grown by doubling are half empty. physics_tests counts the same and holds it.
void memory(benchmark::State& state) {
  const auto held = [](int count) {
    const auto in_use = [] {
      const auto heap = mallinfo2();
      return static_cast<double>(heap.uordblks + heap.hblkhd);
    };
    const Mechanism scene = balls(count);
    const double before = in_use();
    Simulator simulator(scene);
    (void)simulator.step();
    return in_use() - before;
  };
  for (auto _ : state) state.counters["bytes_body"] = (held(1500) - held(750)) / 750;
}
#endif

void add(const std::string& name, const std::string& spec, int steps) {
  benchmark::RegisterBenchmark(name.c_str(), [spec, steps](benchmark::State& state) { step(state, spec, steps); })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  (void)bench::set_up();
  // Dropped, sliding and coming to rest. The bars: 30, 10, 15 and 30 us, at a unit of 149 ns.
  add("step/snake n=100", "snake:n=100", 100);
  add("step/disc c=100", "disc:c=100", 100);
  add("step/pendulum n=100", "pendulum:n=100,dt=0.001", 100);
  add("step/quadruped", "quadruped", 1000);
  benchmark::RegisterBenchmark("step/tree n=1023", [](benchmark::State& state) { tree(state, 1023); })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("step/snake n=100 sliding, dt 10 us, 1e-6", sliding_at_small_steps)
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
#ifdef GRAPHSOLVE_KNOWS_ITS_HEAP
  benchmark::RegisterBenchmark("memory/balls", memory)->Iterations(1)->Unit(benchmark::kMillisecond);
#endif
  for (const auto& [name, parameter, most] : {std::tuple{"snake", "n", 10'000}, std::tuple{"disc", "c", 10'000}}) {
    auto* sizes = benchmark::RegisterBenchmark((std::string("scaling/") + name).c_str(),
                                               [name = name, parameter = parameter](benchmark::State& state) {
                                                 scaling(state, name, parameter);
                                               });
    for (int size = 10; size <= most; size *= 10) {
      sizes->Arg(size);
      if (3 * size < most) sizes->Arg(3 * size);
    }
    sizes->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  for (const auto& [name, points] : scaling_points())
    if (points.size() > 1)
      std::fprintf(stderr, "%s: log-log slope of the time per iteration %.3f\n", name.c_str(), slope(points));
}
