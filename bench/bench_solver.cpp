#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "baselines/baselines.hpp"
#include "context.hpp"
#include "graphsolve_solver.hpp"
#include "support/graph_families.hpp"
#include "support/problem_families.hpp"
#include "support/real_problems.hpp"
#include "unit.hpp"

/// graphsolve against general sparse packages: same matrix, same right-hand side, same run, one thread, medians of
/// thread CPU time. Names are "table/problem/solver". Counters [us], per system: analysis_us (ordering included),
/// write_us (getting new numbers to the solver; not counted with the others), refactor_us, solve_us, total_us (of both:
/// in one pass where the solver has that, else the sum), backward_error (componentwise, as the package leaves it),
/// refined_error and sweeps (graphsolve: after refinement), fill (graphsolve: scalars of the factor over those of the
/// matrix), rung (RobustSolver: enum Rung), nodes, rows. A solver that fails is an error with its reason.
/// bench/tables.py prints the tables.
namespace {

using families::Difficulty;
using families::Family;
using families::Leaves;
using families::Problem;
using families::Spec;
using families::Values;
using Factory = std::function<std::unique_ptr<baselines::Baseline>(const graphsolve::BlockGraph&)>;

double clock_cost = 0;  ///< of reading the clock once [s]; taken off

/// Thread CPU time of `f` [s].
template <class F>
double timed(F&& f) {
  const double begin = timing::thread_time();
  f();
  return std::max(timing::thread_time() - begin - clock_cost, 0.0);
}

std::span<const double> view(const Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }
std::span<double> view(Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

/// Problems are made at first use and kept: the same for all solvers.
struct Entry {
  Spec spec;
  int copies = 1;
  std::string real = {};  ///< a matrix or pose graph of that name, whatever the spec says
};
Problem make_problem(const Entry& entry) {
  if (entry.real.empty()) return families::make_problem(entry.spec);
  const auto graphs = families::pose_graphs();
  return std::find(graphs.begin(), graphs.end(), entry.real) != graphs.end() ? families::pose_graph(entry.real)
                                                                             : families::real_matrix(entry.real);
}
const Problem& problem_of(const Entry& entry, bool definite) {
  static std::map<std::string, Problem> made;
  Problem problem;
  const std::string key = entry.real + std::to_string(entry.copies) + (definite ? "d" : "") +
                          std::to_string(static_cast<int>(entry.spec.family)) + "," + std::to_string(entry.spec.n) + "," +
                          std::to_string(static_cast<int>(entry.spec.leaves)) +
                          std::to_string(static_cast<int>(entry.spec.difficulty)) +
                          std::to_string(static_cast<int>(entry.spec.values));
  if (const auto found = made.find(key); found != made.end()) return found->second;
  problem = make_problem(entry);
  if (entry.copies > 1) problem = families::repeated(problem, entry.copies);
  if (definite) {
    problem.matrix = baselines::positive_definite_twin(problem.matrix);
    problem.right = problem.matrix * problem.solution;
  }
  return made.emplace(key, std::move(problem)).first->second;
}

/// Several instances of one solver on one problem, so that a small one takes longer than reading the clock.
struct Team {
  std::vector<std::unique_ptr<baselines::Baseline>> members;
  Eigen::VectorXd x;
  baselines::Status status;

  void note(const baselines::Status& s) {
    if (!s.ok && status.ok) status = s;
  }
};

struct Times {
  std::vector<double> analysis, write, refactor, solve;
  std::vector<double> total;  ///< in one pass where there is one, else refactor + solve
};

void one_round(Team& team, const Problem& problem, double per_system, Times& times) {
  const auto& a = problem.matrix;
  const std::span<const double> values{a.valuePtr(), static_cast<std::size_t>(a.nonZeros())};
  times.write.push_back(per_system * timed([&] { for (auto& m : team.members) m->write(values); }));
  times.refactor.push_back(per_system * timed([&] { for (auto& m : team.members) team.note(m->refactor()); }));
  if (!team.status.ok) return;
  times.solve.push_back(per_system * timed([&] {
    for (auto& m : team.members) team.note(m->solve(view(problem.right), view(team.x)));
  }));
  times.total.push_back(times.refactor.back() + times.solve.back());
  if (!team.members.front()->has_one_pass()) return;
  for (auto& m : team.members) m->write(values);
  times.total.back() = per_system * timed([&] {
    for (auto& m : team.members) team.note(m->refactor_and_solve(view(problem.right), view(team.x)));
  });
}

void report_graphsolve(benchmark::State& state, bench::GraphsolveSolver& solver, const Problem& problem, Eigen::VectorXd& x) {
  const auto& a = problem.matrix;
  solver.allow_refinement();
  if (!solver.baselines::Baseline::refactor({a.valuePtr(), static_cast<std::size_t>(a.nonZeros())}).ok) return;
  if (!solver.solve(view(problem.right), view(x)).ok) return;
  const auto refined = solver.refine(view(problem.right), view(x));
  state.counters["refined_error"] = families::backward_error(a, view(x), view(problem.right));
  state.counters["sweeps"] = refined.sweeps;
  state.counters["dropped_rows"] = solver.outcome().dropped_rows;
  state.counters["boosts"] = solver.outcome().boosts;
  state.counters["fill"] = families::fill_factor(solver.symbolic());
  state.counters["operations"] = static_cast<double>(solver.outcome().operations);
}

bool symmetric(const Eigen::SparseMatrix<double>& a) {
  return (a - Eigen::SparseMatrix<double>(a.transpose())).norm() == 0;
}

/// Only definite matrices will do, and this one is not.
bool needs_twin(const Entry& entry, const Factory& factory) {
  const auto solver = factory({});
  if (solver->demand() != baselines::Demand::positive_definite) return false;
  const auto& a = problem_of(entry, false).matrix;
  return !solver->analyze(a).ok || !solver->refactor({a.valuePtr(), static_cast<std::size_t>(a.nonZeros())}).ok;
}

void race(benchmark::State& state, const Entry& entry, const Factory& factory) {
  // Of the families it is known before (add); files are read only when they are asked for.
  if (!entry.real.empty() && factory({})->demand() != baselines::Demand::any && !symmetric(problem_of(entry, false).matrix)) {
    state.SkipWithError("for symmetric matrices only");
    return;
  }
  const bool twin = needs_twin(entry, factory);
  const Problem& problem = problem_of(entry, twin);
  if (twin) state.SetLabel("positive definite twin");
  Team team;
  team.x = Eigen::VectorXd::Zero(problem.graph.rows());
  const int members = problem.graph.rows() < 500 ? 8 : 1;
  const double per_system = 1.0 / (members * entry.copies);
  Times times;
  for (int i = 0; i < members; ++i) team.members.push_back(factory(problem.graph));
  for (int i = 0; i < 3; ++i)
    times.analysis.push_back(per_system * timed([&] { for (auto& m : team.members) team.note(m->analyze(problem.matrix)); }));
  Times cold;
  if (team.status.ok) one_round(team, problem, per_system, cold);  // packages allocate in the first one
  for (auto _ : state) {
    if (!team.status.ok) {
      state.SkipWithError(team.status.why.c_str());
      break;
    }
    one_round(team, problem, per_system, times);
    state.SetIterationTime(times.total.empty() ? times.refactor.back() : times.total.back());
  }
  if (!team.status.ok) return;
  state.counters["analysis_us"] = 1e6 * timing::median(times.analysis);
  state.counters["write_us"] = 1e6 * timing::median(times.write);
  state.counters["refactor_us"] = 1e6 * timing::median(times.refactor);
  state.counters["solve_us"] = 1e6 * timing::median(times.solve);
  state.counters["total_us"] = 1e6 * timing::median(times.total);
  state.counters["backward_error"] = families::backward_error(problem.matrix, view(team.x), view(problem.right));
  state.counters["nodes"] = problem.graph.size() / entry.copies;
  state.counters["rows"] = problem.graph.rows() / entry.copies;
  if (auto* ours = dynamic_cast<bench::GraphsolveSolver*>(team.members.front().get()))
    report_graphsolve(state, *ours, problem, team.x);
  if (auto* ours = dynamic_cast<bench::RobustGraphsolve*>(team.members.front().get()))
    state.counters["rung"] = static_cast<int>(ours->report().rung);
}

using Solvers = std::vector<std::pair<std::string, Factory>>;

Solvers packages() {
  Solvers list;
#ifdef GRAPHSOLVE_HAS_BASELINES
  for (const auto make : {&baselines::cholmod_simplicial, &baselines::cholmod_supernodal, &baselines::umfpack,
                          &baselines::klu, &baselines::eigen_ldlt, &baselines::eigen_lu})
    list.emplace_back(make()->name(), [make](const graphsolve::BlockGraph&) { return make(); });
#endif
  return list;
}

Solvers ours(const std::vector<std::pair<std::string, bench::Way>>& ways) {
  Solvers list;
  for (const auto& [name, way] : ways)
    list.emplace_back("graphsolve " + name, [way = way](const graphsolve::BlockGraph& graph) {
      return std::make_unique<bench::GraphsolveSolver>(graph, way);
    });
  return list;
}

Solvers one_by_one(bench::Nodes nodes = bench::Nodes::as_given) {
  const std::string ending = nodes == bench::Nodes::merged ? " merged" : "";
  return ours({{"ldu" + ending, {.kind = graphsolve::FactorizationKind::ldu, .nodes = nodes}},
               {"ldlt" + ending, {.kind = graphsolve::FactorizationKind::ldlt, .nodes = nodes}}});
}

Solvers robust() {
  Solvers list;
  for (const auto& [name, kind] : {std::pair{"ldu", graphsolve::FactorizationKind::ldu}, std::pair{"ldlt", graphsolve::FactorizationKind::ldlt}})
    list.emplace_back(std::string("graphsolve robust ") + name, [kind = kind](const graphsolve::BlockGraph& graph) {
      return std::make_unique<bench::RobustGraphsolve>(graph, kind);
    });
  return list;
}

/// On the best instruction set, and on those a machine without it has.
Solvers in_packs() {
  std::vector<std::pair<std::string, bench::Way>> ways;
  const auto sets = graphsolve::simd::instruction_sets();
  for (auto set = sets.rbegin(); set != sets.rend(); ++set)
    for (const auto& [kind, text] : {std::pair{graphsolve::FactorizationKind::ldu, "ldu packs"},
                                     std::pair{graphsolve::FactorizationKind::ldlt, "ldlt packs"}})
      ways.push_back({text + (*set == sets.back() ? "" : " " + std::string(name(*set))),
                      {.kind = kind, .path = bench::Path::packs, .set = *set}});
  return ours(ways);
}

void add(const std::string& table, const std::string& problem, const Entry& entry, const Solvers& solvers) {
  for (const auto& [solver, factory] : solvers) {
    const Factory& make = factory;
    if (entry.spec.values == Values::unsymmetric && make({})->demand() != baselines::Demand::any) continue;
    auto* b = benchmark::RegisterBenchmark((table + "/" + problem + "/" + solver).c_str(),
                                           [entry, make](benchmark::State& state) { race(state, entry, make); });
    b->UseManualTime()->Unit(benchmark::kMicrosecond);
    if (table == "hard") b->Iterations(3);
    else b->MinTime(0.03);
  }
}

/// Everybody on the entry; with more than one copy we solve all in one graph, they one after the other.
void add_all(const std::string& table, const Entry& entry) {
  const std::string problem = entry.real.empty() ? families::describe(entry.spec) : entry.real;
  add(table, problem, entry, one_by_one());
  if (table == "hard" || table == "real") add(table, problem, entry, robust());
  else add(table, problem, entry, in_packs());
  if (!entry.real.empty() || (table == "speed" && entry.spec.family == Family::grid))
    add(table, problem, entry, one_by_one(bench::Nodes::merged));
  Entry one = entry;
  one.copies = 1;
  add(table, problem, one, packages());
}

/// The BLAS that supernodal codes got, by the name of its file: how fast they are depends on it.
std::string blas() {
  std::ifstream file("/proc/self/maps");
  for (std::string line; std::getline(file, line);)
    if (line.find("blas") != std::string::npos)
      return std::filesystem::path(line.substr(line.find('/'))).parent_path().filename() / std::filesystem::path(line).filename();
  return "none";
}

void add_tables() {
  for (const Family family : {Family::chain, Family::tree, Family::quadruped, Family::loop, Family::ladder, Family::grid,
                              Family::random, Family::control}) {
    const bool stages = family == Family::control;
    add_all("speed", {{.family = family, .n = stages ? 100 : 1000}});
    if (family != Family::quadruped && family != Family::grid && family != Family::random)
      add_all("speed", {{.family = family, .n = stages ? 1000 : 10'000}});
  }
  for (const Family family : {Family::chain, Family::tree, Family::ladder})
    add_all("speed", {{.family = family, .n = 1000, .leaves = Leaves::one_each}});
  for (const Family family : families::all_families())
    add_all("unsymmetric", {{.family = family, .n = family == Family::control ? 100 : 1000, .values = Values::unsymmetric}});
  for (const Family family : {Family::chain, Family::tree, Family::quadruped, Family::loop, Family::ladder})
    add_all("batch of 8", {{.family = family, .n = 1000}, 8});
  for (const Difficulty difficulty : families::all_difficulties())
    for (const Family family : families::all_families())
      for (const Values values : {Values::symmetric, Values::unsymmetric})
        add_all("hard", {{.family = family, .n = 100, .difficulty = difficulty, .values = values}});
  for (const auto& names : {families::pose_graphs(), families::real_matrices()})
    for (const std::string& name : names) add_all("real", {.spec = {}, .copies = 1, .real = name});
}

}  // namespace

int main(int argc, char** argv) {
  setenv("OMP_NUM_THREADS", "1", 0);  // the packages' BLAS too
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  (void)bench::set_up();
  clock_cost = timing::clock_time();
  benchmark::AddCustomContext("blas", blas());
#ifdef GRAPHSOLVE_HAS_BASELINES
  benchmark::AddCustomContext("packages", baselines::versions());
#else
  std::fprintf(stderr, "graphsolve_baselines was not built: nothing to compare with\n");
#endif
  add_tables();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
