#include "support/problem_families.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "support/graph_families.hpp"

namespace families {

using graphsolve::BlockGraph;
using graphsolve::EdgeRank;
using graphsolve::NodeId;
using graphsolve::NodeKind;

std::span<const Family> all_families() {
  static constexpr std::array list{Family::chain,  Family::tree, Family::quadruped, Family::loop,
                                   Family::ladder, Family::grid, Family::random,    Family::control};
  return list;
}

std::string_view name(Family family) {
  static constexpr std::array<std::string_view, 8> names{"chain",  "tree", "quadruped", "loop",
                                                         "ladder", "grid", "random",    "control"};
  return names[static_cast<std::size_t>(family)];
}

std::span<const Difficulty> all_difficulties() {
  static constexpr std::array list{Difficulty::plain, Difficulty::mass_ratio, Difficulty::wide_diagonals,
                                   Difficulty::redundant, Difficulty::exact_saddle};
  return list;
}

std::string_view name(Difficulty difficulty) {
  static constexpr std::array<std::string_view, 5> names{"plain", "mass ratio 1e6", "diagonals 1e-12..1e12",
                                                         "20 % redundant rows", "exact saddle"};
  return names[static_cast<std::size_t>(difficulty)];
}

BlockGraph control_12_4(int stages) {
  BlockGraph graph;
  NodeId state;
  for (int k = 0; k < stages; ++k) {
    const std::string step = std::to_string(k);
    const NodeId input = graph.add_node("input " + step, 4);
    const NodeId dynamics = graph.add_node("dynamics " + step, 12, NodeKind::saddle);
    const NodeId next = graph.add_node("state " + std::to_string(k + 1), 12);
    graph.add_edge(dynamics, input, EdgeRank::full_column);
    graph.add_edge(dynamics, next, EdgeRank::full);
    if (k > 0) graph.add_edge(dynamics, state, EdgeRank::full);
    state = next;
  }
  return graph;
}

namespace {

BlockGraph bare_graph(const Spec& spec) {
  switch (spec.family) {
    case Family::chain: return chain(spec.n);
    case Family::tree: return balanced_tree(spec.n);
    case Family::quadruped: return quadruped();
    case Family::loop: return loop(spec.n);
    case Family::ladder: return ladder(spec.n);
    case Family::grid: return grid(static_cast<int>(std::ceil(std::sqrt(spec.n))), 3);
    case Family::random: return random_with_loops(spec.n, spec.n / 10, spec.seed);
    case Family::control: return control_12_4(spec.n);
  }
  return {};
}

/// `twin_of[i]` is the node that node i repeats, or -1.
struct Structure {
  BlockGraph graph;
  std::vector<int> twin_of;
};

Structure structure_of(const Spec& spec) {
  Structure result{bare_graph(spec), {}};
  BlockGraph& graph = result.graph;
  const int n = graph.size();
  result.twin_of.assign(n, -1);
  if (spec.difficulty == Difficulty::redundant)
    for (int i = 0, saddles = 0; i < n; ++i) {
      if (graph.kind({i}) != NodeKind::saddle || saddles++ % 5 != 0) continue;
      const NodeId twin = graph.add_node("twin of " + std::string(graph.name({i})), graph.dimension({i}), NodeKind::saddle);
      const std::vector<BlockGraph::Edge> edges(graph.edges({i}).begin(), graph.edges({i}).end());
      for (const auto& edge : edges) graph.add_edge(twin, edge.to, edge.rank);
      result.twin_of.push_back(i);
    }
  if (spec.leaves == Leaves::one_each)
    for (int i = 0; i < n; ++i) {
      if (graph.kind({i}) == NodeKind::saddle) continue;
      graph.add_edge(graph.add_node("leaf of " + std::string(graph.name({i})), 3), {i});
      result.twin_of.push_back(-1);
    }
  return result;
}

/// Fills triplets block by block. A saddle node's block towards a neighbour is J (and G); all others belong to H.
class Writer {
 public:
  Writer(const Structure& structure, const Spec& spec)
      : graph_(structure.graph), twin_of_(structure.twin_of), spec_(spec), random_(spec.seed) {}

  Eigen::SparseMatrix<double> write() {
    scale_.resize(graph_.size(), 1.0);
    const double reach = spec_.difficulty == Difficulty::mass_ratio       ? 3
                         : spec_.difficulty == Difficulty::wide_diagonals ? 12
                                                                          : 0;
    std::uniform_real_distribution<double> exponent(-reach, reach);
    for (double& s : scale_) s = reach > 0 ? std::pow(10.0, exponent(random_)) : 1.0;
    jacobians_.resize(graph_.size());
    for (int a = 0; a < graph_.size(); ++a)
      if (graph_.kind({a}) == NodeKind::saddle) write_saddle(a);
      else write_regular(a);
    Eigen::SparseMatrix<double> matrix(graph_.rows(), graph_.rows());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    matrix.makeCompressed();
    return matrix;
  }

 private:
  Eigen::MatrixXd normal(int rows, int columns) {
    std::normal_distribution<double> distribution;
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return distribution(random_); });
  }

  void put(int row, int column, const Eigen::MatrixXd& block) {
    for (int j = 0; j < block.cols(); ++j)
      for (int i = 0; i < block.rows(); ++i) entries_.emplace_back(row + i, column + j, block(i, j));
  }

  /// Of a product that is symmetric but for rounding.
  static Eigen::MatrixXd lower_twice(const Eigen::MatrixXd& product) { return product.selfadjointView<Eigen::Lower>(); }

  void write_regular(int a) {
    const int d = graph_.dimension({a}), row = graph_.row({a});
    const Eigen::MatrixXd m = normal(d, d);
    Eigen::MatrixXd h = lower_twice(m * m.transpose());
    h += 0.5 * Eigen::MatrixXd::Identity(d, d);
    if (spec_.values == Values::unsymmetric) h += 0.3 * (m - m.transpose());
    put(row, row, scale_[a] * h);
    for (const auto& edge : graph_.edges({a})) {
      const int b = edge.to.index;
      if (b < a || graph_.kind(edge.to) == NodeKind::saddle) continue;
      // H as a whole stays definite: the coupling adds B' [1 X; X' X X'] B to what the two have.
      const int db = graph_.dimension({b});
      const double size = std::min(scale_[a], scale_[b]);
      const Eigen::MatrixXd x = normal(d, db);
      put(row, row, lower_twice(size * x * x.transpose()));
      put(row, graph_.row({b}), size * x);
      put(graph_.row({b}), row, size * x.transpose());
      put(graph_.row({b}), graph_.row({b}), size * Eigen::MatrixXd::Identity(db, db));
    }
  }

  void write_saddle(int a) {
    const int d = graph_.dimension({a}), row = graph_.row({a});
    const bool exact = spec_.difficulty == Difficulty::redundant || spec_.difficulty == Difficulty::exact_saddle;
    const double c = exact ? 0.0 : 1e-3;
    for (int i = 0; i < d; ++i) entries_.emplace_back(row + i, row + i, spec_.values == Values::symmetric ? -c : c);
    const Eigen::MatrixXd mix = normal(d, d);
    const auto edges = graph_.edges({a});
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const int b = edges[e].to.index, db = graph_.dimension({b}), column = graph_.row({b});
      Jacobian block;
      if (twin_of_[a] >= 0) {
        const Jacobian& origin = jacobians_[twin_of_[a]][e];
        block = {mix * origin.j, mix * origin.g};
      } else {
        block.j = jacobian(a, b);
        block.g = block.j + (spec_.values == Values::unsymmetric ? 0.02 : 0.0) * normal(d, db);
      }
      jacobians_[a].push_back(block);
      put(row, column, block.g);
      put(column, row, (spec_.values == Values::symmetric ? 1.0 : -1.0) * block.j.transpose());
    }
  }

  Eigen::MatrixXd jacobian(int a, int b) {
    const int d = graph_.dimension({a}), db = graph_.dimension({b});
    if (spec_.family != Family::control) return normal(d, db);
    if (b == a + 1) return -Eigen::MatrixXd::Identity(d, db);  // x_(k+1) = A x_k + B u_k
    return (b == a - 1 ? 1.0 : 0.8) / std::sqrt(d) * normal(d, db);
  }

  struct Jacobian {
    Eigen::MatrixXd j, g;
  };
  const BlockGraph& graph_;
  const std::vector<int>& twin_of_;
  const Spec& spec_;
  std::mt19937_64 random_;
  std::vector<double> scale_;
  std::vector<std::vector<Jacobian>> jacobians_;  ///< per saddle node, in the order of its edges
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace

std::string describe(const Spec& spec) {
  std::string text(name(spec.family));
  if (spec.family != Family::quadruped) text += " " + std::to_string(spec.n);
  if (spec.leaves == Leaves::one_each) text += ", leaves";
  if (spec.difficulty != Difficulty::plain) text += ", " + std::string(name(spec.difficulty));
  if (spec.values == Values::unsymmetric) text += ", unsymmetric";
  return text;
}

BlockGraph make_graph(const Spec& spec) { return structure_of(spec).graph; }

Problem make_problem(const Spec& spec) {
  Structure structure = structure_of(spec);
  Problem problem;
  problem.name = describe(spec);
  problem.matrix = Writer(structure, spec).write();
  problem.graph = std::move(structure.graph);
  std::mt19937_64 random(spec.seed + 1);
  std::normal_distribution<double> distribution;
  problem.solution = Eigen::VectorXd::NullaryExpr(problem.graph.rows(), [&] { return distribution(random); });
  problem.right = problem.matrix * problem.solution;
  return problem;
}

Problem repeated(const Problem& problem, int copies) {
  Problem result;
  result.name = std::to_string(copies) + " x " + problem.name;
  const BlockGraph& one = problem.graph;
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < copies; ++c) {
    const std::string prefix = "copy " + std::to_string(c) + " ";
    for (int i = 0; i < one.size(); ++i) result.graph.add_node(prefix + std::string(one.name({i})), one.dimension({i}), one.kind({i}));
    const int first = c * one.size(), row = c * one.rows();
    for (int i = 0; i < one.size(); ++i)
      for (const auto& edge : one.edges({i}))
        if (i < edge.to.index) result.graph.add_edge({first + i}, {first + edge.to.index}, edge.rank);
    for (int j = 0; j < problem.matrix.outerSize(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator entry(problem.matrix, j); entry; ++entry)
        entries.emplace_back(row + entry.row(), row + j, entry.value());
  }
  result.matrix.resize(result.graph.rows(), result.graph.rows());
  result.matrix.setFromTriplets(entries.begin(), entries.end());
  result.solution = problem.solution.replicate(copies, 1);
  result.right = problem.right.replicate(copies, 1);
  return result;
}

void load(const Eigen::SparseMatrix<double>& matrix, const BlockGraph& graph, const graphsolve::Symbolic& symbolic,
          std::span<double> values) {
  std::fill(values.begin(), values.end(), 0.0);
  std::vector<int> node_of(graph.rows());
  for (int i = 0; i < graph.size(); ++i)
    std::fill_n(node_of.begin() + graph.row({i}), graph.dimension({i}), i);
  for (int j = 0; j < matrix.outerSize(); ++j) {
    const NodeId b{node_of[j]};
    int last = -1;
    graphsolve::BlockHandle handle;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, j); entry; ++entry) {
      const NodeId a{node_of[entry.row()]};
      if (a.index != last) handle = symbolic.block(a, b);
      last = a.index;
      values[handle.place(static_cast<int>(entry.row()) - graph.row(a), j - graph.row(b))] = entry.value();
    }
  }
}

double backward_error(const Eigen::SparseMatrix<double>& a, std::span<const double> x, std::span<const double> b) {
  std::vector<long double> residual(b.begin(), b.end()), magnitude(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) magnitude[i] = std::abs(residual[i]);
  for (int j = 0; j < a.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry) {
      const long double product = static_cast<long double>(entry.value()) * x[j];
      residual[entry.row()] -= product;
      magnitude[entry.row()] += std::abs(product);
    }
  long double error = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (magnitude[i] == 0) continue;
    const long double e = std::abs(residual[i]) / magnitude[i];
    if (e > error || std::isnan(e)) error = e;  // not again once it is NaN: that compares false
  }
  return static_cast<double>(error);
}

}  // namespace families
