#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cli {

/// One sentence about options that could not be read: names the option, and what it takes.
std::string sentence_about(const CLI::App& program, const CLI::Error& error);

}  // namespace cli
