#include "graphsolve/derivative_check.hpp"

#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>

#include "graphsolve/ordering.hpp"

namespace graphsolve {

namespace {

struct Batch {
  Term* term;
  std::vector<int> index, component;
};

}  // namespace

DerivativeReport check_terms(Problem& problem, std::span<const double> x, double step) {
  const BlockGraph& graph = problem.graph();
  if (x.size() != static_cast<std::size_t>(graph.rows()))
    throw std::invalid_argument("check_terms: a point of " + std::to_string(x.size()) + " numbers, the graph has " +
                                std::to_string(graph.rows()) + " rows");
  (void)problem.take_wiring();
  const Symbolic symbolic(graph, natural_ordering(graph));
  const Wiring wiring(symbolic, graph);
  std::vector<Batch> batches;
  for (Term* term : problem.terms()) {
    term->wire(wiring);
    Batch batch{term, std::vector<int>(term->size()), std::vector<int>(term->size(), 0)};
    std::iota(batch.index.begin(), batch.index.end(), 0);
    batches.push_back(std::move(batch));
  }
  const int n = graph.rows();
  std::vector<double> at(x.begin(), x.end()), plus(n), minus(n), values(symbolic.values_size(), 0.0);
  const auto evaluate = [&](std::vector<double>& residual, double* into) {
    std::fill(residual.begin(), residual.end(), 0.0);
    for (Batch& b : batches) b.term->evaluate({b.index, b.component}, at, residual, into);
  };
  evaluate(plus, values.data());
  std::vector<NodeId> node_of(n);
  for (int k = 0; k < graph.size(); ++k)
    for (int i = 0; i < graph.dimension({k}); ++i) node_of[graph.row({k}) + i] = {k};

  DerivativeReport report;
  for (int j = 0; j < n; ++j) {
    at[j] = x[j] + step;
    evaluate(plus, nullptr);
    at[j] = x[j] - step;
    evaluate(minus, nullptr);
    at[j] = x[j];
    const NodeId b = node_of[j];
    for (int i = 0; i < n; ++i) {
      const NodeId a = node_of[i];
      double given = 0;
      bool coupled = a == b;
      for (const auto& edge : graph.edges(a)) coupled = coupled || edge.to == b;
      if (coupled) {
        const BlockHandle handle = symbolic.block(a, b);
        given = values[handle.place(i - graph.row(a), j - graph.row(b))];
      }
      const double difference = (plus[i] - minus[i]) / (2 * step);
      const double error = std::abs(given - difference) / (1 + std::abs(difference));
      if (!report.worsened_by(error)) continue;
      report.largest_error = error;
      report.where = "row " + std::to_string(i - graph.row(a)) + " of '" + std::string(graph.name(a)) + "' by column " +
                     std::to_string(j - graph.row(b)) + " of '" + std::string(graph.name(b)) + "'";
    }
  }
  return report;
}

}  // namespace graphsolve
