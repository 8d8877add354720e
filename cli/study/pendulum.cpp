#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "graphsolve/largest.hpp"
#include "physics/run.hpp"
#include "physics/scenes.hpp"
#include "study/fit.hpp"
#include "study/precision.hpp"
#include "study/table.hpp"

// Positions of the five links of a pendulum after 2 s, against a reference that is extrapolated from three runs at
// much smaller time steps. What the reference itself is worth is measured too, and no error below it is believed.

namespace cli::study {

namespace {

using physics::Start;
using Positions = std::vector<physics::Vec3>;

constexpr double duration = 2;
constexpr std::array starts{Start::half_kick, Start::standard};
constexpr std::array levels{1e-3, 1e-4, 1e-5};

physics::Mechanism scene() { return physics::scenes::pendulum({.links = 5}); }

/// Steps in the 2 s.
std::vector<int> step_counts(Extent extent) {
  if (extent == Extent::quick) return {50, 100, 200, 500, 1000, 2000, 5000, 20000};
  return {50, 70, 100, 150, 200, 350, 500, 700, 1000, 1400, 2000, 5000, 10000, 20000, 50000};
}
std::vector<double> tolerances(Extent extent) {
  if (extent == Extent::quick) return {1e-2, 1e-4, 1e-6, 1e-8, 1e-10};
  return {1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10};
}

Positions positions(const physics::StepRecord& record) {
  Positions result;
  for (const physics::BodyRecord& body : record.bodies) result.push_back(body.position);
  return result;
}

double distance(const Positions& a, const Positions& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) graphsolve::keep_largest(largest, (a[i] - b[i]).norm());  // NaN stays
  return largest;
}

struct Reference {
  Positions positions;
  double uncertainty = 0;  ///< difference of the extrapolations from the coarser and from the finer two runs [m]
  double order = 0;        ///< seen in the three runs: must be 2 for the extrapolation to hold
  double time_step = 0;    ///< the smallest [s]
};

/// Second order: (4 fine - coarse) / 3 removes the leading error.
Reference reference(Extent extent, const std::function<void()>& tick) {
  const int coarsest = extent == Extent::quick ? 10000 : 20000;
  std::vector<Positions> runs;
  for (const int steps : {coarsest, 2 * coarsest, 4 * coarsest}) {
    physics::SimulatorSettings settings;
    settings.tolerance = 1e-12;
    settings.time_step = duration / steps;
    settings.start = Start::half_kick;
    physics::Simulator simulator(scene(), settings);
    physics::StepRecord record;
    static_cast<void>(physics::run(simulator, steps));
    simulator.write_record(record);
    runs.push_back(positions(record));
    if (record.step < steps)
      for (auto& x : runs.back()) x.setConstant(NAN);
    tick();
  }
  const auto extrapolate = [](const Positions& coarse, const Positions& fine) {
    Positions result;
    for (std::size_t i = 0; i < fine.size(); ++i) result.emplace_back((4 * fine[i] - coarse[i]) / 3);
    return result;
  };
  Reference result{.positions = extrapolate(runs[1], runs[2]), .time_step = duration / (4 * coarsest)};
  result.uncertainty = distance(result.positions, extrapolate(runs[0], runs[1]));
  result.order = std::log2(distance(runs[0], runs[1]) / distance(runs[1], runs[2]));
  return result;
}

/// Samples of one start and tolerance, by falling time step.
std::vector<Sample> pick(const std::vector<Sample>& samples, Start start, double tolerance) {
  std::vector<Sample> result;
  for (const Sample& s : samples)
    if (s.start == start && s.tolerance == tolerance) result.push_back(s);
  return result;
}

/// Slope of error over time step at the tightest tolerance, where the error is small enough to be regular and large
/// enough to be believed.
PowerLaw order_of(const std::vector<Sample>& samples, Start start, double tolerance, double believed) {
  std::vector<double> x, y;
  for (const Sample& s : pick(samples, start, tolerance))
    if (s.time_step <= 0.01 && s.error > 10 * believed) x.push_back(s.time_step), y.push_back(s.error);
  return x.size() >= 2 ? fit_power_law(x, y) : PowerLaw{.exponent = NAN, .low = NAN, .high = NAN};
}

struct Cost {
  double milliseconds = NAN, tolerance = 0;
  bool extrapolated = false;
};

/// CPU time for an error: between measured runs, at the tolerance where it is least. Beyond them, from the smallest
/// time step of a tolerance that does not yet show in the error: time falls with the step, error with its order.
Cost cost_of(const std::vector<Sample>& samples, Start start, double level, const std::vector<double>& tolerance_list) {
  Cost best, beyond{.extrapolated = true};
  const double least = pick(samples, start, tolerance_list.back()).back().error;
  for (const double tolerance : tolerance_list) {
    std::vector<double> x, y, dt;
    for (const Sample& s : pick(samples, start, tolerance))
      if (s.error > 0) x.push_back(s.milliseconds), y.push_back(s.error), dt.push_back(s.time_step);
    const double here = crossing(x, y, level);
    if (std::isfinite(here) && !(here >= best.milliseconds)) best = {here, tolerance, false};
    if (x.size() < 3 || std::abs(y.back() - least) > 0.01 * least) continue;
    const std::size_t from = x.size() - 3;
    const double order = fit_power_law(std::span(dt).subspan(from), std::span(y).subspan(from)).exponent;
    const double there = x.back() * std::pow(y.back() / level, 1 / order);
    if (!(there >= beyond.milliseconds)) beyond = {there, tolerance, true};
  }
  return std::isfinite(best.milliseconds) ? best : beyond;
}

std::string step_table(const std::vector<Sample>& samples, double tolerance) {
  Table table(
      {"time step s", "half_kick m", "CPU ms", "iterations", "failed", "standard m", "CPU ms", "iterations", "failed"});
  const auto half = pick(samples, Start::half_kick, tolerance), standard = pick(samples, Start::standard, tolerance);
  for (std::size_t i = 0; i < half.size(); ++i) {
    std::vector<std::string> cells{number(half[i].time_step)};
    for (const Sample& s : {half[i], standard[i]})
      for (const std::string& cell :
           {number(s.error), number(s.milliseconds), number(s.iterations), fmt::to_string(s.failed)})
        cells.push_back(cell);
    table.add(cells);
  }
  return table.text();
}

std::string tolerance_table(const std::vector<Sample>& samples, const std::vector<double>& list, Extent extent) {
  std::vector<std::string> heads{"tolerance m/s", "of it"};
  for (const int steps : step_counts(extent)) heads.push_back(number(1e3 * duration / steps) + " ms");
  Table table(heads);
  for (const double tolerance : list) {
    std::vector<std::string> errors{fmt::format("{:.0e}", tolerance), "error m"}, times{"", "CPU ms"};
    for (const Sample& s : pick(samples, Start::half_kick, tolerance)) {
      errors.push_back(number(s.error, 2));
      times.push_back(number(s.milliseconds, 2));
    }
    table.add(errors);
    table.add(times);
  }
  return table.text();
}

/// Tolerances that show: above what a step changes, a step is accepted as it is, and small enough steps never move.
std::string spoiled(const std::vector<Sample>& samples, const std::vector<double>& list) {
  const auto best = pick(samples, Start::half_kick, list.back());
  std::string text;
  for (const double tolerance : list) {
    const auto these = pick(samples, Start::half_kick, tolerance);
    for (std::size_t i = 0; i < these.size(); ++i) {
      if (these[i].error <= 2 * best[i].error) continue;
      text += fmt::format(
          "A tolerance of {:.0e} m/s spoils the result from a time step of {} ms down: steps that change less "
          "are accepted as they are.\n",
          tolerance, number(1e3 * these[i].time_step));
      break;
    }
  }
  return text;
}

std::string cost_table(const std::vector<std::array<Cost, 2>>& costs) {
  Table table({"error m", "half_kick ms", "tolerance", "standard ms", "tolerance", "standard / half_kick"});
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const auto& [half, standard] = costs[i];
    const auto cell = [](const Cost& c) { return (c.extrapolated ? "~" : "") + number(c.milliseconds); };
    table.add({fmt::format("{:.0e}", levels[i]), cell(half), fmt::format("{:.0e}", half.tolerance), cell(standard),
               fmt::format("{:.0e}", standard.tolerance), number(standard.milliseconds / half.milliseconds)});
  }
  return table.text();
}

Picture picture(const std::vector<Sample>& samples, const std::vector<double>& list, const std::string& title) {
  Picture picture{.file = "precision-pendulum.svg",
                  .title = title,
                  .x_label = "CPU time for 2 s of motion [ms]",
                  .y_label = "largest position error at 2 s [m]",
                  .note = "5-link pendulum, time steps 40 ms and less. ",
                  .series = {}};
  const auto add = [&](Start start, double tolerance, int colour) {
    Series series{.label = fmt::format("{}, tolerance {:.0e} m/s", name(start), tolerance),
                  .colour = colour,
                  .mark = colour,
                  .x = {},
                  .y = {}};
    for (const Sample& s : pick(samples, start, tolerance))
      series.x.push_back(s.milliseconds), series.y.push_back(s.error);
    picture.series.push_back(std::move(series));
  };
  add(Start::standard, list.back(), 1);
  add(Start::half_kick, 1e-2, 4);
  add(Start::half_kick, 1e-4, 5);
  add(Start::half_kick, 1e-8, 2);
  add(Start::half_kick, list.back(), 0);
  return picture;
}

struct Findings {
  Reference exact;
  std::vector<double> tolerances;
  std::vector<Sample> samples;
  PowerLaw half, standard;                 ///< error over time step
  std::vector<std::array<Cost, 2>> costs;  ///< by level and start
};

Findings measure(Extent extent, const std::function<void()>& tick) {
  Findings f{.exact = reference(extent, tick),
             .tolerances = tolerances(extent),
             .samples = {},
             .half = {},
             .standard = {},
             .costs = {}};
  for (const Start start : starts)
    for (const double tolerance : f.tolerances)
      for (const int steps : step_counts(extent)) {
        Sample sample{.time_step = duration / steps, .tolerance = tolerance, .start = start};
        sample.error = distance(positions(run_sample(scene(), steps, sample)), f.exact.positions);
        f.samples.push_back(sample);
        tick();
      }
  f.half = order_of(f.samples, Start::half_kick, f.tolerances.back(), f.exact.uncertainty);
  f.standard = order_of(f.samples, Start::standard, f.tolerances.back(), f.exact.uncertainty);
  for (const double level : levels)
    f.costs.push_back({cost_of(f.samples, Start::half_kick, level, f.tolerances),
                       cost_of(f.samples, Start::standard, level, f.tolerances)});
  return f;
}

Json to_json(const Findings& f) {
  Json data{{"scene", "pendulum:n=5"}, {"duration_s", duration}, {"error", "largest position error at the end [m]"}};
  data["reference"] = {{"smallest_time_step_s", f.exact.time_step},
                       {"tolerance_m_per_s", 1e-12},
                       {"uncertainty_m", f.exact.uncertainty},
                       {"observed_order", f.exact.order}};
  for (const auto& [start, law] : {std::pair{Start::half_kick, f.half}, std::pair{Start::standard, f.standard}})
    data["order"][name(start)] = {
        {"exponent", law.exponent}, {"low_95", law.low}, {"high_95", law.high}, {"points", law.points}};
  for (std::size_t i = 0; i < levels.size(); ++i)
    for (std::size_t k = 0; k < starts.size(); ++k)
      data["cpu_for_error"].push_back({{"error_m", levels[i]},
                                       {"start", name(starts[k])},
                                       {"cpu_ms", f.costs[i][k].milliseconds},
                                       {"tolerance_m_per_s", f.costs[i][k].tolerance},
                                       {"extrapolated", f.costs[i][k].extrapolated}});
  for (const Sample& sample : f.samples) data["runs"].push_back(to_json(sample, "error_m"));
  return data;
}

std::string text(const Findings& f, Extent extent) {
  const double tightest = f.tolerances.back();
  return fmt::format(
             "5-link pendulum, 2 s: largest position error at the end\n"
             "reference: Richardson from time steps down to {} s, observed order {:.3f}, uncertain by {} m\n\n"
             "tolerance {:.0e} m/s\n{}\nhalf_kick, over the tolerance\n{}\n"
             "CPU time for an error (~: extrapolated beyond the smallest time step)\n{}"
             "Error falls as dt^{:.2f} ({:.2f} to {:.2f}) with half_kick, dt^{:.2f} ({:.2f} to {:.2f}) with "
             "standard.\n",
             number(f.exact.time_step), f.exact.order, number(f.exact.uncertainty, 2), tightest,
             step_table(f.samples, tightest), tolerance_table(f.samples, f.tolerances, extent), cost_table(f.costs),
             f.half.exponent, f.half.low, f.half.high, f.standard.exponent, f.standard.low, f.standard.high) +
         spoiled(f.samples, f.tolerances);
}

}  // namespace

int pendulum_ticks(Extent extent) {
  return 3 + static_cast<int>(starts.size() * tolerances(extent).size() * step_counts(extent).size());
}

Outcome pendulum_precision(Extent extent, const std::function<void()>& tick) {
  const Findings f = measure(extent, tick);
  const auto& [half, standard] = f.costs[1];
  const std::string title = fmt::format(
      "Half kick: error falls as dt^{:.2f} instead of dt^{:.2f};\nan error of 0.1 mm costs {} ms, {} times less",
      f.half.exponent, f.standard.exponent, number(half.milliseconds),
      number(standard.milliseconds / half.milliseconds, 2));
  Outcome outcome{.text = text(f, extent), .data = to_json(f), .pictures = {picture(f.samples, f.tolerances, title)}};
  for (const Sample& sample : f.samples) outcome.failed_steps += sample.failed;
  return outcome;
}

}  // namespace cli::study
