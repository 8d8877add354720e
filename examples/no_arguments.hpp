#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

/// For a program that takes none: a word too many is a slip, and must not pass for a run that was asked for. But asked
/// for help it says what it is, and ends.
inline void no_arguments(int count, char** words, const char* what_it_is) {
  if (count < 2) return;
  const std::string word = words[1], program = words[0];
  if (word != "--help" && word != "-h")
    throw std::invalid_argument("usage: the name alone, without '" + word + "'");
  std::printf("Usage: %s\n%s\n", program.substr(program.rfind('/') + 1).c_str(), what_it_is);
  std::exit(std::fflush(stdout) == 0 ? 0 : 2);
}
