#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "physics/run.hpp"
#include "physics/scene_io.hpp"
#include "progress.hpp"
#include "report.hpp"
#include "scene_source.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

struct Options {
  std::string scene;
  std::optional<int> steps, from;
  std::optional<double> duration, time_step;
  double tolerance = physics::SimulatorSettings{}.tolerance;
  std::string friction_model, out, summary;
};

constexpr const char* footer = R"(Examples:
  graphsolve simulate disc                                     a built-in scene, its summary
  graphsolve simulate snake:n=100 --steps 500 --out snake.json
  graphsolve simulate scene.toml --duration 2 --time-step 0.005 --out motion.csv
  graphsolve simulate snake.json --from 200 --steps 100 --out longer.json

A trajectory is a scene with its records; it can be simulated again, or continued with --from. A run that fails,
is interrupted (Ctrl-C) or fills the disk keeps what it has: the trajectory so far is written and valid.

Exit code: 0 all steps solved, 1 a step failed, 2 wrong input or a file that cannot be read or written,
129, 130 or 143 stopped by SIGHUP (a terminal that is closed), SIGINT or SIGTERM.)";

CLI::Validator friction_model() {
  const auto check = [](const std::string& text) {
    return text == "pyramid" || text == "aligned" ? std::string() : "must be pyramid or aligned, not " + text;
  };
  return {check, ""};
}

void add_options(CLI::App& command, Options& options) {
  command
      .add_option("SCENE", options.scene,
                  "A .json or .toml file, or a built-in scene with parameters, as 'graphsolve scenes' lists them")
      ->required()
      ->type_name("");
  constexpr int most = std::numeric_limits<int>::max();
  const char* length = "Length (default: a trajectory's recorded length, a built-in scene's own, else 1 s)";
  const char* physics = "Physics";
  const char* output = "Output";
  const auto add = [&](const char* group, const char* name, auto& value, const char* type, const char* help) {
    return command.add_option(name, value, help)->type_name(type)->group(group);
  };
  CLI::Option* steps = add(length, "--steps", options.steps, "N", "Number of steps")->check(whole_number(0, most));
  CLI::Option* duration = add(length, "--duration", options.duration, "S", "Simulated time [s], rounded up to whole steps")->check(positive());
  CLI::Option* from =
      add(length, "--from", options.from, "K", "Continue from record K of a trajectory")->check(whole_number(0, most));
  CLI::Option* time_step = add(physics, "--time-step", options.time_step, "DT", "Time step [s] (default: the scene's)");
  CLI::Option* model = add(physics, "--friction-model", options.friction_model, "MODEL",
                           "pyramid or aligned, for all contacts (default: each its own)");
  add(physics, "--tolerance", options.tolerance, "T", "Residual at which a step is accepted [m/s], at most |g| dt / 100")
      ->check(positive())
      ->capture_default_str();
  add(output, "--out", options.out, "FILE", "Trajectory: .json, or .csv for plots")->check(file_name());
  add(output, "--summary", options.summary, "FILE", "The summary as JSON")->check(file_name());
  steps->excludes(duration);
  // A trajectory is one motion of one scene.
  time_step->check(positive())->excludes(from);
  model->check(friction_model())->excludes(from);
  command.footer(footer);
}

void change(physics::Mechanism& scene, const Options& options) {
  if (options.time_step && *options.time_step != scene.time_step) {
    scene.time_step = *options.time_step;
    if (!scene.loads.empty())
      fmt::print(stderr, "graphsolve: note: loads are given in steps, so another time step changes when they act\n");
  }
  if (options.friction_model.empty()) return;
  for (physics::Contact& contact : scene.contacts)
    contact.friction_model =
        options.friction_model == "pyramid" ? physics::FrictionModel::pyramid : physics::FrictionModel::aligned;
}

int number_of_steps(const Options& options, const SceneSource& source) {
  if (options.steps) return *options.steps;
  const auto& records = source.trajectory.steps;
  const int first = options.from.value_or(0);
  const bool recorded = !options.duration && !records.empty() && records.back().step > first;
  if (recorded && !options.time_step) return records.back().step - first;
  const double dt = source.trajectory.mechanism.time_step;
  const double duration = recorded ? records.back().time : options.duration.value_or(source.duration);
  // A duration that is a multiple of the time step but for rounding is one.
  const double steps = std::ceil(duration / dt * (1 - 1e-9));
  if (!(steps <= std::numeric_limits<int>::max()))
    throw DescriptionError(fmt::format("a duration of {} s at a time step of {} s is {:.3g} steps, more than {}",
                                       duration, dt, steps,
                                       std::numeric_limits<int>::max()));
  return static_cast<int>(steps);
}

physics::Simulator make_simulator(const SceneSource& source, const Options& options) {
  physics::SimulatorSettings settings;
  settings.tolerance = options.tolerance;
  settings.time_phases = true;
  settings.count_turns = !options.out.empty();
  try {
    return physics::Simulator(source.trajectory.mechanism, settings);
  } catch (const DescriptionError& error) {
    // What the command line has changed stands in no line of the file.
    const bool changed = options.time_step && error.place() == "time_step";
    throw about_scene(options.scene, changed ? DescriptionError(error.what()) : error);
  }
}

/// The trajectory of a run. Where it cannot be written any further, such as on a full disk, the run ends, and what is
/// there is kept.
class Output {
 public:
  Output(const std::string& path, const physics::Mechanism& scene) : writer_(path, scene) {}
  void add(const physics::StepRecord& record) {
    if (!refused()) attempt([&] { writer_.add(record); });
  }
  void commit(const std::optional<physics::FailureRecord>& failure) {
    if (!refused()) attempt([&] { writer_.commit(failure); });
  }
  [[nodiscard]] bool refused() const { return !refusal_.empty(); }
  /// A sentence with what was kept.
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

 private:
  template <class F>
  void attempt(F&& write) {
    try {
      write();
    } catch (const DescriptionError& error) {
      refusal_ = error.what();
      keep();
    }
  }
  void keep() {
    try {
      const auto last = writer_.commit_what_is_there();
      refusal_ += last ? fmt::format("; the file ends with record {}, and --from {} continues from there", *last, *last)
                       : std::string("; nothing of it is kept");
    } catch (const DescriptionError&) {
      refusal_ += "; nothing of it is kept";
    }
  }

  physics::TrajectoryWriter writer_;
  std::string refusal_;
};

void restart(physics::Simulator& simulator, const physics::Trajectory& trajectory, const physics::StepRecord& from,
             const std::string& scene) {
  try {
    simulator.restart_from(from);
  } catch (const DescriptionError& error) {
    throw about_scene(scene, DescriptionError(error.what(), fmt::format("steps[{}]", &from - trajectory.steps.data())));
  }
}

/// Records before the one to continue from, and that one, are kept as they are.
void copy_records(const physics::Trajectory& trajectory, int last, Output& writer) {
  for (const physics::StepRecord& record : trajectory.steps)
    if (record.step <= last) writer.add(record);
}

int finish(const Options& options, const physics::Simulator& simulator, const physics::StepRecord& start,
           const physics::RunResult& result, int steps) {
  Report report{options.scene, steps, options.tolerance, interrupt(), simulator.mechanism(), result, start, {}};
  simulator.write_record(report.end);
  std::string text = for_people(report);
  if (!options.out.empty()) text += fmt::format("{:<22} {}\n", "trajectory", options.out);
  write_and_print({{options.summary, options.summary.empty() ? "" : as_json(report)}}, text);
  if (const auto& failure = result.failure) {
    fmt::print(stderr, "graphsolve: {}: step {} (at {:.6g} s) failed, {} at {}: {}\n", options.scene, failure->step,
               simulator.time(), failure->status, one_line(failure->place), failure->cause);
    return step_failed;
  }
  if (interrupt() && result.stopped && result.summary.steps < steps) {
    fmt::print(stderr, "graphsolve: {}: stopped after step {} by signal {}\n", options.scene, simulator.step_index(),
               interrupt());
    return interrupted + interrupt();
  }
  return all_solved;
}

int simulate(Options options) {
  check_outputs({{"--out", options.out}, {"--summary", options.summary}},
                {is_scene_file(options.scene) ? options.scene : ""});
  SceneSource source = load_scene(options.scene);
  change(source.trajectory.mechanism, options);
  const physics::StepRecord* from =
      options.from ? &find_record(source.trajectory, *options.from, options.scene) : nullptr;
  const int steps = number_of_steps(options, source);
  physics::Simulator simulator = make_simulator(source, options);
  if (from) restart(simulator, source.trajectory, *from, options.scene);
  options.tolerance = tolerance_used(options.tolerance, simulator.mechanism());
  note_coarse_step(simulator.mechanism());
  physics::StepRecord start;
  simulator.write_record(start);

  std::optional<Output> writer;
  physics::RunOptions run_options;
  if (!options.out.empty()) {
    writer.emplace(options.out, simulator.mechanism());
    if (from) copy_records(source.trajectory, from->step, *writer);
    run_options.record = [&](const physics::StepRecord& record) {
      if (!from || record.step > from->step) writer->add(record);
    };
  }
  catch_interrupts();
  const physics::RunResult result = [&] {
    Progress progress(steps);
    const int first = simulator.step_index();
    run_options.on_step = [&](const physics::Simulator& now, const physics::StepResult&) {
      progress.update(now.step_index() - first);
      return interrupt() == 0 && !(writer && writer->refused());
    };
    return physics::run(simulator, steps, run_options);
  }();
  if (writer) writer->commit(result.failure);
  if (writer && writer->refused()) options.out.clear();  // said below
  const int code = finish(options, simulator, start, result, steps);
  if (!writer || !writer->refused()) return code;
  fmt::print(stderr, "graphsolve: {}\n", writer->refusal());
  return wrong_input;
}

}  // namespace

Command add_simulate(CLI::App& program) {
  CLI::App* command = program.add_subcommand("simulate", "Simulate a scene; print a summary, write the trajectory.");
  const auto options = std::make_shared<Options>();
  add_options(*command, *options);
  return [options] { return simulate(*options); };
}

}  // namespace cli
