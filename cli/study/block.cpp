#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "graphsolve/largest.hpp"
#include "physics/scenes.hpp"
#include "study/precision.hpp"
#include "study/table.hpp"

// A block slides to rest; how far it should go is known: v0^2 / (2 mu g). Where in a step the stop falls changes the
// error from nothing to its largest, so every error is the largest over five starts that stop at different fractions of
// a step. That of `standard` is given as it is: about v0 dt/2 comes from the start, which takes v0 for the velocity
// half a step earlier.

namespace cli::study {

namespace {

using physics::FrictionModel;
using physics::Start;

constexpr double duration = 1;  // it stops after 0.68 s; what it creeps afterwards counts
constexpr double speed = 2, friction = 0.3, gravity = 9.81;
constexpr std::array stop_fractions{0.1, 0.3, 0.5, 0.7, 0.9};
constexpr std::array headings{0.0, 30.0, 45.0};
constexpr std::array models{FrictionModel::aligned, FrictionModel::pyramid};
constexpr std::array starts{Start::half_kick, Start::standard};
constexpr double usual_tolerance = 1e-8;

std::vector<int> step_counts(Extent extent) {
  if (extent == Extent::quick) return {50, 100, 200, 500, 1000};
  return {25, 50, 70, 100, 140, 200, 350, 500, 1000, 2000, 5000, 10000};
}
std::vector<double> tolerances(Extent extent) {
  if (extent == Extent::quick) return {1e-3, 1e-5, usual_tolerance};
  return {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, usual_tolerance, 1e-10};
}

/// Runs all fractions; the sample gets the largest relative error, and the sums of the rest.
Sample run_fractions(const Sample& asked, int steps) {
  Sample all = asked;
  const double slower = friction * gravity * asked.time_step;  // in one step
  for (const double fraction : stop_fractions) {
    const double v = slower * (std::round(speed / slower) + fraction), exact = v * v / (2 * friction * gravity);
    const physics::Mechanism scene =
        physics::scenes::sliding_box({.speed = v, .heading = asked.heading, .friction = friction});
    Sample one = asked;
    const physics::StepRecord end = run_sample(scene, steps, one);
    const physics::Vec3 path = end.bodies[0].position - scene.bodies[0].position;
    const double error = std::abs(path.head<2>().norm() / exact - 1);
    graphsolve::keep_largest(all.error, error);  // NaN stays: a failed step must show
    all.milliseconds += one.milliseconds / stop_fractions.size();
    all.iterations += one.iterations / stop_fractions.size();
    all.steps += one.steps;
    all.failed += one.failed;
    all.helped += one.helped;
  }
  return all;
}

struct Choice {
  double heading;
  FrictionModel model;
  Start start;
  double tolerance;
};

std::vector<Sample> pick(const std::vector<Sample>& samples, const Choice& choice) {
  std::vector<Sample> result;
  for (const Sample& s : samples)
    if (s.heading == choice.heading && s.model == choice.model && s.start == choice.start &&
        s.tolerance == choice.tolerance)
      result.push_back(s);
  return result;
}

std::vector<std::string> heads(std::vector<std::string> first, Extent extent) {
  for (const int steps : step_counts(extent)) first.push_back(number(1e3 * duration / steps) + " ms");
  return first;
}

void add_row(Table& table, std::vector<std::string> cells, const std::vector<Sample>& row, double Sample::*value,
             double scale) {
  int failed = 0;
  for (const Sample& s : row) {
    cells.push_back(number(scale * (s.*value), 3));
    failed += s.failed;
  }
  cells.push_back(fmt::to_string(failed));
  table.add(std::move(cells));
}

std::string model_table(const std::vector<Sample>& samples, Extent extent) {
  auto head = heads({"heading", "model", "start"}, extent);
  head.push_back("failed");
  Table table(head);
  for (const double heading : headings)
    for (const FrictionModel model : models)
      for (const Start start : starts)
        add_row(table, {fmt::format("{:.0f}", heading), name(model), name(start)},
                pick(samples, {heading, model, start, usual_tolerance}), &Sample::error, 100);
  return table.text();
}

std::string tolerance_table(const std::vector<Sample>& samples, Extent extent) {
  auto head = heads({"tolerance m/s", "of it"}, extent);
  head.push_back("failed");
  Table table(head);
  for (const double tolerance : tolerances(extent)) {
    const auto row = pick(samples, {45, FrictionModel::aligned, Start::half_kick, tolerance});
    add_row(table, {fmt::format("{:.0e}", tolerance), "error %"}, row, &Sample::error, 100);
    add_row(table, {"", "CPU ms"}, row, &Sample::milliseconds, 1);
  }
  return table.text();
}

/// Largest relative error [%] over the headings at 10 ms, default start and tolerance.
double largest_error(const std::vector<Sample>& samples, FrictionModel model) {
  double largest = 0;
  for (const Sample& s : samples)
    if (s.model == model && s.start == Start::half_kick && s.tolerance == usual_tolerance &&
        std::abs(s.time_step - 0.01) < 1e-12 && !(100 * s.error <= largest))
      largest = 100 * s.error;
  return largest;
}

Picture picture(const std::vector<Sample>& samples, const std::string& title) {
  Picture picture{.file = "precision-block.svg",
                  .title = title,
                  .x_label = "CPU time for 1 s of motion [ms]",
                  .y_label = "error of the stopping distance [%]",
                  .note = "sliding block, tolerance 1e-8 m/s, distance v0^2/(2 mu g), about 0.68 m. ",
                  .series = {}};
  const auto add = [&](double heading, FrictionModel model, Start start, int colour) {
    Series series{.label = fmt::format("{}, {:.0f} degrees, {}", name(model), heading, name(start)),
                  .colour = colour,
                  .mark = colour,
                  .x = {},
                  .y = {}};
    for (const Sample& s : pick(samples, {heading, model, start, usual_tolerance}))
      series.x.push_back(s.milliseconds), series.y.push_back(100 * s.error);
    picture.series.push_back(std::move(series));
  };
  add(45, FrictionModel::pyramid, Start::half_kick, 1);
  add(30, FrictionModel::pyramid, Start::half_kick, 4);
  add(45, FrictionModel::aligned, Start::standard, 3);
  add(0, FrictionModel::aligned, Start::half_kick, 0);
  add(30, FrictionModel::aligned, Start::half_kick, 5);
  add(45, FrictionModel::aligned, Start::half_kick, 2);
  return picture;
}

}  // namespace

int block_ticks(Extent extent) {
  return static_cast<int>(headings.size() * models.size() * starts.size() * tolerances(extent).size() *
                          step_counts(extent).size());
}

Outcome block_precision(Extent extent, const std::function<void()>& tick) {
  Outcome outcome;
  std::vector<Sample> samples;
  for (const double heading : headings)
    for (const FrictionModel model : models)
      for (const Start start : starts)
        for (const double tolerance : tolerances(extent))
          for (const int steps : step_counts(extent)) {
            Sample sample{.time_step = duration / steps,
                          .tolerance = tolerance,
                          .start = start,
                          .model = model,
                          .heading = heading};
            sample = run_fractions(sample, steps);
            outcome.failed_steps += sample.failed;
            samples.push_back(sample);
            tick();
          }
  const double aligned = largest_error(samples, FrictionModel::aligned);
  const double pyramid = largest_error(samples, FrictionModel::pyramid);
  const std::string finding = fmt::format(
      "At 10 ms the block stops within {} % at any heading with aligned friction,\n{} % off with the fixed pyramid",
      number(aligned, 2), number(pyramid, 2));
  outcome.data = {{"scene", "sliding_box"},
                  {"duration_s", duration},
                  {"speed_m_per_s", speed},
                  {"friction", friction},
                  {"stop_fractions_of_a_step", stop_fractions},
                  {"largest_error_at_10_ms_aligned", aligned / 100},
                  {"largest_error_at_10_ms_pyramid", pyramid / 100}};
  for (const Sample& sample : samples) outcome.data["runs"].push_back(to_json(sample, "relative_error"));
  std::string sentence = finding;
  std::replace(sentence.begin(), sentence.end(), '\n', ' ');
  outcome.text = fmt::format(
      "sliding block, {} m/s, friction {}: error of the stopping distance v0^2/(2 mu g) in %, over the time step\n"
      "(the largest of five starts that stop at different fractions of a step)\ntolerance 1e-8 m/s\n{}\naligned, "
      "half_kick, 45 degrees, over the tolerance, of which a step takes |g| dt / 100 at most\n{}{}.\n",
      speed, friction, model_table(samples, extent), tolerance_table(samples, extent), sentence);
  outcome.pictures.push_back(picture(samples, finding));
  return outcome;
}

}  // namespace cli::study
