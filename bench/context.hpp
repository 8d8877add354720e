#pragma once

#include <benchmark/benchmark.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "commit.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "unit.hpp"

/// What a figure depends on besides the code that is timed; goes into the JSON of every benchmark.
namespace bench {

inline std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

/// Measures the unit, prints it on standard error (standard output may be JSON), and adds all that belongs to the figures.
/// Returns the unit [s]; after Initialize.
inline double set_up() {
  const double unit = timing::measure_unit();
  std::fprintf(stderr, "unit: %.0f ns (the bars are for 149 ns: here they are %.2f times as long)\n", unit * 1e9,
               unit / timing::reference_unit);
  std::fprintf(stderr, "a warning about a DEBUG library below is about Debian's Google Benchmark; ours is built with %s\n",
               GRAPHSOLVE_FLAGS);
  benchmark::AddCustomContext("unit_ns", std::to_string(1e9 * unit));
  benchmark::AddCustomContext("cpu", processor());
  benchmark::AddCustomContext("instruction_set", std::string(name(graphsolve::simd::instruction_set())));
  benchmark::AddCustomContext("commit", GRAPHSOLVE_COMMIT);
  benchmark::AddCustomContext("compiler", GRAPHSOLVE_COMPILER);
  benchmark::AddCustomContext("flags", GRAPHSOLVE_FLAGS);
  return unit;
}

}  // namespace bench
