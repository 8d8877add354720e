#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "study/plot.hpp"

/// The studies: measurements of the simulator that say one thing each.
namespace cli::study {

using Json = nlohmann::ordered_json;

enum class Extent { quick, full };

struct Conditions {
  Extent extent = Extent::full;
  double unit_nanoseconds = 0;  ///< of measure.hpp, for figures from another machine
};

/// What a study found. Tables and sentences for people, data for programs, pictures for both.
struct Outcome {
  std::string text;
  Json data;
  std::vector<Picture> pictures;
  int failed_steps = 0;  ///< of all steps that were tried; they stay in the tables
};

/// Called between measurements. What it throws ends the study.
using OnProgress = std::function<void(int done, int of)>;

/// The paper's Figs. 4 and 5: cost of a step over the number of contacts and of bodies.
Outcome scaling(const Conditions& conditions, const OnProgress& progress);

/// Error against CPU time: a 5-link pendulum and a sliding block over time step, tolerance, start, friction model.
Outcome precision(const Conditions& conditions, const OnProgress& progress);

}  // namespace cli::study
