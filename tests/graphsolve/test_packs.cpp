#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>

#include "factorization_cases.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/simd/lane_blocks.hpp"
#include "support/dense.hpp"

namespace test_packs {

using namespace graphsolve;
using cases::right_hand_side;
using cases::view;

/// Goes back to the best instruction set whatever the test does.
struct KeepInstructionSet {
  simd::InstructionSet before = simd::instruction_set();
  ~KeepInstructionSet() { simd::use_instruction_set(before); }
};

std::shared_ptr<const Symbolic> symbolic_of(const BlockGraph& graph, Packs packs = Packs::on) {
  return std::make_shared<const Symbolic>(graph, minimum_fill_ordering(graph), packs);
}

Eigen::VectorXd solution(const BlockGraph& graph, const Eigen::MatrixXd& matrix, Packs packs, bool transposed) {
  Factorization f(symbolic_of(graph, packs));
  families::load(matrix, graph, f.symbolic(), f.values());
  EXPECT_TRUE(f.factorize().ok());
  Eigen::VectorXd x = right_hand_side(graph.rows());
  if (transposed) f.solve_transposed(view(x));
  else f.solve(view(x));
  return x;
}

std::vector<BlockGraph> graphs() {
  std::vector<BlockGraph> list{families::balanced_tree(200), families::quadruped(), families::star(20), families::grid(6),
                               families::ladder(40), families::loop(30)};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    list.push_back(families::random_tree(60, seed));
    list.push_back(families::random_with_loops(40, 8, seed));
    list.push_back(families::control(12, seed));
  }
  return list;
}

TEST(Packs, SolveAsTheScalarPathDoesOnEveryFamilyAndInstructionSet) {
  const KeepInstructionSet keep;
  for (const auto set : simd::instruction_sets()) {
    simd::use_instruction_set(set);
    int number = 0;
    for (const BlockGraph& graph : graphs()) {
      SCOPED_TRACE(std::string(name(set)) + ", graph " + std::to_string(number));
      const Eigen::MatrixXd matrix = families::dominant_matrix(graph, ++number);
      for (const bool transposed : {false, true}) {
        const Eigen::VectorXd scalar = solution(graph, matrix, Packs::off, transposed);
        const Eigen::VectorXd packed = solution(graph, matrix, Packs::on, transposed);
        EXPECT_LE((packed - scalar).norm(), 1e-12 * scalar.norm());
      }
    }
  }
}

TEST(Packs, SolveSaddleSystemsAsDenseLUDoes) {
  const KeepInstructionSet keep;
  for (const auto set : simd::instruction_sets()) {
    simd::use_instruction_set(set);
    for (const BlockGraph& graph : {families::balanced_tree(40), families::quadruped(), families::star(16)}) {
      const Eigen::MatrixXd matrix = families::saddle_matrix(graph, 5);
      const Eigen::VectorXd exact = dense::solve(matrix, right_hand_side(graph.rows()));
      EXPECT_LE((solution(graph, matrix, Packs::on, false) - exact).norm(), 1e-9 * exact.norm());
    }
  }
}

/// Diagonals that vanish need exchanges of rows, which a pack does not do: those lanes go alone, the others do not.
TEST(Packs, LanesThatNeedExchangesOfRowsAreDoneAlone) {
  const KeepInstructionSet keep;
  const BlockGraph graph = families::star(24);
  Eigen::MatrixXd matrix = families::dominant_matrix(graph, 3);
  for (int node = 0; node < graph.size(); node += 5) {
    const int row = graph.row({node}), d = graph.dimension({node});
    if (d < 2) continue;
    matrix.row(row).swap(matrix.row(row + 1));
    matrix(row, row) = node % 2 ? 0 : 1e-14;
  }
  const Eigen::VectorXd exact = dense::solve(matrix, right_hand_side(graph.rows()));
  for (const auto set : simd::instruction_sets()) {
    simd::use_instruction_set(set);
    EXPECT_LE((solution(graph, matrix, Packs::on, false) - exact).norm(), 1e-11 * exact.norm());
    const Eigen::VectorXd transposed = dense::solve(matrix.transpose(), right_hand_side(graph.rows()));
    EXPECT_LE((solution(graph, matrix, Packs::on, true) - transposed).norm(), 1e-11 * transposed.norm());
  }
}

/// Equal graphs side by side, as one graph.
BlockGraph copies(int count) {
  BlockGraph graph;
  for (int c = 0; c < count; ++c) {
    NodeId last;
    for (int i = 0; i < 6; ++i) {
      const NodeId node = graph.add_node("n", 6);
      if (i > 0) {
        const NodeId link = graph.add_node("l", 3, NodeKind::saddle);
        graph.add_edge(link, last, EdgeRank::full_row);
        graph.add_edge(link, node, EdgeRank::full_row);
      }
      last = node;
    }
  }
  return graph;
}

TEST(Packs, ComponentDoesNotDependOnThoseFactoredWithIt) {
  const BlockGraph graph = copies(8);
  const Eigen::MatrixXd matrix = families::saddle_matrix(graph, 9);
  const auto symbolic = symbolic_of(graph);
  const auto run = [&](std::vector<int> components, bool spoil) {
    Factorization f(symbolic);
    families::load(matrix, graph, *symbolic, f.values());
    if (spoil) {  // a neighbour in the same packs is not a number
      const auto handle = symbolic->block({0}, {0});
      f.entry(handle) = std::numeric_limits<double>::quiet_NaN();
    }
    const auto outcomes = f.factorize(components);
    EXPECT_TRUE(outcomes[3].ok());
    if (spoil) {
      EXPECT_EQ(symbolic->component(symbolic->node(outcomes[0].first_bad_pivot)), 0);
    }
    Eigen::VectorXd x = right_hand_side(graph.rows());
    std::erase_if(components, [&](int c) { return !outcomes[c].ok(); });
    f.solve_components(view(x), components);
    Eigen::VectorXd mine(symbolic->rows());
    int n = 0;
    for (int k = symbolic->component_begin(3); k < symbolic->component_begin(4); ++k)
      for (int i = 0; i < symbolic->dimension(k); ++i) mine[n++] = x[symbolic->row(k) + i];
    mine.conservativeResize(n);
    return mine;
  };
  const Eigen::VectorXd together = run({0, 1, 2, 3, 4, 5, 6, 7}, false);
  EXPECT_EQ(together, run({3}, false));
  EXPECT_EQ(together, run({3, 6}, false));
  EXPECT_EQ(together, run({0, 1, 2, 3, 4, 5, 6, 7}, true));
}

/// One fills its lanes by itself, two go one after the other, eight have a lane each.
TEST(Packs, ComponentCountsWhatIsPredictedOfItInAnyCompany) {
  for (const int n : {1, 2, 8}) {
    const BlockGraph graph = copies(n);
    const Eigen::MatrixXd dominant = families::dominant_matrix(graph, 5), matrix = dominant + dominant.transpose();
    const auto symbolic = symbolic_of(graph);
    ASSERT_EQ(symbolic->components(), n);
    const auto& counts = symbolic->counts();
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    for (const auto kind : {FactorizationKind::ldu, FactorizationKind::cholesky})
      for (const std::vector<int>& components : {all, std::vector{n - 1}}) {
        SCOPED_TRACE(std::to_string(components.size()) + " of " + std::to_string(n));
        Factorization f(symbolic, kind);
        families::load(matrix, graph, *symbolic, f.values());
        const auto outcomes = f.factorize(components);
        for (const int c : components) {
          ASSERT_TRUE(outcomes[c].ok());
          EXPECT_EQ(outcomes[c].operations * n,
                    kind == FactorizationKind::ldu ? counts.operations : counts.symmetric_operations);
          EXPECT_EQ(outcomes[c].pivots * n, symbolic->pivots());
          if (kind == FactorizationKind::cholesky) {
            EXPECT_EQ(outcomes[c].inertia, (Inertia{graph.rows() / n, 0, 0}));
          }
        }
      }
  }
}

TEST(Packs, ComponentFactoredAgainLeavesTheOthersUsable) {
  const BlockGraph graph = copies(8);
  const auto symbolic = symbolic_of(graph);
  const Eigen::MatrixXd matrix = families::saddle_matrix(graph, 2);
  Factorization f(symbolic);
  families::load(matrix, graph, *symbolic, f.values());
  ASSERT_TRUE(f.factorize().ok());
  Eigen::VectorXd before = right_hand_side(graph.rows());
  f.solve(view(before));
  // Component 5 anew, with the same numbers.
  Factorization fresh(symbolic);
  families::load(matrix, graph, *symbolic, fresh.values());
  const int five[] = {5};
  f.set_zero(five);
  for (int k = symbolic->component_begin(5); k < symbolic->component_begin(6); ++k) {
    const Symbolic::Pivot& p = symbolic->pivot(k);
    const auto take = [&](std::int64_t at) {
      EXPECT_EQ(f.values()[at], 0);
      f.values()[at] = fresh.values()[at];
    };
    for (std::int64_t i = 0; i < p.lower_scalars(); ++i) take(p.diagonal + i * p.stride);
    for (std::int64_t i = 0; i < p.upper_scalars(); ++i) take(p.upper + i * p.stride);
  }
  f.factorize(five);
  Eigen::VectorXd after = right_hand_side(graph.rows());
  f.solve(view(after));
  EXPECT_EQ(before, after);
}

TEST(Packs, EqualComponentsLieLaneByLaneSideBySide) {
  const auto symbolic = symbolic_of(copies(8));
  const int pivots = symbolic->component_begin(1);
  for (int c = 0; c < 8; ++c)
    for (int k = 0; k < pivots; ++k) {
      const Symbolic::Pivot &first = symbolic->pivot(k), &p = symbolic->pivot(symbolic->component_begin(c) + k);
      ASSERT_EQ(p.stride, 8);
      ASSERT_EQ(p.diagonal, first.diagonal + c);
      ASSERT_EQ(first.diagonal % 8, 0);
    }
  EXPECT_EQ(symbolic->values_size(), symbolic->counts().stored_scalars);
}

/// What a pivot changes first is its parent: most of them change the same lane of another pack.
TEST(Packs, LanesOfALongChainFollowItsTree) {
  const BlockGraph graph = families::chain(200);
  const Symbolic symbolic(graph, wide_ordering(graph));
  int wide = 0, following = 0;
  for (int k = 0; k < symbolic.pivots(); ++k) {
    const Symbolic::Pivot& p = symbolic.pivot(k);
    if (p.stride != 8 || p.parent < 0) continue;
    const Symbolic::Pivot& parent = symbolic.pivot(p.parent);
    ++wide;
    following += parent.stride == 8 && parent.diagonal % 8 == p.diagonal % 8;
  }
  EXPECT_GT(wide, symbolic.pivots() * 3 / 4);
  EXPECT_GT(following, wide * 3 / 4);
}

/// Zeroing leaves claimed blocks alone where all components are zeroed together, and nothing else ever.
TEST(Packs, OnlyBlocksThatAreClaimedInAllLanesAreLeftUnzeroed) {
  const BlockGraph graph = copies(8);
  const auto symbolic = symbolic_of(graph);
  const Symbolic& s = *symbolic;
  const auto diagonal = [&](int pivot) { return s.block(s.node(pivot), s.node(pivot)); };
  std::vector<BlockHandle> claimed;
  for (int c = 0; c < 8; ++c) {
    claimed.push_back(diagonal(s.component_begin(c)));
    if (c != 5) claimed.push_back(diagonal(s.component_begin(c) + 1));  // lane 5 of this pack does not
  }
  Factorization f(symbolic);
  f.leave_unzeroed(claimed);
  std::vector<int> everything(8), some{1, 6};
  std::iota(everything.begin(), everything.end(), 0);
  std::ranges::fill(f.values(), 3.0);
  f.set_zero(everything);
  std::int64_t left = 0;
  for (int c = 0; c < 8; ++c) {
    EXPECT_EQ(f.entry(diagonal(s.component_begin(c))), 3.0) << "copy " << c;
    left += static_cast<std::int64_t>(s.dimension(s.component_begin(c))) * s.dimension(s.component_begin(c));
  }
  EXPECT_EQ(std::ranges::count(f.values(), 3.0), left);
  // A few alone: their lanes are zeroed whatever was claimed, the others' are not touched.
  std::ranges::fill(f.values(), 3.0);
  f.set_zero(some);
  for (int c = 0; c < 8; ++c)
    for (int k = s.component_begin(c); k < s.component_begin(c + 1); ++k)
      EXPECT_EQ(f.entry(diagonal(k)), c == 1 || c == 6 ? 0.0 : 3.0) << "copy " << c;
  claimed.push_back(claimed.front());
  EXPECT_THROW(f.leave_unzeroed(claimed), std::logic_error);
}

TEST(Packs, LanesThatLieSideBySideAreFound) {
  const auto together = [](std::initializer_list<BlockHandle> of_lane) {
    simd::LaneBlocks blocks;
    int lane = 0;
    for (const BlockHandle& block : of_lane) blocks.set(lane++, block);
    blocks.finish();
    return blocks.together();
  };
  const auto in = [](std::int64_t pack, int stride, int lane) { return BlockHandle{pack + lane, 2, 2, stride}; };
  EXPECT_EQ(together({in(64, 8, 0), in(64, 8, 1), in(64, 8, 2), in(64, 8, 3), in(64, 8, 4)}), 8) << "the rest is empty";
  EXPECT_EQ(together({in(64, 4, 0), in(64, 4, 1), in(64, 4, 2), in(64, 4, 3), in(128, 4, 0), in(128, 4, 1)}), 4);
  EXPECT_EQ(together({in(64, 2, 0), in(64, 2, 1), in(96, 2, 0), in(96, 2, 1)}), 2);
  EXPECT_EQ(together({in(64, 8, 1), in(64, 8, 0)}), 1) << "lanes that are exchanged";
  EXPECT_EQ(together({in(64, 1, 0), in(64, 1, 0)}), 1) << "two lanes of one block";
  EXPECT_EQ(together({in(64, 4, 0), in(64, 4, 1)}), 4);
}

TEST(Packs, InstructionSetsAreNamedAndOneThatIsNotThereIsRefused) {
  const KeepInstructionSet keep;
  const auto sets = simd::instruction_sets();
  ASSERT_FALSE(sets.empty());
  EXPECT_EQ(sets.front(), simd::InstructionSet::plain);
  for (const auto set : sets) {
    simd::use_instruction_set(set);
    EXPECT_EQ(simd::instruction_set(), set);
  }
  if (sets.back() != simd::InstructionSet::avx512) {
    EXPECT_THROW(simd::use_instruction_set(simd::InstructionSet::avx512), std::invalid_argument);
  }
}

}  // namespace test_packs
