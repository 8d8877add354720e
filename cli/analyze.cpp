#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "analyze_report.hpp"
#include "commands.hpp"
#include "graphsolve/io/draw.hpp"
#include "matrix_source.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "physics/simulator.hpp"
#include "scene_source.hpp"

namespace cli {

using namespace graphsolve;
using physics::DescriptionError;

namespace {

struct Options {
  std::string source, blocks, ordering = "all", json, svg, dot, write_blocks;
};

constexpr const char* footer = R"(Examples:
  graphsolve analyze A.mtx                          all orderings side by side; blocks are found in the pattern
  graphsolve analyze A.mtx --blocks map.json        with names, sizes and kinds of your own (docs/block_map.md)
  graphsolve analyze A.mtx --write-blocks map.json  the blocks that were found, to be edited and given to --blocks
  graphsolve analyze snake:n=20 --ordering wide     a scene: bodies and joints are the blocks
  graphsolve analyze A.mtx --svg fill.svg --dot graph.dot --json report.json

Nothing is factored: all figures are predictions that the factorization keeps. With all orderings, pictures and the
attribution of fill are those of the ordering of fewest operations; those that fill more than 3 million blocks are left
out. --dot also writes the elimination tree, beside the graph: graph.dot and graph-tree.dot. How to read all this:
docs/ordering_and_fill.md.

Exit code: 0 analyzed, 2 wrong input or a file that cannot be read or written.)";

std::vector<OrderingMethod> chosen_methods(const std::string& text) {
  if (text == "all") {
    std::vector<OrderingMethod> all;
    for (const OrderingMethod method : ordering_methods())
      if (method != OrderingMethod::best && available(method)) all.push_back(method);
    return all;
  }
  return {parse_method(text)};
}

/// The tree beside the graph: x.dot and x-tree.dot.
std::string tree_file(const std::string& path) {
  const bool dot = path.ends_with(".dot");
  return dot ? path.substr(0, path.size() - 4) + "-tree.dot" : path + "-tree.dot";
}

BlockGraph graph_of(const std::string& scene) {
  const physics::Mechanism mechanism = load_scene(scene).trajectory.mechanism;
  try {
    return physics::Simulator(mechanism).graph();
  } catch (const DescriptionError& error) {
    throw about_scene(scene, error);
  }
}

int analyze(const Options& options) {
  const std::vector<OrderingMethod> methods = chosen_methods(options.ordering);
  const std::string tree = options.dot.empty() ? "" : tree_file(options.dot);
  const bool from_file = options.source.ends_with(".mtx") || is_scene_file(options.source);
  check_outputs({{"--json", options.json}, {"--svg", options.svg}, {"--dot", options.dot}, {"the tree of --dot", tree},
                 {"--write-blocks", options.write_blocks}},
                {from_file ? options.source : "", options.blocks});
  AnalyzeReport report{.source = options.source};
  std::vector<FileText> files;
  if (options.source.ends_with(".mtx")) {
    const MatrixSource matrix = load_matrix(options.source, options.blocks);
    report.description = describe(matrix, options.blocks);
    report.graph = matrix.blocks.graph;
    report.added_entries = matrix.blocks.added_entries;
    if (!options.write_blocks.empty()) files.push_back({options.write_blocks, block_map_text(matrix)});
  } else {
    for (const auto& [option, file] : {std::pair("--blocks", options.blocks), std::pair("--write-blocks", options.write_blocks)})
      if (!file.empty())
        throw DescriptionError(fmt::format("{} needs a matrix (.mtx), and '{}' is a scene", option, options.source));
    report.graph = graph_of(options.source);
    report.description = fmt::format("a scene: {}, {} in all", count(report.graph.size(), "block", "blocks"),
                                     count(report.graph.rows(), "row", "rows"));
    if (report.graph.size() == 0) throw DescriptionError(fmt::format("{}: the scene has nothing that moves", options.source));
  }
  report.add_all(methods);
  if (report.rows.empty() && methods.size() > 1)
    throw DescriptionError(fmt::format("{}: every ordering fills more than {} blocks, which is too much to explain; merge "
                                       "rows into blocks (--blocks)",
                                       options.source, AnalyzeReport::most_fill_blocks));
  if (report.rows.empty())
    throw DescriptionError(fmt::format("{}: {}; take another ordering, or merge rows into blocks", options.source,
                                       report.left_out.front()));
  report.explain();
  if (!options.json.empty()) files.push_back({options.json, as_json(report)});
  if (!options.svg.empty()) files.push_back({options.svg, as_svg(report)});
  if (!options.dot.empty()) {
    files.push_back({options.dot, io::graph_dot(report.graph)});
    files.push_back({tree, io::tree_dot(report.graph, *report.best().symbolic)});
  }
  write_and_print(files, for_people(report));
  return all_solved;
}

}  // namespace

std::string ordering_names() {
  std::string names;
  for (const OrderingMethod m : ordering_methods()) names += fmt::format("{}{}", names.empty() ? "" : ", ", name(m));
  return names;
}

OrderingMethod parse_method(const std::string& text) {
  const auto method = parse_ordering_method(text);
  if (!method) throw DescriptionError(fmt::format("there is no ordering '{}'; there are: {}", text, ordering_names()));
  if (!available(*method))
    throw DescriptionError(fmt::format("the ordering '{}' needs a package that was missing when graphsolve was built", text));
  return *method;
}

Command add_analyze(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("analyze", "Compare orderings of a sparse matrix or a scene; explain its fill.");
  const auto options = std::make_shared<Options>();
  command->add_option("FILE.mtx|SCENE", options->source, "A Matrix Market file, a scene file, or a built-in scene")
      ->required()
      ->type_name("");
  command->add_option("--blocks", options->blocks, "Block map: JSON, or a list of sizes (default: found in the pattern)")
      ->type_name("MAP")
      ->check(file_name());
  command->add_option("--ordering", options->ordering, "all, or one of " + ordering_names())
      ->type_name("NAME")
      ->capture_default_str();
  const auto file = [&](const char* name, std::string& path, const char* help) {
    command->add_option(name, path, help)->type_name("FILE")->group("Output")->check(file_name());
  };
  file("--json", options->json, "All figures");
  file("--write-blocks", options->write_blocks, "The blocks of the matrix, a map for --blocks");
  file("--svg", options->svg, "Spy plot of the factor, fill coloured by cause");
  file("--dot", options->dot, "GraphViz: the graph, and the elimination tree beside it");
  command->footer(footer);
  return [options] { return analyze(*options); };
}

}  // namespace cli
