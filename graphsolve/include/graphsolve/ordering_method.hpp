#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace graphsolve {

/// How an elimination order is found (make_ordering in ordering.hpp). All act on the graph of blocks, one node per
/// block, and all are made to obey the eligibility rule.
enum class OrderingMethod {
  natural,                ///< as the nodes were added
  depth_first,            ///< depth-first search, the first found node last; trees only
  minimum_fill,           ///< least new scalars first; the default
  amd,                    ///< approximate minimum degree (SuiteSparse), blocks unweighted
  camd,                   ///< the same, saddle nodes held back until their small neighbours are gone (SuiteSparse)
  colamd,                 ///< minimum degree of the constraint matrix, saddle nodes as soon as they may (SuiteSparse)
  nested_dissection,      ///< small separators last, blocks weighted by dimension (METIS)
  minimum_degree,         ///< multiple minimum degree (Boost.Graph)
  reverse_cuthill_mckee,  ///< small bandwidth (Boost.Graph)
  sloan,                  ///< small profile (Boost.Graph)
  wide,                   ///< rounds of independent nodes: a low and wide elimination tree
  best,                   ///< of the cheap ones that are available the one of fewest predicted operations
  user,                   ///< the user's own sequence (user_ordering); not made by make_ordering
};

/// All methods that make_ordering knows, available or not, in the order of the enumeration.
std::span<const OrderingMethod> ordering_methods();

/// Lower case with hyphens, such as "minimum-fill".
std::string_view name(OrderingMethod method);

/// The method of that name (underscores count as hyphens), or nothing. Finds no "user".
std::optional<OrderingMethod> parse_ordering_method(std::string_view name);

/// Was the package that the method needs there when graphsolve was built?
bool available(OrderingMethod method);

}  // namespace graphsolve
