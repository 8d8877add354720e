#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <queue>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "spaces.hpp"

namespace pose_graph {

/// Poses, numbered in the order of their ids, and measured relative poses with their information matrices.
template <class S>
struct Graph {
  struct Edge {
    int from, to;
    typename S::Pose measured;
    typename S::Matrix information;
  };
  int poses = 0;
  std::vector<long> ids;  ///< of the poses in the file
  std::vector<Edge> edges;
  std::vector<typename S::Pose> guess;  ///< the file's own; empty when it gives none
  std::map<std::string, int> passed_over;  ///< lines that were not taken up, by their first word
};

/// Throws std::runtime_error, which begins with `where`, unless all words of a line but the first are decimal numbers.
inline void check_words(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  std::string word;
  words >> word;
  while (words >> word) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (!std::isfinite(value) || *end != 0 || word.find_first_of("xX") != std::string::npos)  // no hexadecimal ones
      throw std::runtime_error(where + "'" + word + "' is no number that can be used");
  }
}

/// The id of a pose after `tag`. Throws std::runtime_error, which begins with `where`.
inline long read_id(std::istringstream& in, const std::string& tag, const std::string& where) {
  std::string word;
  if (!(in >> word)) throw std::runtime_error(where + "a number is missing after " + tag);
  char* end = nullptr;
  errno = 0;
  const long id = std::strtol(word.c_str(), &end, 10);
  if (*end != 0) throw std::runtime_error(where + "'" + word + "' is no id of a pose, which are whole numbers");
  if (errno == ERANGE) throw std::runtime_error(where + "'" + word + "' is too large for the id of a pose");
  return id;
}

/// An information matrix weighs errors: none may count less than nothing. Those of files are rounded.
template <class Matrix>
void check_information(const Matrix& information, const std::string& edge) {
  const auto values = Eigen::SelfAdjointEigenSolver<Matrix>(information, Eigen::EigenvaluesOnly).eigenvalues();
  if (values.minCoeff() >= -1e-6 * values.maxCoeff()) return;
  std::ostringstream text;
  text << edge << " whose information matrix is indefinite (an eigenvalue is " << values.minCoeff() << ")";
  throw std::runtime_error(text.str());
}

/// A measured relative pose as it stands in a file.
template <class S>
struct Line {
  int number;
  long from, to;
  typename S::Pose measured;
  typename S::Matrix information;
};

/// Throws std::runtime_error, which begins with `where`, unless the numbers of a line were read and nothing follows.
inline void check_end(std::istringstream& in, const std::string& line, const std::string& tag,
                      const std::string& where) {
  check_words(line, where);
  if (!in) throw std::runtime_error(where + "a number is missing after " + tag);
  if (std::string extra; in >> extra)
    throw std::runtime_error(where + "'" + extra + "' follows the last number of " + tag);
}

/// The rest of a line that begins with S::edge_tag.
template <class S>
Line<S> read_edge(std::istringstream& in, const std::string& line, int number, const std::string& where) {
  Line<S> e{};
  e.number = number;
  e.from = read_id(in, S::edge_tag, where);
  e.to = read_id(in, S::edge_tag, where);
  e.measured = S::read(in);
  for (int i = 0; i < S::size; ++i)
    for (int j = i; j < S::size; ++j) {
      in >> e.information(i, j);
      e.information(j, i) = e.information(i, j);
    }
  check_end(in, line, S::edge_tag, where);
  if (!S::turns(e.measured)) throw std::runtime_error(where + "a quaternion of length 0");
  const std::string edge = "an edge from pose " + std::to_string(e.from) + " to ";
  if (e.from == e.to) throw std::runtime_error(where + edge + "itself");
  check_information(e.information, where + edge + std::to_string(e.to));
  return e;
}

/// Reads the vertices and edges of one space from a .g2o file, with vertices for all poses or for none; other lines
/// (landmarks, FIX, parameters) are passed over and counted.
/// Throws std::runtime_error with file, line and what is wrong there.
template <class S>
Graph<S> read_g2o(const std::string& path) {
  if (std::filesystem::is_directory(path)) throw std::runtime_error(path + ": cannot be read: it is a folder");
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read: " + std::generic_category().message(errno));
  const auto where = [&](int number) { return path + ", line " + std::to_string(number) + ": "; };
  std::map<long, typename S::Pose> vertices;
  std::map<long, int> number;
  std::vector<Line<S>> edges;
  Graph<S> graph;
  std::string line, tag;
  for (int count = 1; std::getline(file, line); ++count) {
    std::istringstream in(line);
    if (!(in >> tag)) continue;
    if (tag == S::vertex_tag) {
      const long id = read_id(in, tag, where(count));
      const typename S::Pose pose = S::read(in);
      check_end(in, line, tag, where(count));
      if (!S::turns(pose)) throw std::runtime_error(where(count) + "a quaternion of length 0");
      if (!vertices.emplace(id, pose).second)
        throw std::runtime_error(where(count) + "a second " + tag + " of pose " + std::to_string(id));
      number[id] = 0;
    } else if (tag == S::edge_tag) {
      edges.push_back(read_edge<S>(in, line, count, where(count)));
      number[edges.back().from] = number[edges.back().to] = 0;
    } else {
      ++graph.passed_over[tag];
    }
  }
  if (edges.empty()) throw std::runtime_error(path + ": no line begins with " + S::edge_tag);
  for (const Line<S>& e : edges)
    for (const long id : {e.from, e.to})
      if (!vertices.empty() && !vertices.contains(id))
        throw std::runtime_error(where(e.number) + "an edge from pose " + std::to_string(e.from) + " to " +
                                 std::to_string(e.to) + ", but there is no " + S::vertex_tag + " of pose " +
                                 std::to_string(id));
  for (auto& [id, index] : number) {
    index = graph.poses++;
    graph.ids.push_back(id);
  }
  for (const Line<S>& e : edges) graph.edges.push_back({number[e.from], number[e.to], e.measured, e.information});
  for (const auto& [id, pose] : vertices) graph.guess.push_back(pose);
  return graph;
}

/// Starts: measurements added up along the edges of a breadth-first tree from pose 0 (few edges deep), or along
/// consecutive poses first (the odometry). Throws std::runtime_error naming a pose that no edges lead to.
enum class Walk { breadth_first, odometry };
template <class S>
std::vector<typename S::Pose> add_up(const Graph<S>& graph, Walk walk) {
  std::vector<std::vector<int>> at(graph.poses);
  for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
    at[graph.edges[e].from].push_back(e);
    at[graph.edges[e].to].push_back(e);
  }
  std::vector<typename S::Pose> pose(graph.poses);
  std::vector<char> known(graph.poses, 0);
  std::queue<int> waiting({0});
  known[0] = 1;
  const auto follow = [&](int e, int from) {
    const auto& edge = graph.edges[e];
    const int to = edge.from == from ? edge.to : edge.from;
    if (known[to]) return;
    pose[to] = S::compose(pose[from], edge.from == from ? edge.measured : S::inverse(edge.measured));
    known[to] = 1;
    waiting.push(to);
  };
  if (walk == Walk::odometry)
    for (int k = 0; k + 1 < graph.poses && known[k]; ++k)
      for (const int e : at[k])
        if (std::max(graph.edges[e].from, graph.edges[e].to) == k + 1) follow(e, k);
  while (!waiting.empty()) {
    const int k = waiting.front();
    waiting.pop();
    for (const int e : at[k]) follow(e, k);
  }
  const auto lost = std::find(known.begin(), known.end(), 0);
  if (lost != known.end())
    throw std::runtime_error("no edges lead from pose " + std::to_string(graph.ids[0]) + " to pose " +
                             std::to_string(graph.ids[lost - known.begin()]));
  return pose;
}

}  // namespace pose_graph
