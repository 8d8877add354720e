#include "rollout_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <span>

#include "commands.hpp"
#include "graphsolve/simd/lanes.hpp"
#include "physics/batch_variation.hpp"
#include "scene_source.hpp"

namespace cli {

using graphsolve::simd::InstructionSet;
using physics::DescriptionError;

namespace {

Shard parse_shard(const std::string& text) {
  Shard shard;
  if (text.empty()) return shard;
  char rest = 0;
  const bool read = std::sscanf(text.c_str(), "%d/%d%c", &shard.index, &shard.count, &rest) == 2;
  if (!read || shard.count < 1 || shard.index < 0 || shard.index >= shard.count)
    throw DescriptionError(fmt::format("shard '{}' is not I/N with 0 <= I < N", text));
  return shard;
}

RolloutRequest make_request(const RolloutOptions& options) {
  if (options.scene.empty()) throw DescriptionError("rollout: SCENE is required");
  if (!options.copies) throw DescriptionError("rollout: --copies is required");
  if (!options.steps) throw DescriptionError("rollout: --steps is required");
  RolloutRequest request{.scene = options.scene,
                         .mechanism = load_scene(options.scene).trajectory.mechanism,
                         .copies = *options.copies,
                         .steps = *options.steps,
                         .tolerance = options.tolerance,
                         .seed = options.seed,
                         .variations = {}};
  try {
    physics::validate(request.mechanism);
  } catch (const DescriptionError& error) {
    throw about_scene(options.scene, error);
  }
  for (const std::string& text : options.vary) {
    const auto& v = request.variations.emplace_back(physics::parse_variation(text));
    for (std::size_t i = 0; i + 1 < request.variations.size(); ++i)
      if (request.variations[i].key == v.key) throw DescriptionError(fmt::format("vary '{}' is given twice", v.key));
    physics::check_variation(request.mechanism, v);
  }
  physics::check_start(request.mechanism, request.variations, physics::draw(request.variations, request.seed, 0));
  return request;
}

/// Files of a run with another number of processes, which this one cannot go on with.
void name_other_parts(const RolloutOptions& options, const Processes& processes) {
  for (const auto& [count, file] : other_parts(options.out, processes.count()))
    fmt::print(stderr,
               "graphsolve: '{}' is of a run by {} processes: this one, by {}, begins anew and leaves it alone; mpirun "
               "-np {} would go on with it\n",
               file, count, processes.count(), count);
}

RolloutPlan make_plan(const RolloutOptions& options, const Processes& processes) {
  const bool many = processes.count() > 1;
  if (many && !options.shard.empty()) throw DescriptionError("--shard is not for mpirun: each process is a shard");
  RolloutPlan plan{.request = make_request(options),
                   .shard = many ? Shard{processes.rank(), processes.count()} : parse_shard(options.shard),
                   .in_parts = many && !options.out.empty(),
                   .finished = {}};
  if (plan.in_parts && processes.rank() == 0) plan.finished = finished_rollout(options.out, plan.request);
  return plan;
}

constexpr InstructionSet all_sets[] = {InstructionSet::plain, InstructionSet::avx2, InstructionSet::avx512};

/// A sentence where processes have different ones; counts in the order of all_sets.
std::string mixed_sets(std::span<const long long> counts) {
  std::vector<std::string> found;
  std::string_view least;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    if (found.empty()) least = graphsolve::simd::name(all_sets[i]);
    found.push_back(fmt::format("{} by {}", counts[i], graphsolve::simd::name(all_sets[i])));
  }
  if (found.size() < 2) return {};
  return fmt::format("the processes compute by different instruction sets, {}, and last digits differ: set "
                     "GRAPHSOLVE_SIMD={} for all of them",
                     fmt::join(found, ", "), least);
}

}  // namespace

std::string part_file(const RolloutOptions& options, int rank, int count) {
  return fmt::format("{}.{}-of-{}", options.out, rank, count);
}

std::optional<RolloutPlan> agree_on_plan(const RolloutOptions& options, const Processes& processes) {
  if (processes.count() == 1) return make_plan(options, processes);
  std::optional<RolloutPlan> plan;
  std::string error;
  auto instruction_set = InstructionSet::plain;
  try {
    instruction_set = graphsolve::simd::instruction_set();
    plan = make_plan(options, processes);
  } catch (const std::exception& exception) {
    error = sentence_of(exception);
  }
  std::vector<long long> values{!plan, plan && plan->finished};
  for (const auto set : all_sets) values.push_back(plan && instruction_set == set);
  processes.sum(values);
  const bool all_failed = values[0] == processes.count();  // of the same, such as a wrong option
  if (!plan && (!all_failed || processes.rank() == 0)) fmt::print(stderr, "graphsolve: {}\n", error);
  if (values[0] > 0) return {};
  if (const std::string mixed = mixed_sets(std::span(values).subspan(2)); !mixed.empty()) {
    if (processes.rank() == 0) fmt::print(stderr, "graphsolve: {}\n", mixed);
    return {};
  }
  if (values[1] > 0 && !plan->finished) plan->finished.emplace();
  if (plan->in_parts && processes.rank() == 0 && !plan->finished) name_other_parts(options, processes);
  return plan;
}

}  // namespace cli
