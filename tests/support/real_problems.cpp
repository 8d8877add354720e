#include "support/real_problems.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "graphsolve/io/matrix_market.hpp"

namespace families {

using graphsolve::NodeId;
using graphsolve::NodeKind;

namespace {

std::vector<std::string> stems(const std::string& folder, const std::string& ending) {
  std::vector<std::string> names;
  if (const auto data = data_directory())
    for (const auto& file : std::filesystem::directory_iterator(*data + "/" + folder))
      if (file.path().extension() == ending) names.push_back(file.path().stem());
  std::sort(names.begin(), names.end());
  return names;
}

void set_solution(Problem& problem) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> distribution;
  problem.solution = Eigen::VectorXd::NullaryExpr(problem.graph.rows(), [&] { return distribution(random); });
  problem.right = problem.matrix * problem.solution;
}

}  // namespace

std::optional<std::string> data_directory() {
  const std::string path = std::string(GRAPHSOLVE_SOURCE_DIR) + "/../shared/data";
  if (!std::filesystem::is_directory(path + "/matrices") || !std::filesystem::is_directory(path + "/pose_graphs")) return {};
  return path;
}

std::vector<std::string> real_matrices() { return stems("matrices", ".mtx"); }
std::vector<std::string> pose_graphs() { return stems("pose_graphs", ".g2o"); }

Problem real_matrix(const std::string& name) {
  const auto file = graphsolve::io::read_matrix_market(data_directory().value() + "/matrices/" + name + ".mtx");
  const auto& matrix = file.matrix;
  const bool pattern = file.field == graphsolve::io::Field::pattern;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> dominant(matrix.rows, 0.1);
  std::vector<char> diagonal(matrix.rows, 0);
  for (int j = 0; j < matrix.columns; ++j)
    for (std::int64_t k = matrix.begin[j]; k < matrix.begin[j + 1]; ++k) {
      const int i = matrix.row[k];
      if (i == j) diagonal[i] = 1;
      if (pattern && i <= j) continue;  // one value for both triangles, and a diagonal of our own
      const double value = pattern ? uniform(random) : matrix.value[k];
      entries.emplace_back(i, j, value);
      if (i != j) entries.emplace_back(j, i, pattern ? value : 0.0);
      dominant[i] += std::abs(value);
      dominant[j] += std::abs(value);
    }
  Problem problem;
  problem.name = name;
  for (int i = 0; i < matrix.rows; ++i) {
    entries.emplace_back(i, i, pattern ? dominant[i] : 0.0);
    problem.graph.add_node("row " + std::to_string(i + 1), 1,
                           pattern || diagonal[i] ? NodeKind::regular : NodeKind::semidefinite);
  }
  problem.matrix.resize(matrix.rows, matrix.rows);
  problem.matrix.setFromTriplets(entries.begin(), entries.end());
  for (int j = 0; j < matrix.rows; ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(problem.matrix, j); entry; ++entry)
      if (entry.row() > j) problem.graph.add_edge({j}, {static_cast<int>(entry.row())});
  set_solution(problem);
  return problem;
}

namespace {

/// A pose as a rotation matrix and a translation, of the plane or of space.
template <int D>
struct Pose {
  Eigen::Matrix<double, D, D> turn = Eigen::Matrix<double, D, D>::Identity();
  Eigen::Matrix<double, D, 1> place = Eigen::Matrix<double, D, 1>::Zero();
  Pose operator*(const Pose& b) const { return {turn * b.turn, turn * b.place + place}; }
  [[nodiscard]] Pose inverse() const { return {turn.transpose(), -turn.transpose() * place}; }
};

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// How an increment (place, turn) in the frame of a pose looks from another frame, in which the pose is `p`.
Eigen::Matrix3d adjoint(const Pose<2>& p) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = p.turn;
  m(0, 2) = p.place.y();
  m(1, 2) = -p.place.x();
  return m;
}
Eigen::Matrix<double, 6, 6> adjoint(const Pose<3>& p) {
  Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
  m.topLeftCorner<3, 3>() = m.bottomRightCorner<3, 3>() = p.turn;
  m.topRightCorner<3, 3>() = cross(p.place) * p.turn;
  return m;
}

Pose<2> read_pose(std::istream& in, Pose<2>) {
  double x = 0, y = 0, angle = 0;
  in >> x >> y >> angle;
  Pose<2> pose;
  pose.turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  pose.place << x, y;
  return pose;
}
Pose<3> read_pose(std::istream& in, Pose<3>) {
  Eigen::Vector3d place, v;
  double w = 1;
  in >> place.x() >> place.y() >> place.z() >> v.x() >> v.y() >> v.z() >> w;
  const double norm = std::sqrt(v.squaredNorm() + w * w);
  v /= norm, w /= norm;
  Pose<3> pose;
  pose.turn = Eigen::Matrix3d::Identity() + 2 * w * cross(v) + 2 * cross(v) * cross(v);
  pose.place = place;
  return pose;
}

template <int D>
Problem normal_matrix(std::istream& in) {
  constexpr int rows = D == 2 ? 3 : 6;
  using Block = Eigen::Matrix<double, rows, rows>;
  struct Edge {
    int a, b;
    Block weight;
  };
  std::vector<Pose<D>> poses;
  std::vector<Edge> edges;
  const auto room = [&](int i) {
    if (i >= static_cast<int>(poses.size())) poses.resize(i + 1);
  };
  bool guessed = false;
  for (std::string line, tag; std::getline(in, line);) {
    std::istringstream words(line);
    words >> tag;
    if (tag.starts_with("VERTEX")) {
      int i = 0;
      words >> i;
      room(i);
      poses[i] = read_pose(words, Pose<D>{});
      guessed = true;
    } else if (tag.starts_with("EDGE")) {
      Edge edge{};
      words >> edge.a >> edge.b;
      const Pose<D> measured = read_pose(words, Pose<D>{});
      for (int i = 0; i < rows; ++i)
        for (int j = i; j < rows; ++j) {
          words >> edge.weight(i, j);
          edge.weight(j, i) = edge.weight(i, j);
        }
      room(std::max(edge.a, edge.b));
      if (!guessed && edge.b == edge.a + 1) poses[edge.b] = poses[edge.a] * measured;
      edges.push_back(edge);
    }
  }
  Problem problem;
  for (std::size_t i = 1; i < poses.size(); ++i) problem.graph.add_node("pose " + std::to_string(i), rows);
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int a, int b, const Block& block) {
    if (a == 0 || b == 0) return;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < rows; ++i) entries.emplace_back((a - 1) * rows + i, (b - 1) * rows + j, block(i, j));
  };
  for (const Edge& edge : edges) {
    const Block j = -adjoint(poses[edge.b].inverse() * poses[edge.a]);  // with respect to the pose a; 1 for b
    const Block coupling = j.transpose() * edge.weight, own = coupling * j;
    add(edge.a, edge.a, 0.5 * (own + own.transpose()));
    add(edge.b, edge.b, edge.weight);
    add(edge.a, edge.b, coupling);
    add(edge.b, edge.a, coupling.transpose());
    if (edge.a > 0 && edge.b > 0) problem.graph.add_edge({edge.a - 1}, {edge.b - 1});
  }
  problem.matrix.resize(problem.graph.rows(), problem.graph.rows());
  problem.matrix.setFromTriplets(entries.begin(), entries.end());
  return problem;
}

}  // namespace

Problem pose_graph(const std::string& name) {
  const std::string path = data_directory().value() + "/pose_graphs/" + name + ".g2o";
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  Problem problem = text.str().find("SE3:QUAT") != std::string::npos ? normal_matrix<3>(text) : normal_matrix<2>(text);
  problem.name = name;
  set_solution(problem);
  return problem;
}

}  // namespace families
