#include <benchmark/benchmark.h>

#include <cstdio>
#include <string>
#include <vector>

#include "context.hpp"
#include "physics/gradients.hpp"
#include "physics/scenes.hpp"
#include "unit.hpp"

/// Time of the derivatives of a step beside the step itself: medians of thread CPU time over the same steps of one
/// run, one thread, default settings. Counters: step_us, and in steps (median over median of the step): evaluate,
/// vector_jacobian (one adjoint, all inputs), evaluate_and_vjp, jacobian (by the state, linearisation at hand),
/// smooth_evaluate (at smoothing 1e-6); steps without a derivative.
namespace {

using namespace physics;

struct Times {
  std::vector<double> step, evaluate, product, both, jacobian, smooth;
};

template <class F>
double timed(F&& f) {
  const double begin = timing::thread_time();
  f();
  return timing::thread_time() - begin;
}

void gradients(benchmark::State& state, const std::string& spec, int steps) {
  Times times;
  int without = 0;
  for (auto _ : state) {
    double sum = 0;
    Simulator simulator(built_in_scene(spec));
    StepGradient gradient(simulator), smooth(simulator, {.smoothing = 1e-6});
    std::vector<double> adjoint(gradient.state_size(), 1.0), by_all(gradient.gradient_size()),
        by_state(gradient.state_size() * static_cast<std::size_t>(gradient.state_size()));
    for (int k = 0; k < steps; ++k) {
      bool ok = true;
      times.step.push_back(timed([&] { ok = simulator.step().ok(); }));
      if (!ok) break;
      times.smooth.push_back(timed([&] { (void)smooth.evaluate(); }));
      times.evaluate.push_back(timed([&] { ok = gradient.evaluate() == GradientStatus::ready; }));
      without += !ok;
      if (!ok) continue;
      times.product.push_back(timed([&] { gradient.vector_jacobian(adjoint, by_all); }));
      times.both.push_back(times.evaluate.back() + times.product.back());
      times.jacobian.push_back(timed([&] { gradient.jacobian(StepInput::state, by_state); }));
      sum += times.both.back();
    }
    state.SetIterationTime(sum);
  }
  const double step = timing::median(times.step);
  state.counters["step_us"] = 1e6 * step;
  state.counters["evaluate"] = timing::median(times.evaluate) / step;
  state.counters["vector_jacobian"] = timing::median(times.product) / step;
  state.counters["evaluate_and_vjp"] = timing::median(times.both) / step;
  state.counters["jacobian"] = timing::median(times.jacobian) / step;
  state.counters["smooth_evaluate"] = timing::median(times.smooth) / step;
  state.counters["without"] = without;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  (void)bench::set_up();
  for (const auto& [spec, steps] : {std::pair{"quadruped", 500}, std::pair{"hopper", 500}, std::pair{"snake:n=10", 200},
                                    std::pair{"tumbling_box", 100}})
    benchmark::RegisterBenchmark((std::string("gradients/") + spec).c_str(),
                                 [spec = std::string(spec), steps = steps](benchmark::State& state) {
                                   gradients(state, spec, steps);
                                 })
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
