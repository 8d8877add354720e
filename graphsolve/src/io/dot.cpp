#include "graphsolve/io/draw.hpp"
#include "io/shown.hpp"

namespace graphsolve::io {

namespace {

std::string dot_string(std::string_view name) {
  std::string text = "\"";
  for (const char c : shown(name)) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

std::string node_line(const BlockGraph& graph, NodeId node) {
  const std::string label = dot_string(std::string(graph.name(node)) + " (" + std::to_string(graph.dimension(node)) + ")");
  const char* shape = graph.kind(node) == NodeKind::saddle         ? "shape=box, style=filled, fillcolor=\"#f3dcc6\""
                      : graph.kind(node) == NodeKind::semidefinite ? "style=dashed"
                      : graph.kind(node) == NodeKind::shared       ? "shape=doublecircle, style=filled, fillcolor=\"#d5e3f0\""
                                                                   : "style=filled, fillcolor=\"#d5e3f0\"";
  return "  n" + std::to_string(node.index) + " [label=" + label + ", " + shape + "];\n";
}

constexpr const char* node_style = "  node [fontname=\"sans-serif\", fontsize=11];\n";

}  // namespace

std::string graph_dot(const BlockGraph& graph) {
  std::string text = std::string("graph blocks {\n  layout=neato; overlap=false; splines=true;\n") + node_style;
  for (int v = 0; v < graph.size(); ++v) text += node_line(graph, {v});
  for (int v = 0; v < graph.size(); ++v) {
    for (const auto& edge : graph.edges({v})) {
      if (edge.to.index < v) continue;
      text += "  n" + std::to_string(v) + " -- n" + std::to_string(edge.to.index);
      text += edge.rank == EdgeRank::unknown ? ";\n" : " [style=bold];\n";
    }
  }
  return text + "}\n";
}

std::string tree_dot(const BlockGraph& graph, const Symbolic& symbolic) {
  std::string text = std::string("digraph elimination {\n  rankdir=BT;\n") + node_style;
  for (int k = 0; k < symbolic.pivots(); ++k) text += node_line(graph, symbolic.node(k));
  for (int k = 0; k < symbolic.pivots(); ++k)
    if (symbolic.parent(k) >= 0)
      text += "  n" + std::to_string(symbolic.node(k).index) + " -> n" +
              std::to_string(symbolic.node(symbolic.parent(k)).index) + ";\n";
  return text + "}\n";
}

}  // namespace graphsolve::io
