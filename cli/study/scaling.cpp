#include "study/scaling.hpp"

#include <cmath>

#include "graphsolve/symbolic.hpp"
#include "physics/scenes.hpp"

// The paper's setting: time step 0.01 s, friction 0.2, 100 steps, and the best of several runs. Ours is the stopping
// test: natural residual <= 1e-8 m/s, stricter than the paper's norm < 1e-6. Sizes go beyond the paper's 100.

namespace cli::study {

namespace {

physics::Mechanism make_disc(int contacts) {
  return physics::scenes::disc({.contacts = contacts, .friction = friction, .time_step = time_step});
}
physics::Mechanism make_snake(int links) {
  return physics::scenes::snake({.links = links, .friction = friction, .time_step = time_step});
}

// The last field is what the authors' own code took, of numbers.md of the project's papers, "The authors' own code": size,
// ms per step, mean Newton iterations, steps not converged. `published_source` says how they came about.
const std::array families{
    Family{
        "disc",
        "c",
        "contacts",
        make_disc,
        {{{2, .27, 19, 0}, {4, .47, 20, 0}, {10, 1.8, 27, 8}, {20, 6.0, 38, 22}, {50, 24, 58, 43}, {100, 73, 66, 51}}}},
    Family{"snake",
           "n",
           "links",
           make_snake,
           {{{2, 3.4, 57, 46},
             {5, 8.0, 60, 48},
             {10, 5.7, 31, 9},
             {20, 14, 38, 14},
             {50, 41, 40, 16},
             {100, 109, 43, 16}}}},
};

std::vector<int> sizes(Extent extent) {
  if (extent == Extent::quick) return {2, 5, 10, 20, 50, 100, 200, 500, 1000};
  return {2, 3, 4, 5, 7, 10, 14, 20, 28, 40, 50, 60, 70, 80, 90, 100, 200, 500, 1000, 2000, 5000, 10000};
}
int repeats(Extent extent) { return extent == Extent::quick ? 5 : 15; }

/// All sizes once, then all again: a machine that becomes slower bends no curve.
std::vector<Row> measure(const Family& family, Extent extent, const std::function<void()>& tick) {
  std::vector<Row> rows;
  for (const int size : sizes(extent)) {
    physics::Simulator simulator(family.make(size));
    rows.push_back({.size = size, .seconds = {}, .run = {}, .summary = physics::run(simulator, step_count).summary});
    tick();
  }
  for (int repeat = 0; repeat < repeats(extent); ++repeat)
    for (Row& row : rows) {
      tick();
      if (row.size > paper_to && repeat >= 3) continue;
      physics::Simulator simulator(family.make(row.size));
      row.run = timed_run(simulator, step_count);
      row.seconds.push_back(row.run.seconds);
    }
  return rows;
}

/// Of the order without fill, as in the paper; the simulator may take a wider one, with eight operations at a time.
void measure_differences(const Family& family, Measured& measured) {
  const auto operations = [&](int n) {
    const physics::Simulator simulator(family.make(n));
    const graphsolve::BlockGraph& graph = simulator.graph();
    return graphsolve::Symbolic(graph, graphsolve::minimum_fill_ordering(graph)).counts().operations;
  };
  long long before = operations(2);
  for (int n = 2; n <= paper_to; ++n) {
    const long long now = operations(n + 1), difference = now - before;
    measured.difference_low = n == 2 ? difference : std::min(measured.difference_low, difference);
    measured.difference_high = n == 2 ? difference : std::max(measured.difference_high, difference);
    before = now;
  }
}

/// In turns, at the paper's largest size.
double ratio_with_all_contacts(const Family& family) {
  physics::SimulatorSettings keep;
  keep.cull_contacts = false;
  std::vector<double> kept, culled;
  for (int i = 0; i < 5; ++i) {
    physics::Simulator with(family.make(paper_to), keep);
    kept.push_back(timed_run(with, step_count).seconds);
    physics::Simulator without(family.make(paper_to));
    culled.push_back(timed_run(without, step_count).seconds);
  }
  return spread(kept).best / spread(culled).best;
}

void fit(Measured& measured) {
  std::vector<double> size, iteration, step;
  for (const Row& row : measured.rows) {
    if (row.size < fit_from || row.failed()) continue;
    size.push_back(row.size);
    iteration.push_back(row.per_iteration());
    step.push_back(row.per_step());
  }
  if (size.size() < 3) {
    measured.iteration_law = measured.step_law = {.exponent = NAN, .low = NAN, .high = NAN};
    return;
  }
  measured.iteration_law = fit_power_law(size, iteration);
  measured.step_law = fit_power_law(size, step);
  measured.iteration_line = fit_line(size, iteration);
}

}  // namespace

Outcome scaling(const Conditions& conditions, const OnProgress& progress) {
  const Extent extent = conditions.extent;
  const int total = static_cast<int>(families.size() * sizes(extent).size()) * (1 + repeats(extent));
  int done = 0;
  const auto tick = [&] { progress(done++, total); };
  Outcome outcome;
  outcome.data = {
      {"time_step_s", time_step}, {"friction", friction}, {"steps", step_count}, {"tolerance_m_per_s", 1e-8}};
  for (const Family& family : families) {
    Measured measured;
    measured.rows = measure(family, extent, tick);
    fit(measured);
    measure_differences(family, measured);
    measured.ratio_all_kept = ratio_with_all_contacts(family);
    for (const Row& row : measured.rows) outcome.failed_steps += row.failed();
    outcome.text += scaling_text(family, measured, conditions.unit_nanoseconds) + "\n";
    outcome.pictures.push_back(scaling_picture(family, measured));
    outcome.data[family.name] = scaling_json(family, measured);
  }
  return outcome;
}

}  // namespace cli::study
