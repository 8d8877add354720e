#include "support/campaign.hpp"

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "interrupt.hpp"
#include "options.hpp"
#include "wrong_options.hpp"

/// Runs the campaign of extremes and lists every step that failed. Exit code 0: none failed and the certificate
/// refuted none; 1: some did; 2: wrong input.
///   campaign --steps 100000 --seed 1 --json campaign.json
namespace {

nlohmann::json to_json(const campaign::Report& report) {
  nlohmann::json out;
  const auto add = [](const campaign::Count& c) {
    return nlohmann::json{{"family", c.family},           {"scenes", c.scenes},
                          {"steps", c.steps},             {"failures", c.failures},
                          {"substepped", c.substepped},   {"restarted", c.restarted},
                          {"turned", c.turned},           {"culling_repeats", c.culling_repeats},
                          {"iterations", c.iterations},   {"most_iterations", c.most_iterations},
                          {"distance", c.distance},       {"joint_error", c.joint_error},
                          {"certificate", c.certificate}, {"certified", c.certified},
                          {"refuted", c.refuted},         {"seconds", c.seconds}};
  };
  for (const auto& count : report.counts) out["families"].push_back(add(count));
  out["all"] = add(report.total());
  const auto list = [](const std::vector<campaign::Incident>& incidents) {
    nlohmann::json items = nlohmann::json::array();
    for (const auto& i : incidents)
      items.push_back({{"family", i.family}, {"scene", i.scene}, {"step", i.step}, {"status", i.status}, {"value", i.value}});
    return items;
  };
  out["failures"] = list(report.failures);
  out["refutations"] = list(report.refutations);
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Scenes with one thing far out of the ordinary: what fails, and what it took."};
  campaign::Options options;
  std::string json;
  constexpr int most = std::numeric_limits<int>::max();
  app.add_option("--steps", options.steps, "time steps in all")->check(cli::whole_number(1, most))->capture_default_str();
  app.add_option("--steps-of-scene", options.steps_of_scene, "at most, of one scene")
      ->check(cli::whole_number(1, most))
      ->capture_default_str();
  app.add_option("--first-scene", options.first_scene, "of each family, to look at one again")
      ->check(cli::whole_number(0, most))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of the scenes")->check(cli::seed())->capture_default_str();
  app.add_option("--tolerance", options.settings.tolerance, "[m/s]")->check(cli::positive())->capture_default_str();
  app.add_option("--family", options.families, "only these");
  app.add_flag("!--no-certify", options.certify, "do not judge every step by the certificate")->disable_flag_override();
  app.add_option("--json", json, "also write the figures to this file")->check(cli::file_name());
  const auto wrong = [](const std::string& what) {
    std::cerr << "campaign: " << what << '\n';
    return 2;
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return wrong(cli::sentence_about(app, error) + " (see 'campaign --help')");
  }
  try {
    std::ofstream file;
    if (!json.empty()) file.open(json);
    if (!file) return wrong("cannot write '" + json + "'");
    cli::catch_interrupts();
    options.stop = [] { return cli::interrupt() != 0; };
    const campaign::Report report = campaign::run(options);
    std::cout << report;
    if (!json.empty() && !(file << to_json(report).dump(1) << '\n').flush()) return wrong("cannot write '" + json + "'");
    if (cli::interrupt()) {
      const campaign::Count& last = report.counts.back();
      std::cerr << "campaign: stopped by signal " << cli::interrupt() << "; what is left of this family: --family "
                << last.family << " --first-scene " << options.first_scene + last.scenes << '\n';
      return 128 + cli::interrupt();
    }
    return report.failures.empty() && report.refutations.empty() ? 0 : 1;
  } catch (const std::exception& error) {
    return wrong(error.what());
  }
}
