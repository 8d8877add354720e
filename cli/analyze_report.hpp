#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "graphsolve/fill_analysis.hpp"
#include "graphsolve/io/draw.hpp"
#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"

/// What `analyze` found, for people and for programs.
namespace cli {

/// Of all there are, "natural, depth-first, ...".
std::string ordering_names();
/// Throws DescriptionError that lists them.
graphsolve::OrderingMethod parse_method(const std::string& text);

struct AnalyzeReport {
  struct Row {
    graphsolve::OrderingMethod method;
    graphsolve::Ordering ordering;
    std::shared_ptr<const graphsolve::Symbolic> symbolic;
    double ordering_seconds = 0, symbolic_seconds = 0;  ///< CPU time of this thread
    /// What was asked for, and what it took where it chooses.
    [[nodiscard]] std::string label() const {
      std::string text(graphsolve::name(method));
      if (ordering.method != method) text += " (" + std::string(graphsolve::name(ordering.method)) + ")";
      return text;
    }
  };

  static constexpr std::int64_t most_fill_blocks = 3'000'000;  ///< each takes a kilobyte, worked out and attributed

  std::string source;       ///< as named on the command line
  std::string description = {};  ///< one line
  graphsolve::BlockGraph graph = {};
  long long added_entries = 0;
  std::vector<Row> rows = {};
  std::vector<std::string> left_out = {};  ///< a sentence each

  /// Of several methods one that takes very long on this graph goes to `left_out`.
  void add_all(std::span<const graphsolve::OrderingMethod> methods);
  /// An ordering with more fill than memory is good for goes to `left_out` instead.
  void add(graphsolve::OrderingMethod method);
  /// Attributes the fill of the best ordering.
  void explain();
  void explain_fronts();
  /// The ordering of fewest operations.
  [[nodiscard]] const Row& best() const;

  std::optional<graphsolve::FillAnalysis> analysis = {};  ///< of the best ordering; none without fill or Boost.Graph
  graphsolve::io::FillCauses causes = {};
  std::vector<std::string> findings = {};  ///< sentences about the fill of the best ordering
};

std::string for_people(const AnalyzeReport& report);
std::string as_json(const AnalyzeReport& report);
std::string as_svg(const AnalyzeReport& report);

}  // namespace cli
