#pragma once

#include <memory>

#include "graphsolve/ordering.hpp"
#include "graphsolve/symbolic.hpp"

namespace cases {

/// Of two rows and of one, uncoupled.
struct TwoNodes {
  graphsolve::BlockGraph graph;
  std::shared_ptr<const graphsolve::Symbolic> symbolic;
  TwoNodes() {
    (void)graph.add_node("a", 2);
    (void)graph.add_node("b", 1);
    symbolic = std::make_shared<const graphsolve::Symbolic>(graph, graphsolve::natural_ordering(graph));
  }
};

}  // namespace cases
