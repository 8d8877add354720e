#pragma once

#include <CLI/App.hpp>
#include <exception>
#include <functional>
#include <new>

/// The subcommands: each adds itself to the program and returns what to do when it was chosen.
namespace cli {

/// What the program tells the shell. Interrupted runs add the signal: 130 for SIGINT, 143 for SIGTERM.
enum ExitCode : int { all_solved = 0, step_failed = 1, wrong_input = 2, interrupted = 128 };

/// What the program says of an exception that ends it.
inline const char* sentence_of(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) ? "not enough memory for this scene or matrix" : error.what();
}

using Command = std::function<int()>;

Command add_simulate(CLI::App& program);
Command add_rollout(CLI::App& program);
Command add_scenes(CLI::App& program);
Command add_study(CLI::App& program);
Command add_analyze(CLI::App& program);
Command add_solve(CLI::App& program);

}  // namespace cli
