#pragma once

#include <stdexcept>
#include <string>

/// For a program that takes none: a word too many is a slip, and must not pass for a run that was asked for.
inline void no_arguments(int count, char** words) {
  if (count > 1) throw std::invalid_argument("usage: the name alone, without '" + std::string(words[1]) + "'");
}
