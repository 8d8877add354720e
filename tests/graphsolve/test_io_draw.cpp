#include <gtest/gtest.h>

#include <algorithm>

#include "graphsolve/fill_analysis.hpp"
#include "graphsolve/io/draw.hpp"
#include "support/graph_families.hpp"

namespace test_io_draw {

using namespace graphsolve;

int occurrences(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

TEST(FillPicture, TheRatioIsOneOnTreesAndThatOfTheFamiliesElsewhere) {
  for (const BlockGraph& graph : {families::chain(10), families::loop(8), families::grid(4)}) {
    const Symbolic symbolic(graph, minimum_fill_ordering(graph));
    EXPECT_DOUBLE_EQ(io::fill_ratio(symbolic), families::fill_factor(symbolic));
  }
}

TEST(FillPicture, BlocksOfTheAnalysisStandInTheOrderOfTheCausesOfThePicture) {
  if (!fill_analysis_available()) GTEST_SKIP() << "skipped, no Boost.Graph";
  const BlockGraph graph = families::grid(5);
  const Symbolic symbolic(graph, minimum_fill_ordering(graph));
  const FillAnalysis analysis = analyze_fill(graph, symbolic);
  std::size_t at = 0;
  for (int k = 0; k < symbolic.pivots(); ++k) {
    for (int e = 0; e < static_cast<int>(symbolic.coupled(k).size()); ++e) {
      if (!symbolic.is_fill(k, e)) continue;
      ASSERT_LT(at, analysis.blocks.size());
      EXPECT_EQ(analysis.blocks[at].first, symbolic.node(k));
      EXPECT_EQ(analysis.blocks[at].later, symbolic.node(symbolic.coupled(k)[e]));
      ++at;
    }
  }
  EXPECT_EQ(at, analysis.blocks.size());
}

TEST(FillPicture, CausesGetColoursByTheirWeightAndTheRestShareOne) {
  const BlockGraph graph = families::grid(3);
  const Symbolic symbolic(graph, natural_ordering(graph));
  io::FillCauses causes;
  const int fills = static_cast<int>(symbolic.counts().fill_blocks);
  ASSERT_GT(fills, 20);
  for (int k = 0; k < fills; ++k) causes.of_fill.push_back(std::min(k, 9));
  for (int c = 0; c < 10; ++c) causes.names.push_back("cause " + std::to_string(c));
  const std::string svg = io::spy_svg(graph, symbolic, {.title = "a < b", .subtitle = "c", .causes = causes});
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  EXPECT_NE(svg.find("smaller causes"), std::string::npos);
  EXPECT_EQ(occurrences(svg, "of the fill</text>"), 8);
  EXPECT_EQ(occurrences(svg, ", fill: "), 2 * fills);
}

TEST(Pictures, ShowAReplacementForWhatXmlAndDotCannotHold) {
  const std::vector<std::string> names{"nul" + std::string(1, '\0') + "x", "bad\xff", "surrogate\xed\xa0\x80",
                                       "overlong\xc0\xaf", "last\xef\xbf\xbf", "last\xef\xbf\xbe", "cut\xe6\xbc",
                                       "bell\x07\x7f", "beyond\xf4\x90\x80\x80", "\xf8"};
  BlockGraph graph;
  for (const std::string& name : names) graph.add_node(name, 1);
  const NodeId last = graph.add_node("a\tb \xc3\xbc \xe6\xbc\xa2 \xf0\x9f\x98\x80 \"q\" \\N", 1);
  graph.add_edge({0}, last);
  const Symbolic symbolic(graph, minimum_fill_ordering(graph));
  io::SpyOptions options;
  options.title = "t\x01\xff";
  options.subtitle = "s\xef\xbf\xbf";
  options.causes.names = {"c\x02"};
  const std::string svg = io::spy_svg(graph, symbolic, options);
  for (const std::string& picture : {svg, io::graph_dot(graph), io::tree_dot(graph, symbolic)}) {
    EXPECT_TRUE(std::ranges::none_of(picture, [](unsigned char c) { return (c < 0x20 && c != '\n') || c == 0x7f; }));
    for (const char* bad : {"\xff", "\xed\xa0", "\xc0", "\xef\xbf\xbf", "\xef\xbf\xbe", "\xf4", "\xf8", "\xe6\xbc "})
      EXPECT_EQ(picture.find(bad), std::string::npos);
    for (const char* good : {"nul\xef\xbf\xbdx", "bad\xef\xbf\xbd", "cut\xef\xbf\xbd", "a b \xc3\xbc \xe6\xbc\xa2 \xf0\x9f\x98\x80"})
      EXPECT_NE(picture.find(good), std::string::npos) << good;
  }
}

TEST(GraphPicture, EveryNodeAndEdgeIsThereOnce) {
  const BlockGraph graph = families::quadruped();
  const Symbolic symbolic(graph, minimum_fill_ordering(graph));
  int edges = 0;
  for (int v = 0; v < graph.size(); ++v) edges += static_cast<int>(graph.edges({v}).size());
  EXPECT_EQ(occurrences(io::graph_dot(graph), " -- "), edges / 2);
  EXPECT_EQ(occurrences(io::graph_dot(graph), "[label="), graph.size());
  EXPECT_EQ(occurrences(io::tree_dot(graph, symbolic), " -> "), graph.size() - symbolic.components());
}

}  // namespace test_io_draw
