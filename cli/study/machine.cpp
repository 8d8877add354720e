#include "study/machine.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <Eigen/Core>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "graphsolve_commit.hpp"

namespace cli::study {

namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

std::string system() {
  utsname name{};
  return uname(&name) == 0 ? fmt::format("{} {} {}", name.sysname, name.release, name.machine) : "unknown";
}

}  // namespace

nlohmann::ordered_json machine(double unit_nanoseconds) {
  double load = 0;
  static_cast<void>(getloadavg(&load, 1));
  return {{"program", "graphsolve " GRAPHSOLVE_VERSION},
          {"commit", GRAPHSOLVE_COMMIT},
          {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))},
          {"processor", processor()},
          {"processors", std::thread::hardware_concurrency()},
          {"load_average", load},
          {"system", system()},
          {"compiler", GRAPHSOLVE_COMPILER},
          {"flags", GRAPHSOLVE_FLAGS},
          {"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"threads", 1},
          {"clock", "CPU time of the thread"},
          {"unit", "one Eigen::LDLT of a 6x6 matrix plus one solve, fixed size, over 256 matrices, median of 9"},
          {"unit_ns", unit_nanoseconds}};
}

std::string machine_for_people(const nlohmann::ordered_json& m) {
  const auto text = [&](const char* key) { return m[key].get<std::string>(); };
  return fmt::format(
      "unit {:.0f} ns (6x6 LDLT and solve); CPU time of one thread; {} x {}, load {:.1f}\n{}, {}, {}, {}\n",
      m["unit_ns"].get<double>(), m["processors"].get<int>(), text("processor"), m["load_average"].get<double>(),
      text("program"), text("commit"), text("compiler"), text("flags"));
}

}  // namespace cli::study
