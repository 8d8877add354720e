#include "analyze_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "matrix_source.hpp"
#include "study/table.hpp"
#include "timing.hpp"

namespace cli {

using namespace graphsolve;
using study::number;

namespace {

/// Scalars that fill adds to the matrix, both triangles.
std::int64_t fill_scalars(const Symbolic& symbolic) {
  return symbolic.counts().stored_scalars - symbolic.counts().matrix_scalars;
}

std::int64_t edges_of(const BlockGraph& graph) {
  std::int64_t ends = 0;
  for (int v = 0; v < graph.size(); ++v) ends += static_cast<std::int64_t>(graph.edges({v}).size());
  return ends / 2;
}

/// Sloan's method renews what a block's neighbours are worth whenever one of them comes or goes; Boost's minimum degree
/// goes through the neighbours of a block as often.
bool takes_long(OrderingMethod method, const BlockGraph& graph) {
  const double most = method == OrderingMethod::sloan            ? 1e8   // about two seconds
                      : method == OrderingMethod::minimum_degree ? 1e9   // about one
                                                                 : INFINITY;
  double work = 0;
  for (int v = 0; v < graph.size(); ++v) {
    const auto degree = static_cast<double>(graph.edges({v}).size());
    work += degree * degree;
  }
  return work > most;
}

std::string bytes(std::int64_t n) {
  const double value = static_cast<double>(n);
  if (value < 1e6) return fmt::format("{} kB", number(value / 1e3));
  return value < 1e9 ? fmt::format("{} MB", number(value / 1e6)) : fmt::format("{} GB", number(value / 1e9));
}

}  // namespace

void AnalyzeReport::add_all(std::span<const OrderingMethod> methods) {
  for (const OrderingMethod method : methods) {
    if (methods.size() > 1 && takes_long(method, graph))
      left_out.push_back(fmt::format("{0}: left out, it takes long where blocks have many neighbours; --ordering {0} waits for it",
                                     name(method)));
    else
      add(method);
  }
}

void AnalyzeReport::add(OrderingMethod method) {
  Row row{method, {}, nullptr};
  const double start = timing::thread_time();
  row.ordering = make_ordering(graph, method);
  const double middle = timing::thread_time();
  const PredictedCost cost = predict_cost(graph, row.ordering, most_fill_blocks + edges_of(graph));
  if (cost.fill_blocks > most_fill_blocks) {
    left_out.push_back(fmt::format("{}: left out, it fills more than {} blocks", name(method), most_fill_blocks));
    return;
  }
  row.symbolic = std::make_shared<const Symbolic>(graph, row.ordering);
  row.ordering_seconds = middle - start;
  row.symbolic_seconds = timing::thread_time() - middle;
  rows.push_back(std::move(row));
}

const AnalyzeReport::Row& AnalyzeReport::best() const {
  return *std::ranges::min_element(
      rows, {}, [](const Row& row) { return row.symbolic->counts().operations; });
}

namespace {

/// "12 nodes in 3 cycles: 'a', 'b', 'c', ...".
std::string name_of_cause(const FillCause& cause, const BlockGraph& graph) {
  if (cause.cycles == 0) return "the order, no cycle";
  std::string text = fmt::format("{} of {}:", count(cause.cycles, "cycle", "cycles"), count(static_cast<long long>(cause.nodes.size()), "block", "blocks"));
  constexpr std::size_t most = 3;
  for (std::size_t k = 0; k < std::min(most, cause.nodes.size()); ++k)
    text += fmt::format("{} '{}'", k ? "," : "", graph.name(cause.nodes[k]));
  return cause.nodes.size() > most ? text + ", ..." : text;
}

/// "31 blocks in a front of 96 rows: 'a', 'b', 'c', ...".
std::string name_of_front(const FillFront& front, const BlockGraph& graph) {
  std::string text = fmt::format("{} in a front of {}:", count(static_cast<long long>(front.nodes.size()), "block", "blocks"),
                                 count(front.rows, "row", "rows"));
  constexpr std::size_t most = 3;
  for (std::size_t k = 0; k < std::min(most, front.nodes.size()); ++k)
    text += fmt::format("{} '{}'", k ? "," : "", graph.name(front.nodes[k]));
  return front.nodes.size() > most ? text + ", ..." : text;
}

double percent(std::int64_t part, std::int64_t whole) {
  return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

/// Where one cause has so much fill that its name tells little.
void AnalyzeReport::explain_fronts() {
  constexpr std::size_t most = 5;
  constexpr std::int64_t much_fill = 100;
  const auto& fronts = analysis->fronts;
  if (analysis->causes.front().price.blocks <= much_fill || fronts.size() < 2) return;
  const std::int64_t all = best().symbolic->counts().operations;
  findings.push_back("where that is paid, by blocks that are eliminated as one:");
  FillPrice rest = analysis->total;
  const auto line = [&](const FillPrice& price, const std::string& what) {
    findings.push_back(fmt::format("  {}, {} operations ({:.1f} % of all): {}", count(price.blocks, "fill block", "fill blocks"),
                                   price.operations, percent(price.operations, all), what));
  };
  for (std::size_t f = 0; f < std::min(most, fronts.size()); ++f) {
    line(fronts[f].price, name_of_front(fronts[f], graph));
    rest.blocks -= fronts[f].price.blocks;
    rest.operations -= fronts[f].price.operations;
  }
  if (fronts.size() > most) line(rest, count(static_cast<long long>(fronts.size() - most), "more front", "more fronts"));
}

void AnalyzeReport::explain() {
  findings = left_out;
  const Row& row = best();
  const auto& counts = row.symbolic->counts();
  const std::string_view ordering = name(row.method);
  if (counts.fill_blocks == 0) {
    findings.push_back(fmt::format("{}: no fill", ordering));
    return;
  }
  findings.push_back(fmt::format("{}: {}, the factor is {} times the matrix", ordering,
                                 count(counts.fill_blocks, "fill block", "fill blocks"), number(io::fill_ratio(*row.symbolic), 4)));
  if (!fill_analysis_available()) {
    findings.push_back("the fill is not attributed to cycles: Boost.Graph was missing when graphsolve was built");
    return;
  }
  analysis = analyze_fill(graph, *row.symbolic);
  for (const FillCause& cause : analysis->causes) causes.names.push_back(name_of_cause(cause, graph));
  for (const FillBlock& block : analysis->blocks) causes.of_fill.push_back(block.cause);
  constexpr std::size_t most = 8;
  const auto& found = analysis->causes;
  for (std::size_t c = 0; c < std::min(most, found.size()); ++c)
    findings.push_back(fmt::format("  {}, {} operations ({:.1f} % of all): {}",
                                   count(found[c].price.blocks, "fill block", "fill blocks"), found[c].price.operations,
                                   percent(found[c].price.operations, counts.operations), causes.names[c]));
  if (found.size() > most) findings.push_back(fmt::format("  and {} causes more", found.size() - most));
  explain_fronts();
  if (analysis->edge) {
    const EdgeSaving& edge = *analysis->edge;
    findings.push_back(fmt::format("without the edge '{}' - '{}': {} fewer, {} operations ({:.1f} %) saved{}", graph.name(edge.a),
                                   graph.name(edge.b), count(edge.blocks, "fill block", "fill blocks"), edge.operations,
                                   percent(edge.operations, counts.operations),
                                   edge.exact() ? "; no other edge saves more"
                                                : fmt::format("; the best of {} edges tried of {}", edge.tried, edge.edges)));
  }
}

std::string for_people(const AnalyzeReport& report) {
  std::string text = fmt::format("{}: {}\n\n", report.source, report.description);
  study::Table table({"ordering", "fill blocks", "fill scalars", "fill ratio", "operations", "tree height",
                      "largest front", "memory", "repairs", "forced", "ordering ms", "symbolic ms"});
  for (const auto& row : report.rows) {
    const auto& c = row.symbolic->counts();
    table.add({row.label(), fmt::format("{}", c.fill_blocks), fmt::format("{}", fill_scalars(*row.symbolic)),
               fmt::format("{:.2f}", io::fill_ratio(*row.symbolic)), number(static_cast<double>(c.operations), 4),
               fmt::format("{}", c.tree_height), fmt::format("{}", c.largest_front), bytes(c.memory),
               fmt::format("{}", row.ordering.repairs), fmt::format("{}", row.ordering.forced),
               number(1e3 * row.ordering_seconds), number(1e3 * row.symbolic_seconds)});
  }
  text += table.text() + "\n";
  for (const std::string& finding : report.findings) text += finding + "\n";
  return text;
}

using Json = nlohmann::ordered_json;

namespace {

Json to_json(const FillPrice& price) {
  return {{"fill_blocks", price.blocks}, {"fill_scalars", price.scalars}, {"operations", price.operations}};
}

void add_attribution(const AnalyzeReport& report, Json& json) {
  const BlockGraph& graph = report.graph;
  json["fill"] = to_json(report.analysis->total);
  json["fill"]["causes"] = Json::array();
  for (const FillCause& cause : report.analysis->causes) {
    Json item{{"cycles", cause.cycles}, {"edges", cause.edges}, {"blocks", Json::array()}};
    for (const NodeId node : cause.nodes) item["blocks"].push_back(graph.name(node));
    item.update(to_json(cause.price));
    json["fill"]["causes"].push_back(item);
  }
  json["fill"]["fronts"] = Json::array();
  for (const FillFront& front : report.analysis->fronts) {
    Json item{{"rows", front.rows}, {"blocks", Json::array()}};
    for (const NodeId node : front.nodes) item["blocks"].push_back(graph.name(node));
    item.update(to_json(front.price));
    json["fill"]["fronts"].push_back(item);
  }
  if (!report.analysis->edge) return;
  const EdgeSaving& edge = *report.analysis->edge;
  json["edge_to_cut"] = {{"from", graph.name(edge.a)},   {"to", graph.name(edge.b)},
                         {"fill_blocks", edge.blocks},   {"scalars", edge.scalars},
                         {"operations", edge.operations}, {"edges_tried", edge.tried},
                         {"edges_in_cycles", edge.edges}};
}

}  // namespace

std::string as_json(const AnalyzeReport& report) {
  Json orderings = Json::array();
  for (const auto& row : report.rows) {
    const auto& c = row.symbolic->counts();
    orderings.push_back({{"ordering", name(row.method)},
                         {"taken", name(row.ordering.method)},
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
  int saddle = 0, semidefinite = 0, shared = 0;
  for (int v = 0; v < report.graph.size(); ++v) {
    saddle += report.graph.kind({v}) == NodeKind::saddle;
    semidefinite += report.graph.kind({v}) == NodeKind::semidefinite;
    shared += report.graph.kind({v}) == NodeKind::shared;
  }
  Json json{{"format", "graphsolve-analysis"},
                  {"version", 1},
                  {"program", "graphsolve " GRAPHSOLVE_VERSION},
                  {"source", report.source},
                  {"rows", report.graph.rows()},
                  {"blocks", report.graph.size()},
                  {"saddle_blocks", saddle},
                  {"semidefinite_blocks", semidefinite},
                  {"shared_blocks", shared},
                  {"zeros_added_for_symmetry", report.added_entries},
                  {"orderings", orderings},
                  {"best", name(report.best().method)},
                  {"findings", report.findings}};
  if (report.analysis) add_attribution(report, json);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string as_svg(const AnalyzeReport& report) {
  const auto& row = report.best();
  io::SpyOptions options;
  options.subtitle = fmt::format("{}, ordering {}: {} blocks, {} rows", report.source, name(row.method), report.graph.size(),
                                 report.graph.rows());
  options.causes = report.causes;
  if (report.analysis && !report.analysis->causes.empty()) {
    const auto& total = report.analysis->total;
    const auto& first = report.analysis->causes.front();
    options.title = fmt::format("Fill of {} operations ({:.0f} % of all), {:.0f} % of it by {}", total.operations,
                                percent(total.operations, row.symbolic->counts().operations),
                                percent(first.price.operations, total.operations),
                                first.cycles == 0 ? "the order alone" : count(first.cycles, "cycle", "cycles"));
  }
  return io::spy_svg(report.graph, *row.symbolic, options);
}

}  // namespace cli
