#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "wrong_options.hpp"

namespace {

constexpr const char* footer = R"(Examples:
  graphsolve scenes                                the built-in scenes and their parameters
  graphsolve simulate snake:n=20 --out snake.json  simulate one, keep the trajectory
  graphsolve simulate scene.toml --duration 2      simulate a file
  graphsolve rollout snake:n=10 --copies 1000 --steps 100 --vary friction=0.2:0.8 --out many.jsonl
  graphsolve study scaling --out figures           cost over contacts and bodies: table, data, pictures
  graphsolve analyze A.mtx                         orderings of a sparse matrix side by side, its fill explained
  graphsolve solve A.mtx b.mtx --out x.mtx         solve a sparse system, with a residual report
  graphsolve simulate --help                       all options of a command

Exit code: 0 solved, 1 a step failed or a system was singular, 2 wrong input or a file that cannot be read or written,
129, 130 or 143 stopped by SIGHUP, SIGINT or SIGTERM.

Environment: GRAPHSOLVE_SIMD=plain|avx2|avx512 is the most that is used of the machine's vector instructions.)";

int fail(const std::string& sentence) {
  fmt::print(stderr, "graphsolve: {}\n", sentence);
  return cli::wrong_input;
}

/// CLI11 would only say that a command is missing.
bool is_unknown_command(const std::vector<CLI::App*>& names, const std::string& word) {
  return !word.starts_with('-') &&
         std::none_of(names.begin(), names.end(), [&](const CLI::App* name) { return name->get_name() == word; });
}

int run(const cli::Command& command) {
  try {
    return command();
  } catch (const std::exception& error) {  // wrong input, but also from the file system, or a list longer than can be
    return fail(cli::sentence_of(error));
  }
}

/// What is printed waits in a buffer until the end; a full disk shows only then.
int printed(int code) {
  if (code == cli::wrong_input) return code;  // said already
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::cout && !std::ferror(stdout)) return code;
  return fail("cannot write to the standard output");
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file as large as the shell allows is an error of that write
  CLI::App program("Exact contact dynamics of rigid bodies in maximal coordinates, and the sparse block solver under it.", "graphsolve");
  program.set_version_flag("--version", "graphsolve " GRAPHSOLVE_VERSION);
  program.require_subcommand(1);
  program.footer(footer);
  program.failure_message([](const CLI::App* app, const CLI::Error& error) {
    const auto begun = app->get_subcommands();
    return fmt::format("graphsolve: {} (see 'graphsolve {}--help')\n", cli::sentence_about(*app, error),
                       begun.empty() ? "" : begun.front()->get_name() + " ");
  });
  std::vector<cli::Command> commands{cli::add_simulate(program), cli::add_rollout(program), cli::add_scenes(program),
                                     cli::add_study(program),    cli::add_analyze(program), cli::add_solve(program)};
  const std::vector<CLI::App*> names = program.get_subcommands([](const CLI::App*) { return true; });
  if (argc > 1 && is_unknown_command(names, argv[1])) {
    std::vector<std::string> known;
    for (const CLI::App* name : names) known.push_back(name->get_name());
    return fail(fmt::format("there is no command '{}'; there are: {}", argv[1], fmt::join(known, ", ")));
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version are errors to the library, of code 0.
    return program.exit(error) == 0 ? printed(cli::all_solved) : cli::wrong_input;
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i]->parsed()) return printed(run(commands[i]));
  return cli::wrong_input;
}
