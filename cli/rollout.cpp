#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include "options.hpp"
#include "outputs.hpp"
#include "physics/batch_run.hpp"
#include "physics/batch_variation.hpp"
#include "progress.hpp"
#include "rollout_copy.hpp"
#include "rollout_plan.hpp"
#include "rollout_summary.hpp"
#include "scene_source.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

constexpr int most_threads = 4096;  ///< more are a slip of the hand, and systems refuse them in the middle of the work
constexpr long long most_copies = 1'000'000'000'000;  ///< times the number of shards still fits

constexpr const char* footer = R"(Examples:
  graphsolve rollout disc --copies 10000 --steps 100 --vary friction=0.1:0.9 --threads 2 --out disc.jsonl
  graphsolve rollout quadruped --copies 1000 --steps 500 --vary trunk.mass=8:14 --vary start.velocity.x=-0.2:0.2
  graphsolve rollout quadruped --copies 1000 --steps 500 --vary trunk.force.y@100-150=-60:60   a push from the side
  graphsolve rollout disc --copies 10000 --steps 100 --shard 3/8 --out disc-3.jsonl     one of eight machines
  graphsolve rollout --merge disc-*.jsonl --out disc.jsonl                              their results together
  mpirun -np 8 graphsolve rollout disc --copies 10000 --steps 100 --out disc.jsonl      the same by MPI

Keys of --vary, each drawn evenly for each copy:
  friction, CONTACT.friction     coefficient of all contacts that have one, or of one
  mass, BODY.mass                factor on all masses; mass of one body [kg]; inertias in proportion
  gravity                        magnitude [m/s^2]
  BODY.force.x, BODY.torque.x    a load in all steps, added to the scene's [N in the world, N m in the body's frame]
  BODY.force.x@20-40             in the steps 20 to 40 only; torque likewise
  loads, BODY.loads              factor on all loads; on those of one body
  JOINT.stiffness, JOINT.damping, JOINT.limit                            of a motor
  JOINT.target                   of a motor whose target is a number [rad, m]
  JOINT.target.offset, .amplitude, .frequency, .phase                    of one whose target is a sine [rad, m, Hz]
  start.position.x, start.velocity.x                                     added to all bodies [m, m/s]
  start.BODY.position.x, start.BODY.velocity.x, start.BODY.angular_velocity.x     of one body
  start.BODY.rotation.x          turn about the world's axis, with all that is joined to it [rad]
  start.JOINT.angle, start.JOINT.travel, start.JOINT.rate                of a joint [rad, m, rad/s or m/s]
  start.JOINT.angle.x, start.JOINT.rate.x       turn and rate of a spherical one, axes of its parent [rad, rad/s]
  (x, y or z)
Keys apply in the order given: mass and loads scale, start.position and start.velocity without BODY, force and torque add
to, and rotation and angle.x turn, what is there by then; all others replace it. So --vary mass=2:2 --vary disc.mass=5:5
makes the disc 5 kg; the other way round it is 10 kg.

The file has one line of JSON per copy. Its bytes do not depend on threads, lanes or shards. The same command goes on
where a killed one stopped. See docs/rollouts.md.

Exit code: 0 all copies solved all steps, 1 some copy failed, 2 wrong input or a file that cannot be read or written,
129, 130 or 143 stopped by SIGHUP, SIGINT or SIGTERM (mpirun that is stopped itself has a code of its own).)";

void add_options(CLI::App& command, RolloutOptions& options) {
  const auto add = [&](const char* group, const char* name, auto& value, const char* type, const char* help) {
    return command.add_option(name, value, help)->type_name(type)->group(group);
  };
  constexpr int most = std::numeric_limits<int>::max();
  command.add_option("SCENE", options.scene, "A .json or .toml file, or a built-in scene with parameters")->type_name("");
  add("Work", "--copies", options.copies, "K", "Number of copies")->check(whole_number(1, most_copies));
  add("Work", "--steps", options.steps, "N", "Steps of each copy")->check(whole_number(1, most));
  add("Work", "--vary", options.vary, "KEY=LOW:HIGH", "A number that differs between copies; may be repeated")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add("Work", "--seed", options.seed, "S", "Of the random numbers")->check(seed())->capture_default_str();
  add("Work", "--tolerance", options.tolerance, "T", "Residual at which a step is accepted [m/s], at most |g| dt / 100")
      ->check(positive())
      ->capture_default_str();
  add("Machine", "--threads", options.threads, "T", "Threads of this process")->check(whole_number(1, most_threads))->capture_default_str();
  add("Machine", "--lanes", options.lanes, "L", "Copies that a thread steps together; multiples of 8 are best")
      ->check(whole_number(1, most))
      ->capture_default_str();
  add("Machine", "--shard", options.shard, "I/N", "Only part I = 0 .. N-1 of N of the copies");
  add("Output", "--out", options.out, "FILE", "One line of JSON per copy; continued when it is there")->check(file_name());
  add("Output", "--merge", options.merge, "FILE", "Put the files of all shards together into --out")->check(file_name());
  command.footer(footer);
}

Part run_shard(const RolloutOptions& options, const RolloutRequest& request, const Shard& shard, const std::string& path) {
  Part part;
  std::optional<RolloutFile> file;
  long long first = shard.first(request.copies);
  if (!path.empty()) {
    file.emplace(path, request, shard);
    first = file->next();
    part.tally = file->tally();
    part.copies_before = part.tally.copies;
  }
  const long long last = shard.last(request.copies);
  long long due = first;
  Progress progress(static_cast<int>(std::min<long long>(last - first, 1 << 30)), "copy");
  physics::BatchRun run{.first = first,
                        .last = last,
                        .steps = request.steps,
                        .threads = options.threads,
                        .lanes = options.lanes,
                        .settings = {},
                        .make = [&](long long copy) { return make_copy(request, copy); },
                        .stop = [] { return interrupt() != 0; },
                        .on_result = {}};
  run.settings.tolerance = request.tolerance;
  run.on_result = [&](physics::CopyResult&& result) {
    if (file) file->add(rollout_record(request, result));
    part.tally.add({result.copy, result.steps, std::string(graphsolve::name(result.last.status)), result.place,
                    result.start_correction, start_inside_text(request.mechanism, result)});
    part.steps_now += result.steps;
    ++due;
    progress.update(static_cast<int>(due - first));
    return interrupt() == 0;
  };
  try {
    physics::run_batch(request.mechanism, run);
  } catch (const physics::CopyError& error) {
    if (file) file->abandon();
    throw about_copy(request, error);
  } catch (const DescriptionError& error) {  // the scene itself
    if (file) file->abandon();
    throw about_scene(options.scene, error);
  } catch (...) {
    if (file) file->abandon();
    throw;
  }
  if (file) file->flush();
  part.complete = due == last;
  part.signal = interrupt();
  return part;
}

void merge_parts(const RolloutOptions& options, const Processes& processes) {
  std::vector<std::string> parts;
  for (int rank = 0; rank < processes.count(); ++rank) parts.push_back(part_file(options, rank, processes.count()));
  merge_rollouts(parts, options.out);
  for (const std::string& path : parts) std::filesystem::remove(path);
}

int rollout_here(const RolloutOptions& options, const Processes& processes) {
  std::optional<RolloutPlan> plan = agree_on_plan(options, processes);
  if (!plan) return wrong_input;
  const auto& [request, shard, in_parts, finished] = *plan;
  const bool many = processes.count() > 1, first = processes.rank() == 0;
  if (first) {
    (void)tolerance_used(request.tolerance, request.mechanism);
    note_coarse_step(request.mechanism);
  }
  catch_interrupts();
  const auto begin = std::chrono::steady_clock::now();
  Part part;
  if (finished)
    part = {.tally = *finished, .steps_now = 0, .copies_before = finished->copies, .complete = true, .signal = 0};
  else
    part = run_shard(options, request, shard,
                     in_parts ? part_file(options, processes.rank(), processes.count()) : options.out);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  sum(processes, part);
  if (first) {
    if (in_parts && part.complete && !finished) merge_parts(options, processes);
    const long long threads = std::clamp<long long>(shard.last(request.copies) - shard.first(request.copies), 1, options.threads);
    print_summary({.request = request,
                   .part = part,
                   .shard = many ? Shard{} : shard,
                   .processes = processes.count(),
                   .threads = threads,
                   .wall = wall,
                   .file = options.out,
                   .part_files = in_parts ? fmt::format("{}.*-of-{}", options.out, processes.count()) : ""});
    if (many) std::fflush(stdout);  // mpirun ends all once one has ended by another code than 0
  }
  return finish(request, part, processes);
}

int merge(const RolloutOptions& options) {
  if (options.out.empty()) throw DescriptionError("--merge needs --out");
  if (!options.scene.empty()) throw DescriptionError("--merge takes files of shards, no scene");
  for (const std::string& name : options.given)
    if (name != "--merge" && name != "--out")
      throw DescriptionError(fmt::format("--merge takes files of shards and --out, no {}", name));
  check_outputs({{"--out", options.out}}, options.merge);
  const Tally tally = merge_rollouts(options.merge, options.out);
  fmt::print("{:<22} {} copies: {}\n", "merged", tally.copies, statuses_text(tally));
  if (const std::string inside = inside_text(tally); !inside.empty()) fmt::print("{:<22} {}\n", "starts inside", inside);
  fmt::print("{:<22} {}\n", "file", options.out);
  print_failures(tally);
  return tally.failed() > 0 ? step_failed : all_solved;
}

int rollout(const RolloutOptions& options) {
  if (!options.merge.empty()) return merge(options);
  const Processes processes;
  try {
    return rollout_here(options, processes);
  } catch (const std::exception& error) {
    if (processes.count() == 1) throw;
    // The others would wait for this one in a sum, and it for them in the end of MPI.
    fmt::print(stderr, "graphsolve: process {} of {}: {}\n", processes.rank(), processes.count(), sentence_of(error));
    std::fflush(stderr);
    processes.abort(wrong_input);
    throw;
  }
}

}  // namespace

Command add_rollout(CLI::App& program) {
  CLI::App* command = program.add_subcommand("rollout", "Simulate many copies of a scene that differ in some numbers.");
  const auto options = std::make_shared<RolloutOptions>();
  add_options(*command, *options);
  return [command, options] {
    for (const CLI::Option* option : command->get_options())
      if (option->count() > 0) options->given.push_back(option->get_name());
    return rollout(*options);
  };
}

}  // namespace cli
