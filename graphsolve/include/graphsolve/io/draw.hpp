#pragma once

#include <span>
#include <string>
#include <vector>

#include "graphsolve/block_graph.hpp"
#include "graphsolve/symbolic.hpp"

/// Pictures of a graph and its elimination, as text in UTF-8. What a picture cannot show of a name is replaced: white
/// space by a blank; other control characters, U+FEFF, U+FFFE, U+FFFF and bytes that are not UTF-8 by U+FFFD.
namespace graphsolve::io {

/// GraphViz: the graph, nodes by kind (regular an ellipse, shared one of two lines, semidefinite a dashed one, saddle a box) with their
/// dimension; full-rank couplings bold.
std::string graph_dot(const BlockGraph& graph);
/// GraphViz: the elimination tree, arrows to the parent, the last pivots on top.
std::string tree_dot(const BlockGraph& graph, const Symbolic& symbolic);

/// Why a block is fill, for colours and legend: an index into `names` per fill block, in the order of
/// Symbolic::coupled (all pivots ascending, fill couplings only). Empty: one colour for all fill.
struct FillCauses {
  std::vector<std::string> names;
  std::vector<int> of_fill;
};

struct SpyOptions {
  std::string title;     ///< the finding; empty: fill and ratio are stated
  std::string subtitle;  ///< what was drawn
  FillCauses causes;
};
/// SVG: the factor in elimination order, to scale in rows; what the matrix has is dark, fill coloured by cause. Up to
/// 150 nodes each block is drawn and names its nodes when pointed at; beyond, pixels gather what falls into them, as
/// opaque as they are full.
std::string spy_svg(const BlockGraph& graph, const Symbolic& symbolic, const SpyOptions& options = {});

/// Scalars of the factor over scalars of the matrix, one triangle with diagonal: 1 is no fill.
double fill_ratio(const Symbolic& symbolic);

}  // namespace graphsolve::io
