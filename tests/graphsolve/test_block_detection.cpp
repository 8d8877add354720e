#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>
#include <set>

#include "graphsolve/block_detection.hpp"
#include "graphsolve/entry_map.hpp"
#include "graphsolve/factorization.hpp"
#include "graphsolve/io/block_map.hpp"
#include "graphsolve/io/eigen.hpp"
#include "support/graph_families.hpp"

namespace test_block_detection {

using namespace graphsolve;

SparseMatrix sparse(const Eigen::MatrixXd& dense) {
  return io::from_eigen(Eigen::SparseMatrix<double>(dense.sparseView()));
}

SparseMatrix sparse(int n, const std::vector<Triplet>& triplets) { return from_triplets(n, n, triplets); }

/// Rows and columns in a seeded random order; `from[i]` is the old row of new row i.
Eigen::MatrixXd shuffled(const Eigen::MatrixXd& dense, std::uint64_t seed, std::vector<int>& from) {
  const int n = static_cast<int>(dense.rows());
  from.resize(n);
  for (int i = 0; i < n; ++i) from[i] = i;
  std::mt19937_64 random(seed);
  for (int i = n - 1; i > 0; --i) std::swap(from[i], from[random() % static_cast<std::uint64_t>(i + 1)]);
  return Eigen::MatrixXd::NullaryExpr(n, n, [&](Eigen::Index i, Eigen::Index j) { return dense(from[i], from[j]); });
}

/// Every node of the graph found once, with its rows and kind, whatever order the rows are in.
void expect_found(const BlockGraph& graph, const BlockStructure& found, const std::vector<int>& from) {
  ASSERT_EQ(found.graph.size(), graph.size());
  std::vector<int> node_of(graph.rows());
  for (int v = 0; v < graph.size(); ++v) std::fill_n(node_of.begin() + graph.row({v}), graph.dimension({v}), v);
  for (int v = 0; v < found.graph.size(); ++v) {
    const std::vector<int> rows = found.matrix_rows({v});
    const NodeId node{node_of[from[rows[0]]]};
    ASSERT_EQ(static_cast<int>(rows.size()), graph.dimension(node));
    for (const int i : rows) EXPECT_EQ(node_of[from[i]], node.index);
    EXPECT_EQ(found.graph.kind({v}), graph.kind(node)) << graph.name(node);
    EXPECT_EQ(found.graph.edges({v}).size(), graph.edges(node).size()) << graph.name(node);
  }
}

struct Family {
  const char* name;
  std::function<BlockGraph()> make;
};
const Family all_families[] = {
    {"chain", [] { return families::chain(12); }},
    {"tree", [] { return families::balanced_tree(15); }},
    {"quadruped", [] { return families::quadruped(); }},
    {"star", [] { return families::star(8); }},
    {"loop", [] { return families::loop(9); }},
    {"ladder", [] { return families::ladder(12); }},
    {"grid", [] { return families::grid(4); }},
    {"grid of 3 rows", [] { return families::grid(4, 3); }},
    {"control", [] { return families::control(8, 3); }},
};

TEST(BlockDetection, FindsNodesAndKindsOfEveryFamilyWhateverTheOrderOfTheRows) {
  for (const Family& family : all_families) {
    SCOPED_TRACE(family.name);
    const BlockGraph graph = family.make();
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      std::vector<int> from;
      const Eigen::MatrixXd dense = shuffled(families::saddle_matrix(graph, seed), seed, from);
      expect_found(graph, detect_blocks(sparse(dense)), from);
    }
  }
}

TEST(BlockDetection, DetectedSystemsOfAllFamiliesAreSolved) {
  for (const Family& family : all_families) {
    SCOPED_TRACE(family.name);
    std::vector<int> from;
    const Eigen::MatrixXd dense = shuffled(families::saddle_matrix(family.make(), 5), 5, from);
    const SparseMatrix matrix = sparse(dense);
    const BlockStructure blocks = detect_blocks(matrix);
    const auto symbolic = std::make_shared<const Symbolic>(blocks.graph, minimum_fill_ordering(blocks.graph));
    Factorization factor(symbolic);
    factor.allow_refinement();
    factor.keep_matrix(true);
    EntryMap(matrix, blocks, *symbolic).write(matrix.value, factor.values());
    ASSERT_TRUE(factor.factorize().ok());
    const std::size_t n = matrix.rows;
    const Eigen::VectorXd b = dense * Eigen::VectorXd::LinSpaced(n, -1, 1);
    std::vector<double> right(n), solution(n), x(n);
    blocks.to_graph({b.data(), n}, right);
    solution = right;
    factor.solve(solution);
    factor.refine(right, solution);
    blocks.to_matrix(solution, x);
    EXPECT_LT(backward_error(matrix, {b.data(), n}, x).componentwise, 1e-15);
  }
}

TEST(BlockDetection, RowsAreCountedFromOneInNames) {
  // Rows 0, 1 and 3 are alike, 2 and 4 are, 5 stands alone.
  std::vector<Triplet> t;
  for (const int i : {0, 1, 3})
    for (const int j : {0, 1, 3}) t.push_back({i, j, i == j ? 4.0 : 1.0});
  for (const int i : {2, 4}) t.push_back({i, i, 1});
  t.push_back({2, 4, 1});
  t.push_back({5, 5, 1});
  const BlockStructure blocks = detect_blocks(sparse(6, t));
  ASSERT_EQ(blocks.graph.size(), 3);
  EXPECT_EQ(blocks.graph.name({0}), "rows 1-2, 4");
  EXPECT_EQ(blocks.graph.name({1}), "rows 3, 5");
  EXPECT_EQ(blocks.graph.name({2}), "row 6");
  EXPECT_EQ(blocks.graph.dimension({0}), 3);
}

TEST(BlockDetection, UnsymmetricPatternsAreCompletedAndTheZerosCounted) {
  const BlockStructure blocks = detect_blocks(sparse(3, {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {1, 0, 5}, {2, 1, 3}, {1, 2, 1}}));
  EXPECT_EQ(blocks.added_entries, 1);
  EXPECT_FALSE(blocks.symmetric);
  ASSERT_EQ(blocks.graph.size(), 3);
  EXPECT_EQ(blocks.graph.edges({1}).size(), 2u);
  EXPECT_TRUE(detect_blocks(sparse(2, {{0, 0, 1}, {1, 1, 1}})).symmetric);
}

TEST(BlockDetection, AMatrixPutTogetherWrongIsRefused) {
  const SparseMatrix good{.rows = 2, .columns = 2, .begin = {0, 1, 2}, .row = {0, 1}, .value = {1, 1}};
  EXPECT_EQ(detect_blocks(good).graph.rows(), 2);
  std::vector<SparseMatrix> wrong(5, good);
  wrong[0].begin = {0, 1, 3};
  wrong[1].begin = {0, 2};
  wrong[2].row = {0, 2};
  wrong[3].value = {1};
  wrong[4] = {.rows = 2, .columns = 2, .begin = {0, 2, 3}, .row = {1, 0, 1}, .value = {1, 1, 1}};
  for (const SparseMatrix& matrix : wrong) EXPECT_THROW((void)detect_blocks(matrix), std::invalid_argument);
}

TEST(BlockDetection, LongRunsAreCutEvenlyUnlessAskedOtherwise) {
  const int n = 100;
  const SparseMatrix dense = sparse(Eigen::MatrixXd::Ones(n, n));
  const BlockStructure cut = detect_blocks(dense);
  ASSERT_EQ(cut.graph.size(), 2);
  EXPECT_EQ(cut.graph.dimension({0}), 50);
  EXPECT_EQ(detect_blocks(dense, {.largest_block = 100}).graph.size(), 1);
  EXPECT_EQ(detect_blocks(dense, {.largest_block = 7}).graph.size(), 15);
  EXPECT_EQ(detect_blocks(dense, {.largest_block = 1}).graph.size(), 100);
  EXPECT_THROW((void)detect_blocks(dense, {.largest_block = 0}), std::invalid_argument);
}

TEST(BlockDetection, LeavesOfAHubStayApartButRowsOfOneConstraintDoNot) {
  // An arrow: all leaves have the same neighbour, each its own pivot.
  std::vector<Triplet> arrow;
  for (int i = 0; i < 10; ++i) {
    arrow.push_back({i, i, 1});
    if (i) arrow.insert(arrow.end(), {{i, 0, 0.1}, {0, i, 0.1}});
  }
  EXPECT_EQ(detect_blocks(sparse(10, arrow)).graph.size(), 10);
  // Without pivots of their own (rows 2 and 3) they are constraints on rows 0 and 1, and one block.
  std::vector<Triplet> constraint{{0, 0, 1}, {1, 1, 1}};
  for (const int i : {2, 3})
    for (const int j : {0, 1}) constraint.insert(constraint.end(), {{i, j, i + 2.0 * j * j + 1}, {j, i, i + 2.0 * j * j + 1}});
  const BlockStructure blocks = detect_blocks(sparse(4, constraint));
  ASSERT_EQ(blocks.graph.size(), 3);
  EXPECT_EQ(blocks.graph.dimension({2}), 2);
  EXPECT_EQ(blocks.graph.kind({2}), NodeKind::saddle);
}

TEST(BlockKinds, NegativeDiagonalsBesidePositiveOnesAreDualsOfAQuasiDefiniteSystem) {
  const std::vector<Triplet> t{{0, 0, 2}, {1, 1, -1e-8}, {2, 2, 3}, {0, 1, 1}, {1, 0, 1}, {1, 2, 1}, {2, 1, 1}};
  const BlockStructure blocks = detect_blocks(sparse(3, t));
  EXPECT_EQ(blocks.graph.kind({0}), NodeKind::regular);
  EXPECT_EQ(blocks.graph.kind({1}), NodeKind::saddle);
  EXPECT_EQ(blocks.graph.kind({2}), NodeKind::regular);
  // An indefinite Hessian is no constraint: its negative entry meets another one.
  std::vector<Triplet> hessian = t;
  hessian[2].value = -3;
  EXPECT_EQ(detect_blocks(sparse(3, hessian)).graph.kind({1}), NodeKind::regular);
}

TEST(BlockKinds, CostlessVariablesAreToldFromConstraintsByWhatTheyTouch) {
  // x0 costs, x1 does not; constraint 2 couples both.
  const BlockStructure blocks =
      detect_blocks(sparse(3, {{0, 0, 1}, {2, 0, 1}, {0, 2, 1}, {2, 1, 1}, {1, 2, 1}}));
  ASSERT_EQ(blocks.graph.size(), 3);
  EXPECT_EQ(blocks.graph.kind({0}), NodeKind::regular);
  EXPECT_EQ(blocks.graph.kind({1}), NodeKind::semidefinite);
  EXPECT_EQ(blocks.graph.kind({2}), NodeKind::saddle);
}

/// x_(k+1) = x_k with 400 steps of length t: rows 0 .. 400 are x, then 400 constraints, then t.
std::vector<Triplet> steps_of_free_length() {
  std::vector<Triplet> t;
  const auto couple = [&](int i, int j) { t.insert(t.end(), {{i, j, 1}, {j, i, 1}}); };
  for (int i = 0; i <= 400; ++i) t.push_back({i, i, 1});
  for (int k = 0; k < 400; ++k) couple(401 + k, k), couple(401 + k, k + 1), couple(401 + k, 801);
  t.push_back({801, 801, 1});
  return t;
}

TEST(BlockKinds, AParameterOfVeryManyConstraintsIsShared) {
  const SparseMatrix matrix = sparse(802, steps_of_free_length());
  const BlockGraph graph = detect_blocks(matrix).graph;
  ASSERT_EQ(graph.size(), 802);
  EXPECT_EQ(graph.kind({801}), NodeKind::shared);
  EXPECT_EQ(graph.kind({401}), NodeKind::saddle);
  const Symbolic symbolic(graph, minimum_fill_ordering(graph));
  EXPECT_GE(symbolic.position({801}), 802 - 4);  // at the end all see each other
  EXPECT_LE(symbolic.counts().fill_blocks, 802);
  // What the user says stands.
  std::vector<Block> blocks = consecutive_blocks(std::vector<int>(802, 1));
  blocks.back().kind = NodeKind::regular;
  EXPECT_EQ(make_blocks(matrix, blocks).graph.kind({801}), NodeKind::regular);
}

TEST(BlockKinds, AParameterThatAConstraintNeedsIsNotShared) {
  std::vector<Triplet> t = steps_of_free_length();
  std::erase_if(t, [](const Triplet& e) { return std::max(e.row, e.column) == 401 && std::min(e.row, e.column) <= 1; });
  const SparseMatrix matrix = sparse(802, t);
  EXPECT_EQ(detect_blocks(matrix).graph.kind({801}), NodeKind::regular);
}

TEST(BlockKinds, WeakCouplingsDoNotCarryAConstraint) {
  const BlockStructure blocks =
      detect_blocks(sparse(3, {{0, 0, 1}, {1, 1, 1}, {2, 0, 1}, {0, 2, 1}, {2, 1, 1e-4}, {1, 2, 1e-4}}));
  for (const auto& edge : blocks.graph.edges({2}))
    EXPECT_EQ(edge.rank, edge.to.index == 0 ? EdgeRank::full_row : EdgeRank::unknown);
}

TEST(BlockDetection, WrongMatricesAreRefusedByName) {
  const auto error = [](const SparseMatrix& matrix) -> std::string {
    try {
      (void)detect_blocks(matrix);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(error(from_triplets(2, 3, {})), "the matrix must be square, not 2 x 3");
  EXPECT_EQ(error(from_triplets(0, 0, {})), "the matrix has no rows");
  EXPECT_EQ(error(sparse(2, {{1, 0, std::nan("")}})), "entry (2, 1) of the matrix is not finite: nan");
}

TEST(UserBlocks, WrongOnesAreRefusedByName) {
  const SparseMatrix matrix = sparse(Eigen::MatrixXd::Identity(4, 4));
  const auto error = [&](const std::vector<Block>& blocks) -> std::string {
    try {
      (void)make_blocks(matrix, blocks);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_EQ(error({{"a", {0, 1}}, {"b", {2, 3}}}), "accepted");
  EXPECT_EQ(error({{"a", {0, 1}}, {"b", {2}}}), "row 4 is in no block");
  EXPECT_EQ(error({{"a", {0, 1}}, {"b", {1, 2, 3}}}), "row 2 is in block 'a' and in block 'b'");
  EXPECT_EQ(error({{"a", {0, 1, 2, 3}}, {"b", {}}}), "block 'b' has no rows");
  EXPECT_EQ(error({{"a", {0, 1, 2, 3, 4}}}), "block 'a': row 5 lies outside of 1 .. 4");
}

TEST(UserBlocks, CouplingsThatThePatternHasNotMakeRoom) {
  const SparseMatrix matrix = sparse(Eigen::MatrixXd::Identity(3, 3));
  const std::vector<Block> blocks = consecutive_blocks(std::vector{2, 1});
  EXPECT_TRUE(make_blocks(matrix, blocks).graph.edges({0}).empty());
  const BlockStructure roomy = make_blocks(matrix, blocks, std::vector<BlockCoupling>{{1, 0, EdgeRank::full_row}});
  ASSERT_EQ(roomy.graph.edges({0}).size(), 1u);
  EXPECT_EQ(roomy.graph.edges({0})[0].rank, EdgeRank::full_row);
}

TEST(BlockDetection, AHubAndAChainOfMillionsOfPairsAreNotComparedPairByPair) {
  // Comparing all rows with each other, or the hub with every leaf, would take hours: the test's timeout judges.
  const int n = 200'000;
  std::vector<Triplet> t;
  for (int i = 0; i < n; ++i) {
    t.push_back({i, i, 4});
    if (i > 0) t.insert(t.end(), {{i, 0, 1}, {0, i, 1}});
    if (i > 1) t.insert(t.end(), {{i, i - 1, 1}, {i - 1, i, 1}});
  }
  EXPECT_EQ(detect_blocks(sparse(n, t)).graph.size(), n);
}

}  // namespace test_block_detection
