#pragma once

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <exception>
#include <functional>
#include <new>
#include <string>
#include <string_view>

/// The subcommands: each adds itself to the program and returns what to do when it was chosen.
namespace cli {

/// What the program tells the shell. Interrupted runs add the signal: 129 for SIGHUP, 130 for SIGINT, 143 for SIGTERM.
enum ExitCode : int { all_solved = 0, step_failed = 1, wrong_input = 2, interrupted = 128 };

/// In one line: names and texts of files may hold line feeds, and what a terminal would obey.
inline std::string one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n') line += "\\n";
    else if (byte < 0x20 || byte == 0x7f) line += fmt::format("\\x{:02x}", byte);
    else line += c;
  }
  return line;
}

/// What the program says of an exception that ends it.
inline std::string sentence_of(const std::exception& error) {
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error);
  return memory ? "not enough memory for this scene or matrix" : one_line(error.what());
}

using Command = std::function<int()>;

Command add_simulate(CLI::App& program);
Command add_rollout(CLI::App& program);
Command add_scenes(CLI::App& program);
Command add_study(CLI::App& program);
Command add_analyze(CLI::App& program);
Command add_solve(CLI::App& program);

}  // namespace cli
