// Pose graphs: where was the robot, given measured motions between pairs of poses?  Gauss-Newton on graphsolve's
// Factorization, in the plane and in space.
//
//   build/release/bin/pose_graph FILE.g2o ...     chi^2 and gradient per step, iterations, time per iteration
//   build/release/bin/pose_graph                  the same for two small graphs that it makes, writes and reads back
//
// Expected: the gradient falls by 1e8 or more, or to rounding where the start was that good (code 1 if not). On graphs made with Gaussian noise, chi^2 over the degrees
// of freedom must come out near 1. The start is the file's guess, the odometry, or a breadth-first tree of measurements,
// whichever has the least chi^2.

#include <cstring>
#include <exception>

#include "optimize.hpp"
#include "synthetic.hpp"

namespace {

using namespace pose_graph;

/// Gradient down by 1e8?
template <class S>
bool solve(const std::string& path, bool made_here) {
  const Graph<S> graph = read_g2o<S>(path);
  const double begin = thread_seconds();
  Optimizer<S> optimizer(graph);
  const double setup = thread_seconds() - begin;

  struct Start {
    const char* name;
    std::vector<typename S::Pose> pose;
  };
  std::vector<Start> starts{{"breadth-first tree", add_up(graph, Walk::breadth_first)},
                            {"odometry", add_up(graph, Walk::odometry)}};
  if (!graph.guess.empty()) starts.push_back({"the file's guess", graph.guess});
  Start* best = &starts[0];
  for (Start& start : starts)
    if (optimizer.chi2(start.pose) < optimizer.chi2(best->pose)) best = &start;

  const auto& counts = optimizer.symbolic().counts();
  std::printf("%s, %d poses, %zu edges, blocks of the factor over those of the matrix: %.2f\n", S::name, graph.poses,
              graph.edges.size(),
              static_cast<double>(counts.stored_scalars) / static_cast<double>(counts.matrix_scalars));
  std::printf("  start: %s\n", best->name);
  const Report report = optimizer.run(best->pose);
  for (std::size_t k = 0; k < report.steps.size(); ++k)
    std::printf("  %3zu  chi^2 %.6e  gradient %.1e%s\n", k, report.steps[k].chi2, report.steps[k].gradient,
                report.steps[k].damping > 0 ? "  damped" : "");
  const double freedom = S::size * (static_cast<double>(graph.edges.size()) - graph.poses + 1);
  std::printf("  chi^2 %.4f, over degrees of freedom %.3f\n", report.steps.back().chi2, report.steps.back().chi2 / freedom);
  std::printf("  gradient down to %.1e of its start in %d iterations, %d of them damped\n", report.reduction,
              report.iterations, report.damped);
  if (!made_here)
    std::printf("  ordering and symbolic %.1f ms, iteration %.2f ms (CPU time)\n", 1e3 * setup,
                1e3 * report.seconds_per_iteration);
  return report.reduction <= 1e-8 || report.at_rounding;
}

bool solve_file(const std::string& path, bool made_here) {
  std::ifstream file(path);
  std::string line;
  bool space = false;
  while (std::getline(file, line) && !space) space = line.find("_SE3:QUAT") != std::string::npos;
  return space ? solve<Space>(path, made_here) : solve<Plane>(path, made_here);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    bool solved = true;
    for (int k = 1; k < count; ++k) {
      std::printf("%s\n", arguments[k]);
      solved = solve_file(arguments[k], false) && solved;
    }
    if (count > 1) return solved ? 0 : 1;
    const std::string path = "pose_graph_example.g2o";  // in the current directory
    write_town(path);
    solved = solve_file(path, true) && solved;
    write_globe(path);
    solved = solve_file(path, true) && solved;
    std::remove(path.c_str());
    return solved ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pose_graph: %s\n", error.what());
    return 2;
  }
}
