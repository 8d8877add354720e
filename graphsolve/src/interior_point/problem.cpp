#include "graphsolve/problem.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <cmath>
#include <stdexcept>
#include <string>

namespace graphsolve {

Problem::Problem(BlockGraph graph) : graph_(std::move(graph)) {}

void Problem::check_node(NodeId node, const char* what) const {
  if (node.index < 0 || node.index >= graph_.size())
    throw std::invalid_argument(std::string(what) + " node " + std::to_string(node.index) + ", but the graph has " +
                                std::to_string(graph_.size()));
}

void Problem::couple(std::span<const NodeId> nodes, Coupling coupling) {
  if (nodes.empty()) throw std::invalid_argument("a term or port without nodes");
  for (const NodeId node : nodes) check_node(node, "a term or port at");
  const std::size_t centres = coupling == Coupling::star ? std::min<std::size_t>(1, nodes.size()) : nodes.size();
  for (std::size_t i = 0; i < centres; ++i)
    for (std::size_t j = i + 1; j < nodes.size(); ++j) graph_.add_edge(nodes[i], nodes[j]);
}

void Problem::add(Term& term) {
  for (int i = 0; i < term.size(); ++i) couple(term.nodes(i), term.coupling());
  terms_.push_back(&term);
}

int Problem::add(PortBatch& ports) {
  for (int i = 0; i < ports.size(); ++i) couple(ports.nodes(i), Coupling::all_pairs);
  ports_.push_back(&ports);
  return static_cast<int>(ports_.size()) - 1;
}

std::int64_t Problem::take_wiring() {
  static std::atomic<std::int64_t> last{0};
  const std::int64_t number = ++last;
  for (Term* term : terms_) term->wiring_ = number;
  for (PortBatch* ports : ports_) ports->wiring_ = number;
  return number;
}

bool Problem::wired(std::int64_t number) const {
  const auto is = [number](const Wired* wired) { return wired->wiring_ == number; };
  return std::ranges::all_of(terms_, is) && std::ranges::all_of(ports_, is);
}

void Problem::check_row_scale(NodeId node, std::span<const double> scale) const {
  check_node(node, "row scales of");
  if (static_cast<int>(scale.size()) != graph_.dimension(node))
    throw std::invalid_argument("node '" + std::string(graph_.name(node)) + "': " + std::to_string(scale.size()) +
                                " row scales for " + std::to_string(graph_.dimension(node)) + " rows");
  for (const double s : scale)
    if (!(s > 0 && std::isfinite(s)))
      throw std::invalid_argument("node '" + std::string(graph_.name(node)) + "': row scale " + std::to_string(s) +
                                  " is not a number > 0");
}

void Problem::set_row_scale(NodeId node, std::span<const double> scale) {
  check_row_scale(node, scale);
  if (row_scale_.empty()) row_scale_.assign(graph_.rows(), std::numeric_limits<double>::quiet_NaN());
  std::copy(scale.begin(), scale.end(), row_scale_.begin() + graph_.row(node));
}

}  // namespace graphsolve
