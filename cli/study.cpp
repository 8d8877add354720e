#include "study/study.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "physics/scene_io.hpp"
#include "progress.hpp"
#include "study/machine.hpp"
#include "unit.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

struct Study {
  std::string name;
  study::Outcome (*run)(const study::Conditions&, const study::OnProgress&);
};
const std::array studies{Study{"scaling", study::scaling}, Study{"precision", study::precision}};

struct Options {
  std::vector<std::string> names;
  bool quick = false;
  std::string out = "study-out";
};

constexpr const char* footer = R"(Studies:
  scaling    the paper's Figs. 4 and 5: cost of a step over the number of contacts and of bodies
  precision  error against CPU time over time step, tolerance, start and friction model

Each prints its tables and findings, and writes NAME.json (all data, with machine, compiler and commit) and pictures
NAME-*.svg, drawn by gnuplot, whose titles are the findings. A study that is interrupted (Ctrl-C) writes nothing, since
half a measurement is none; those finished before stay, and the command that makes the others is printed.

Exit code: 0 all steps solved, 1 some step failed (it stays in the tables), 2 wrong input or a file that cannot be
written, 129, 130 or 143 stopped by SIGHUP, SIGINT or SIGTERM.)";

/// Thrown out of a study that is to end.
struct Interrupted {};

const Study& find_study(const std::string& name) {
  const auto found = std::find_if(studies.begin(), studies.end(), [&](const Study& s) { return s.name == name; });
  if (found != studies.end()) return *found;
  std::string known;
  for (const Study& study : studies) known += (known.empty() ? "" : ", ") + study.name;
  throw DescriptionError(fmt::format("there is no study '{}'; there are: {}", name, known));
}

std::string join(const std::string& folder, const std::string& file) {
  return (std::filesystem::path(folder) / file).string();
}

/// Everything is asked before anything is measured.
std::vector<Study> prepare(const Options& options) {
  std::vector<Study> chosen;
  for (const std::string& name : options.names) chosen.push_back(find_study(name));
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw DescriptionError(fmt::format("cannot make the folder '{}': {}", options.out, error.message()));
  for (const Study& study : chosen) physics::check_writable(join(options.out, study.name + ".json"));
  return chosen;
}

void draw(const study::Outcome& outcome, const std::string& folder, std::string& files) {
  if (!study::have_gnuplot()) {
    fmt::print(stderr, "graphsolve: no pictures: the program gnuplot is not installed (package gnuplot-nox)\n");
    return;
  }
  for (const study::Picture& picture : outcome.pictures) {
    if (study::draw(picture, folder)) files += " " + join(folder, picture.file);
    else fmt::print(stderr, "graphsolve: gnuplot could not draw {}\n", join(folder, picture.file));
  }
}

/// Returns how many steps failed.
int run_study(const Study& study, const Options& options) {
  const study::Conditions conditions{.extent = options.quick ? study::Extent::quick : study::Extent::full,
                                     .unit_nanoseconds = 1e9 * timing::measure_unit()};
  const study::Json machine = study::machine(conditions.unit_nanoseconds);
  fmt::print("== {}{}\n{}", study.name, options.quick ? ", quick" : "", study::machine_for_people(machine));
  std::fflush(stdout);
  study::Outcome outcome = [&] {
    std::optional<Progress> progress;
    return study.run(conditions, [&](int done, int of) {
      if (interrupt()) throw Interrupted();
      if (!progress) progress.emplace(of);
      progress->update(done);
    });
  }();
  for (study::Picture& picture : outcome.pictures)
    picture.note += fmt::format("{}, {}; {}", machine["program"].get<std::string>(),
                                machine["commit"].get<std::string>(), machine["processor"].get<std::string>());
  study::Json data{{"format", "graphsolve-study"},
                   {"version", 1},
                   {"study", study.name},
                   {"quick", options.quick},
                   {"machine", machine}};
  data.update(outcome.data);
  std::string files = join(options.out, study.name + ".json");
  physics::write_text_file(data.dump(1) + "\n", files);
  draw(outcome, options.out, files);
  fmt::print("\n{}\nwritten: {}\n\n", outcome.text, files);
  return outcome.failed_steps;
}

/// From the first study that is not finished on.
int stopped(const std::vector<Study>& chosen, std::size_t finished, const Options& options) {
  std::string left;
  for (; finished < chosen.size(); ++finished) left += " " + chosen[finished].name;
  fmt::print(stderr, "graphsolve: study: stopped by signal {}; what is left: graphsolve study{}{} --out '{}'\n",
             interrupt(), left, options.quick ? " --quick" : "", options.out);
  return interrupted + interrupt();
}

int run_studies(const Options& options) {
  const std::vector<Study> chosen = prepare(options);
  catch_interrupts();
  int failed = 0;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    try {
      failed += run_study(chosen[k], options);
    } catch (const Interrupted&) {
    }
    if (interrupt()) return stopped(chosen, k, options);  // also where it came while gnuplot drew
  }
  if (failed == 0) return all_solved;
  fmt::print(stderr, "graphsolve: {} steps failed; they stay in the tables\n", failed);
  return step_failed;
}

}  // namespace

Command add_study(CLI::App& program) {
  CLI::App* command = program.add_subcommand("study", "Measure: cost over size, error over time spent.");
  const auto options = std::make_shared<Options>();
  command->add_option("NAME", options->names, "One or more of: scaling, precision")->required()->type_name("");
  command->add_flag("--quick", options->quick, "Fewer sizes and repeats: under two minutes for both")->disable_flag_override();
  command->add_option("--out", options->out, "Folder for data and pictures; made when it does not exist")
      ->type_name("DIR")
      ->check(file_name())
      ->capture_default_str();
  command->footer(footer);
  return [options] { return run_studies(*options); };
}

}  // namespace cli
