#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "physics/run.hpp"
#include "study/fit.hpp"
#include "study/measure.hpp"
#include "study/study.hpp"

/// What is measured in the scaling study, and how it is told.
namespace cli::study {

inline constexpr int step_count = 100;
inline constexpr double time_step = 0.01, friction = 0.2;
inline constexpr int fit_from = 10;   ///< smaller ones show the cost of a step that no size changes
inline constexpr int paper_to = 100;  ///< the paper's largest size

/// Of the authors' own code, at one size; measured once by this project, not by the study.
struct Published {
  int size;
  double milliseconds, iterations;  ///< per step
  int failed;                       ///< steps not converged, of 100
};

/// A scene that grows.
struct Family {
  std::string name, symbol, counts;
  physics::Mechanism (*make)(int size);
  std::array<Published, 6> published;
};

struct Row {
  int size = 0;
  std::vector<double> seconds;  ///< of every run
  Run run;                      ///< the same every time, but for its seconds
  physics::RunSummary summary;
  [[nodiscard]] double per_step() const { return 1e6 * spread(seconds).best / std::max(1, run.steps); }
  [[nodiscard]] double per_step_median() const { return 1e6 * spread(seconds).median / std::max(1, run.steps); }
  [[nodiscard]] double iterations() const { return static_cast<double>(run.iterations) / std::max(1, run.steps); }
  [[nodiscard]] double per_iteration() const {
    return 1e6 * spread(seconds).best / static_cast<double>(std::max(1LL, run.iterations));
  }
  [[nodiscard]] int failed() const { return step_count - run.steps; }
};

struct Measured {
  std::vector<Row> rows;
  PowerLaw iteration_law, step_law;  ///< of the times [us] from `fit_from` on; NaN with too few solved sizes
  Line iteration_line;               ///< [us]
  long long difference_low = 0, difference_high = 0;  ///< operations(n + 1) - operations(n), over the paper's sizes
  double ratio_all_kept = 0;  ///< time with all contacts kept, over the time with those out of reach left out
};

std::string scaling_text(const Family& family, const Measured& measured, double unit_nanoseconds);
Json scaling_json(const Family& family, const Measured& measured);
Picture scaling_picture(const Family& family, const Measured& measured);

}  // namespace cli::study
