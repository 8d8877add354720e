// Pose graphs: where was the robot, given measured motions between pairs of poses?  Gauss-Newton on graphsolve's
// Factorization, in the plane and in space.
//
//   build/release/bin/pose_graph FILE.g2o ...     chi^2 and gradient per step, iterations, time per iteration
//   build/release/bin/pose_graph                  the same for two small graphs that it makes, writes and reads back
//
// Expected: the gradient falls by 1e8 or more, or to rounding where the start was that good (code 1 if not, 2 for a file
// that cannot be read). On graphs made with Gaussian noise, chi^2 over the degrees of freedom must come out near 1. The
// start is the file's guess, the odometry, or a breadth-first tree of measurements, whichever has the least chi^2.

#include <unistd.h>

#include <exception>
#include <filesystem>
#include <string_view>

#include "optimize.hpp"
#include "synthetic.hpp"

namespace {

using namespace pose_graph;

/// Gradient down by 1e8? Says so on stderr where chi^2 or gradient are no numbers.
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
    if (!(optimizer.chi2(start.pose) >= optimizer.chi2(best->pose))) best = &start;  // anything is better than NaN

  const auto& counts = optimizer.symbolic().counts();
  std::printf("%s, %d poses, %zu edges, blocks of the factor over those of the matrix: %.2f\n", S::name, graph.poses,
              graph.edges.size(),
              static_cast<double>(counts.stored_scalars) / static_cast<double>(counts.matrix_scalars));
  for (const auto& [word, lines] : graph.passed_over)
    std::printf("  not taken up: %d line%s %s\n", lines, lines == 1 ? "" : "s", word.c_str());
  std::printf("  start: %s\n", best->name);
  const Report report = optimizer.run(best->pose);
  for (std::size_t k = 0; k < report.steps.size(); ++k)
    std::printf("  %3zu  chi^2 %.6e  gradient %.1e%s\n", k, report.steps[k].chi2, report.steps[k].gradient,
                report.steps[k].damping > 0 ? "  damped" : "");
  if (!report.finite()) {
    std::fflush(stdout);
    std::fprintf(stderr, "pose_graph: %s: not solved, numbers are too large: chi^2 is %g, its gradient %g\n", path.c_str(),
                 report.steps.back().chi2, report.steps.back().gradient);
    return false;
  }
  const double freedom = S::size * (static_cast<double>(graph.edges.size()) - graph.poses + 1);
  std::printf("  chi^2 %.4f", report.steps.back().chi2);
  if (freedom > 0) std::printf(", over degrees of freedom %.3f", report.steps.back().chi2 / freedom);
  std::printf("\n");
  std::printf("  gradient down to %.1e of its start in %d iterations, %d of them damped\n", report.reduction,
              report.iterations, report.damped);
  if (!made_here)
    std::printf("  ordering and symbolic %.1f ms, iteration %.2f ms (CPU time)\n", 1e3 * setup,
                1e3 * report.seconds_per_iteration);
  return report.reduction <= 1e-8 || report.at_rounding;
}

bool solve_file(const std::string& path, bool made_here) {
  std::ifstream file(path);
  std::string line, tag;
  bool space = false;
  while (std::getline(file, line) && !space)
    space = std::istringstream(line) >> tag && (tag == Space::vertex_tag || tag == Space::edge_tag);
  return space ? solve<Space>(path, made_here) : solve<Plane>(path, made_here);
}

/// In a folder of its own, which goes with the object.
class Scratch {
 public:
  Scratch() : folder_(std::filesystem::temp_directory_path() / ("pose_graph-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() {
    std::error_code none;
    std::filesystem::remove_all(folder_, none);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::string file() const { return (folder_ / "made.g2o").string(); }

 private:
  std::filesystem::path folder_;
};

/// The exit code: 0 solved, 1 not solved, 2 it cannot be read.
template <class F>
int guarded(F&& solved) {
  try {
    return solved() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pose_graph: %s\n", error.what());
    return 2;
  }
}

constexpr const char* usage = R"(Usage: pose_graph [FILE.g2o ...]
Solves pose graphs (SE(2) or SE(3)) by Gauss-Newton; without files two small ones that it makes.
Exit code: 0 all solved, 1 one was not, 2 wrong option or a file that cannot be read.
)";

}  // namespace

int main(int count, char** arguments) {
  for (int k = 1; k < count; ++k) {
    const std::string_view word = arguments[k];
    if (word == "-h" || word == "--help") return std::fputs(usage, stdout) < 0 ? 2 : 0;
    if (word.empty() || word[0] == '-') {
      std::fprintf(stderr, "pose_graph: there is no option '%s' (see 'pose_graph --help')\n", arguments[k]);
      return 2;
    }
  }
  int worst = 0;
  for (int k = 1; k < count; ++k) {
    std::printf("%s\n", arguments[k]);
    worst = std::max(worst, guarded([&] { return solve_file(arguments[k], false); }));
  }
  if (count > 1) return worst;
  return guarded([] {
    const Scratch scratch;
    write_town(scratch.file());
    const bool town = solve_file(scratch.file(), true);
    write_globe(scratch.file());
    return solve_file(scratch.file(), true) && town;
  });
}
