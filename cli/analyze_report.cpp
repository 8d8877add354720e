#include "analyze_report.hpp"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "study/table.hpp"

namespace cli {

using namespace graphsolve;
using study::number;

namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Scalars that fill adds to the matrix, both triangles.
std::int64_t fill_scalars(const Symbolic& symbolic) {
  return symbolic.counts().stored_scalars - symbolic.counts().matrix_scalars;
}

std::string bytes(std::int64_t n) {
  const double value = static_cast<double>(n);
  if (value < 1e6) return fmt::format("{} kB", number(value / 1e3));
  return value < 1e9 ? fmt::format("{} MB", number(value / 1e6)) : fmt::format("{} GB", number(value / 1e9));
}

}  // namespace

void AnalyzeReport::add(OrderingMethod method) {
  Row row{method, {}, nullptr};
  const double start = cpu_seconds();
  row.ordering = make_ordering(graph, method);
  const double middle = cpu_seconds();
  row.symbolic = std::make_shared<const Symbolic>(graph, row.ordering);
  row.ordering_seconds = middle - start;
  row.symbolic_seconds = cpu_seconds() - middle;
  rows.push_back(std::move(row));
}

const AnalyzeReport::Row& AnalyzeReport::best() const {
  return *std::ranges::min_element(
      rows, {}, [](const Row& row) { return row.symbolic->counts().operations; });
}

void AnalyzeReport::explain() {
  const Row& row = best();
  const auto& counts = row.symbolic->counts();
  if (counts.fill_blocks == 0)
    findings.push_back(fmt::format("{}: no fill, cost grows linearly with the number of blocks of this shape",
                                   name(row.method)));
  else
    findings.push_back(fmt::format("{}: {} fill blocks, the factor is {} times the matrix", name(row.method),
                                   counts.fill_blocks, number(io::fill_ratio(*row.symbolic), 4)));
}

std::string for_people(const AnalyzeReport& report) {
  std::string text = fmt::format("{}: {}\n\n", report.source, report.description);
  study::Table table({"ordering", "fill blocks", "fill scalars", "fill ratio", "operations", "tree height",
                      "largest front", "memory", "repairs", "forced", "ordering ms", "symbolic ms"});
  for (const auto& row : report.rows) {
    const auto& c = row.symbolic->counts();
    table.add({std::string(name(row.method)), fmt::format("{}", c.fill_blocks), fmt::format("{}", fill_scalars(*row.symbolic)),
               fmt::format("{:.2f}", io::fill_ratio(*row.symbolic)), number(static_cast<double>(c.operations), 4),
               fmt::format("{}", c.tree_height), fmt::format("{}", c.largest_front), bytes(c.memory),
               fmt::format("{}", row.ordering.repairs), fmt::format("{}", row.ordering.forced),
               number(1e3 * row.ordering_seconds), number(1e3 * row.symbolic_seconds)});
  }
  text += table.text() + "\n";
  for (const std::string& finding : report.findings) text += finding + "\n";
  return text;
}

std::string as_json(const AnalyzeReport& report) {
  using Json = nlohmann::ordered_json;
  Json orderings = Json::array();
  for (const auto& row : report.rows) {
    const auto& c = row.symbolic->counts();
    orderings.push_back({{"ordering", name(row.method)},
                         {"fill_blocks", c.fill_blocks},
                         {"fill_scalars", fill_scalars(*row.symbolic)},
                         {"fill_ratio", io::fill_ratio(*row.symbolic)},
                         {"operations", c.operations},
                         {"symmetric_operations", c.symmetric_operations},
                         {"solve_operations", c.solve_operations},
                         {"stored_scalars", c.stored_scalars},
                         {"matrix_scalars", c.matrix_scalars},
                         {"tree_height", c.tree_height},
                         {"largest_front_rows", c.largest_front},
                         {"memory_bytes", c.memory},
                         {"repairs", row.ordering.repairs},
                         {"forced", row.ordering.forced},
                         {"ordering_cpu_s", row.ordering_seconds},
                         {"symbolic_cpu_s", row.symbolic_seconds}});
  }
  int saddle = 0, semidefinite = 0;
  for (int v = 0; v < report.graph.size(); ++v) {
    saddle += report.graph.kind({v}) == NodeKind::saddle;
    semidefinite += report.graph.kind({v}) == NodeKind::semidefinite;
  }
  const Json json{{"format", "graphsolve-analysis"},
                  {"version", 1},
                  {"program", "graphsolve " GRAPHSOLVE_VERSION},
                  {"source", report.source},
                  {"rows", report.graph.rows()},
                  {"blocks", report.graph.size()},
                  {"saddle_blocks", saddle},
                  {"semidefinite_blocks", semidefinite},
                  {"zeros_added_for_symmetry", report.added_entries},
                  {"orderings", orderings},
                  {"best", name(report.best().method)},
                  {"findings", report.findings}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string as_svg(const AnalyzeReport& report) {
  const auto& row = report.best();
  io::SpyOptions options;
  options.subtitle = fmt::format("{}, ordering {}: {} blocks, {} rows", report.source, name(row.method), report.graph.size(),
                                 report.graph.rows());
  options.causes = report.causes;
  return io::spy_svg(report.graph, *row.symbolic, options);
}

}  // namespace cli
