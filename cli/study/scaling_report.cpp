#include <fmt/format.h>

#include <cmath>

#include "study/scaling.hpp"
#include "study/table.hpp"

namespace cli::study {

namespace {

constexpr double published_unit_nanoseconds = 149;
/// No figure of the paper, and none that a study measures.
constexpr const char* published_source =
    "ConstrainedDynamics.jl 0.9.1 with GraphBasedSystems.jl 1.2.0 (Julia), run once by this project at its test of 1e-6 "
    "on another machine of this kind, unit 149 ns; from numbers.md of the project's papers, section 'The authors' own "
    "code'; ratios carry over, absolute times do not";

std::string finding(const Family& family, const Measured& measured) {
  const PowerLaw& law = measured.iteration_law;
  return fmt::format("Time per iteration grows as {}^{:.2f} (95 %: {:.2f} to {:.2f}):\n{}", family.symbol, law.exponent,
                     law.low, law.high, growth_in_words(law, family.counts));
}

std::string table(const Family& family, const std::vector<Row>& rows) {
  Table table({family.symbol, "us/step", "median", "iterations", "max", "us/iteration", "failed", "operations",
               "distance m", "joint error m", "culled %", "no contact"});
  for (const Row& row : rows) {
    const physics::ProblemSize& size = row.summary.size;
    const double culled =
        static_cast<double>(size.culled_contacts) / static_cast<double>(std::max(1LL, size.contact_steps));
    table.add({fmt::to_string(row.size), number(row.per_step()), number(row.per_step_median()),
               fmt::format("{:.2f}", row.iterations()), fmt::to_string(row.summary.most_iterations),
               number(row.per_iteration()), fmt::to_string(row.failed()), fmt::to_string(size.operations),
               number(row.summary.distance.value, 2), number(row.summary.joint_error.value, 2),
               fmt::format("{:.1f}", 100 * culled), fmt::to_string(size.newton_steps)});
  }
  return table.text();
}

std::string differences(const Family& family, const Measured& m) {
  if (m.difference_low != m.difference_high)
    return fmt::format("Operations of one factorization without fill: one more of the {} costs {} to {}, NOT always the same.\n",
                       family.counts, m.difference_low, m.difference_high);
  return fmt::format(
      "Operations of one factorization without fill: one more of the {} costs exactly {}, for every {} from 2 to {}{}.\n",
      family.counts, m.difference_low, family.symbol, paper_to,
      m.difference_low == 0 ? ": a contact folds into its body and is never a node" : "");
}

/// On another machine: compared in units of each.
std::string against_published(const Family& family, const Measured& m, double unit_nanoseconds) {
  const Published& p = family.published.back();
  for (const Row& row : m.rows) {
    if (row.size != p.size || row.failed()) continue;
    const double ratio = 1e3 * p.milliseconds / published_unit_nanoseconds / (row.per_step() / unit_nanoseconds);
    return fmt::format(
        "The authors' Julia code on another machine of this kind: {:.0f} ms per step at {} = {}, {} of 100 "
        "steps not converged; {} times ours, each in its machine's unit.\nSource of that, which is not measured here: "
        "{}.\n",
        p.milliseconds, family.symbol, p.size, p.failed, number(ratio, 2), published_source);
  }
  return {};
}

Json to_json(const PowerLaw& law) {
  return {{"exponent", law.exponent}, {"low_95", law.low}, {"high_95", law.high},
          {"factor_us", law.factor},  {"from", fit_from},  {"points", law.points}};
}

Json to_json(const Row& row) {
  const physics::ProblemSize& size = row.summary.size;
  Json json{{"size", row.size},
            {"failed_steps", row.failed()},
            {"us_per_step", row.per_step()},
            {"us_per_step_median", row.per_step_median()},
            {"us_per_iteration", row.per_iteration()},
            {"iterations_mean", row.iterations()},
            {"iterations_max", row.summary.most_iterations},
            {"helped_steps", row.run.helped_steps},
            {"operations", size.operations},
            {"fill_blocks", size.fill_blocks},
            {"rows", size.rows},
            {"stored_scalars", size.stored_scalars},
            {"smallest_distance_m", row.summary.distance.value},
            {"largest_joint_error_m", row.summary.joint_error.value},
            {"run_seconds", row.seconds}};
  json["left_out"] = {{"culled_contact_steps", size.culled_contacts},
                      {"contact_steps", size.contact_steps},
                      {"steps_without_interior_point", size.newton_steps},
                      {"frictionless_contacts", size.frictionless_contacts},
                      {"merged_bodies", size.merged_bodies}};
  return json;
}

}  // namespace

std::string scaling_text(const Family& family, const Measured& m, double unit_nanoseconds) {
  std::string title = finding(family, m);
  std::replace(title.begin(), title.end(), '\n', ' ');
  const physics::ProblemSize& size = m.rows.back().summary.size;
  return fmt::format("{}, {} steps of {} s, friction {}, tolerance 1e-8 m/s\n{}{}.\n", family.name, step_count,
                     time_step, friction, table(family, m.rows), title) +
         fmt::format(
             "As a line: {} us + {} us for each of the {}, within {:.0f} %; time per step grows as {}^{:.2f}. "
             "Fits from {} on, best of {} runs or of 3 beyond {}.\n",
             number(m.iteration_line.fixed, 2), number(m.iteration_line.rate), family.counts,
             100 * m.iteration_line.deviation, family.symbol, m.step_law.exponent, fit_from,
             m.rows.front().seconds.size(), paper_to) +
         differences(family, m) +
         fmt::format(
             "Left out: contacts out of reach (keeping them makes {} = {} {:.2f} times as slow), the interior point "
             "in {} steps without contact, friction unknowns of {} contacts, {} merged bodies.\n",
             family.symbol, paper_to, m.ratio_all_kept, size.newton_steps, size.frictionless_contacts,
             size.merged_bodies) +
         against_published(family, m, unit_nanoseconds);
}

Json scaling_json(const Family& family, const Measured& m) {
  Json data{{"varied", family.counts},
            {"time_per_iteration", to_json(m.iteration_law)},
            {"time_per_step", to_json(m.step_law)}};
  data["time_per_iteration_as_line"] = {{"fixed_us", m.iteration_line.fixed},
                                        {"us_each", m.iteration_line.rate},
                                        {"largest_deviation", m.iteration_line.deviation}};
  data["operation_difference"] = {
      {"smallest", m.difference_low}, {"largest", m.difference_high}, {"from", 2}, {"to", paper_to}};
  data["time_ratio_with_all_contacts_kept"] = m.ratio_all_kept;
  for (const Row& row : m.rows) data["rows"].push_back(to_json(row));
  Json& theirs = data["authors_code"] = {{"source", published_source}, {"rows", Json::array()}};
  for (const Published& p : family.published)
    theirs["rows"].push_back({{"size", p.size},
                              {"us_per_step", 1e3 * p.milliseconds},
                              {"iterations_mean", p.iterations},
                              {"steps_not_converged", p.failed}});
  return data;
}

Picture scaling_picture(const Family& family, const Measured& m) {
  const PowerLaw& law = m.iteration_law;
  Series step{.label = "per step", .colour = 0, .mark = 0, .x = {}, .y = {}};
  Series iteration{.label = "per iteration", .colour = 2, .mark = 1, .x = {}, .y = {}};
  Series line{.label = fmt::format("{} us * {}^{:.2f}", number(law.factor, 2), family.symbol, law.exponent),
              .style = Series::Style::line,
              .colour = 6,
              .x = {},
              .y = {}};
  Series julia{.label = "authors' Julia code, per step", .colour = 1, .mark = 2, .x = {}, .y = {}};
  for (const Row& row : m.rows) {
    if (row.run.steps == 0) continue;
    step.x.push_back(row.size), step.y.push_back(row.per_step());
    iteration.x.push_back(row.size), iteration.y.push_back(row.per_iteration());
    if (row.size >= fit_from) line.x.push_back(row.size), line.y.push_back(law.at(row.size));
  }
  for (const Published& p : family.published) julia.x.push_back(p.size), julia.y.push_back(1e3 * p.milliseconds);
  return {.file = "scaling-" + family.name + ".svg",
          .title = finding(family, m),
          .x_label = fmt::format("{} {}", family.counts, family.symbol),
          .y_label = "CPU time [us]",
          .note = "Julia code: measured earlier by this project on another machine (numbers.md of its papers). ",
          .series = {step, iteration, line, julia}};
}

}  // namespace cli::study
