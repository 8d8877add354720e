#include "graphsolve/ordering_method.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "symbolic/elimination_tree.hpp"
#include "graphsolve/ordering.hpp"
#include "ordering/ordering_packages.hpp"
#include "ordering/ordering_held.hpp"
#include "ordering/ordering_repair.hpp"

namespace graphsolve {

namespace {

#ifdef GRAPHSOLVE_SUITESPARSE
constexpr bool has_suitesparse = true;
#else
constexpr bool has_suitesparse = false;
#endif
#ifdef GRAPHSOLVE_METIS
constexpr bool has_metis = true;
#else
constexpr bool has_metis = false;
#endif
#ifdef GRAPHSOLVE_BOOST
constexpr bool has_boost = true;
#else
constexpr bool has_boost = false;
#endif

struct Method {
  OrderingMethod method;
  std::string_view name;
  std::string_view package;  ///< that it needs
  bool available;
};

using enum OrderingMethod;
constexpr std::array<Method, 13> methods{{
    {natural, "natural", "", true},
    {depth_first, "depth-first", "", true},
    {minimum_fill, "minimum-fill", "", true},
    {amd, "amd", "SuiteSparse AMD", has_suitesparse},
    {camd, "camd", "SuiteSparse CAMD", has_suitesparse},
    {colamd, "colamd", "SuiteSparse COLAMD", has_suitesparse},
    {nested_dissection, "nested-dissection", "METIS", has_metis},
    {minimum_degree, "minimum-degree", "Boost.Graph", has_boost},
    {reverse_cuthill_mckee, "reverse-cuthill-mckee", "Boost.Graph", has_boost},
    {sloan, "sloan", "Boost.Graph", has_boost},
    {wide, "wide", "", true},
    {best, "best", "", true},
    {user, "user", "", true},
}};

constexpr auto made = [] {
  std::array<OrderingMethod, methods.size() - 1> result{};
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = methods[k].method;
  return result;
}();

const Method& entry(OrderingMethod method) { return methods[static_cast<std::size_t>(method)]; }

std::vector<NodeId> package_sequence([[maybe_unused]] const BlockGraph& graph, OrderingMethod method) {
  switch (method) {
#ifdef GRAPHSOLVE_SUITESPARSE
    case amd: return packages::amd(graph);
    case camd: return packages::camd(graph);
    case colamd: return packages::colamd(graph);
#endif
#ifdef GRAPHSOLVE_METIS
    case nested_dissection: return packages::nested_dissection(graph);
#endif
#ifdef GRAPHSOLVE_BOOST
    case minimum_degree: return packages::minimum_degree(graph);
    case reverse_cuthill_mckee: return packages::reverse_cuthill_mckee(graph);
    case sloan: return packages::sloan(graph);
#endif
    default: throw std::logic_error("no package makes this ordering");
  }
}

/// Minimum fill where it fills nothing; else of it, AMD, CAMD (where there are constraints, mostly the better of the
/// two) and nested dissection the one of fewest operations, the first of equals.
Ordering best_ordering(const BlockGraph& graph) {
  Ordering result = minimum_fill_ordering(graph);
  const PredictedCost cost = predict_cost(graph, result);
  if (cost.fill_blocks == 0) return result;
  std::int64_t least = cost.operations;
  for (const OrderingMethod method : {amd, camd, nested_dissection}) {
    if (!available(method)) continue;
    Ordering other = make_ordering(graph, method);
    // A singular pivot costs more than any fill: an order that breaks the rule oftener is never better.
    if (other.forced > result.forced) continue;
    const std::int64_t operations = predict_cost(graph, other).operations;
    if (operations >= least) continue;
    least = operations;
    result = std::move(other);
  }
  return result;
}

}  // namespace

std::span<const OrderingMethod> ordering_methods() { return made; }

std::string_view name(OrderingMethod method) { return entry(method).name; }

std::optional<OrderingMethod> parse_ordering_method(std::string_view name) {
  std::string hyphenated(name);
  std::replace(hyphenated.begin(), hyphenated.end(), '_', '-');
  for (const OrderingMethod method : made)
    if (entry(method).name == hyphenated) return method;
  return std::nullopt;
}

bool available(OrderingMethod method) { return entry(method).available; }

Ordering make_ordering(const BlockGraph& graph, OrderingMethod method) {
  if (!available(method))
    throw std::invalid_argument("ordering '" + std::string(name(method)) +
                                "' is not available: this build is without " + std::string(entry(method).package));
  switch (method) {
    case natural: return natural_ordering(graph);
    case depth_first: return depth_first_ordering(graph);
    case minimum_fill: return minimum_fill_ordering(graph);
    case wide: return wide_ordering(graph);
    case best: return best_ordering(graph);
    case user: throw std::invalid_argument("ordering 'user' is made by user_ordering from a sequence of nodes");
    default: break;
  }
  bool edges = false;  // without any the packages have nothing to order, and some refuse to
  for (int i = 0; i < graph.size() && !edges; ++i) edges = !graph.edges({i}).empty();
  Ordering result = edges ? repaired(graph, package_sequence(graph, method)) : natural_ordering(graph);
  hold_networks_early(graph, result);
  result.method = method;
  return result;
}

}  // namespace graphsolve
