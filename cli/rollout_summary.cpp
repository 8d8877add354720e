#include "rollout_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <vector>

#include "commands.hpp"
#include "graphsolve/status.hpp"

namespace cli {

namespace {

using graphsolve::Status;

constexpr Status statuses[] = {Status::solved,   Status::max_iterations, Status::stalled,
                               Status::singular, Status::not_finite,     Status::step_bound};

/// The first of all processes, whose copies are in the order of the processes.
std::vector<std::string> gather_failures(const Processes& processes, const std::vector<std::string>& own) {
  std::string text;
  for (const std::string& failure : own) text += failure + '\0';  // names may have ends of lines
  std::vector<std::string> first;
  for (const std::string& texts : processes.gather(text))
    for (std::size_t at = 0; at < texts.size() && first.size() < most_failures_named; at = texts.find('\0', at) + 1)
      first.push_back(texts.substr(at, texts.find('\0', at) - at));
  return first;
}

std::string first_of(const std::vector<std::string>& texts) {
  const auto found = std::ranges::find_if(texts, [](const std::string& text) { return !text.empty(); });
  return found == texts.end() ? std::string() : *found;
}

}  // namespace

void sum(const Processes& processes, Part& part) {
  std::vector<long long> values{part.tally.copies,  part.tally.steps, part.steps_now,
                                part.copies_before, part.complete,    part.signal == SIGINT,
                                part.signal == SIGTERM, part.tally.inside, part.signal == SIGHUP};
  const std::size_t counted = values.size();
  for (const Status status : statuses) values.push_back(part.tally.statuses[std::string(name(status))]);
  processes.sum(values);
  part.tally.copies = values[0];
  part.tally.steps = values[1];
  part.steps_now = values[2];
  part.copies_before = values[3];
  part.complete = values[4] == processes.count();
  part.signal = values[6] > 0 ? SIGTERM : values[5] > 0 ? SIGINT : values[8] > 0 ? SIGHUP : 0;
  part.tally.inside = values[7];
  for (std::size_t i = 0; i < std::size(statuses); ++i)
    part.tally.statuses[std::string(name(statuses[i]))] = values[counted + i];
  part.tally.start_correction = processes.largest(part.tally.start_correction);
  part.tally.first_inside = first_of(processes.gather(part.tally.first_inside));
  part.tally.failures = gather_failures(processes, part.tally.failures);
}

void print_failures(const Tally& tally) {
  for (const std::string& failure : tally.failures) fmt::print(stderr, "graphsolve: {}\n", one_line(failure));
  const long long more = tally.failed() - static_cast<long long>(tally.failures.size());
  if (more > 0) fmt::print(stderr, "graphsolve: and {} more cop{} failed\n", more, more == 1 ? "y" : "ies");
  for (const Status status : statuses) {
    const auto found = tally.statuses.find(std::string(name(status)));
    if (status != Status::solved && found != tally.statuses.end() && found->second > 0)
      fmt::print(stderr, "graphsolve: {}: {}\n", name(status), physics::step_explanation(status));
  }
}

std::string statuses_text(const Tally& tally) {
  std::vector<std::string> parts;
  for (const auto& [status, count] : tally.statuses)
    if (count > 0) parts.push_back(fmt::format("{} {}", count, status));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string inside_text(const Tally& tally) {
  if (tally.inside == 0) return {};
  return fmt::format("{} a plane, which the first step has to undo; the first is {}",
                     tally.inside == 1 ? "1 copy begins inside" : fmt::format("{} copies begin inside", tally.inside),
                     tally.first_inside);
}

void print_summary(const Summary& s) {
  const auto line = [](const char* name, const std::string& text) { fmt::print("{:<22} {}\n", name, text); };
  line("rollout", fmt::format("{}: {} copies of {} steps{}", s.request.scene, s.request.copies, s.request.steps,
                              s.shard.count > 1 ? fmt::format(", shard {}/{}", s.shard.index, s.shard.count) : ""));
  line("outcomes", statuses_text(s.part.tally));
  const double tolerance = std::min(s.request.tolerance, physics::loosest_tolerance(s.request.mechanism));
  if (s.part.tally.start_correction > tolerance)  // not what rounding leaves
    line("start correction", fmt::format("up to {:.3g} m/s, to agree with the joints", s.part.tally.start_correction));
  if (const std::string inside = inside_text(s.part.tally); !inside.empty()) line("starts inside", inside);
  const long long due = s.shard.last(s.request.copies) - s.shard.first(s.request.copies) - s.part.tally.copies;
  if (due > 0) line("not done yet", fmt::format("{} copies", due));
  if (s.part.copies_before) line("done before", fmt::format("{} copies", s.part.copies_before));
  line("env-steps", fmt::format("{} in {:.3g} s: {:.4g} env-steps/s by {} process{} of {} thread{}", s.part.steps_now,
                                s.wall, static_cast<double>(s.part.steps_now) / s.wall, s.processes,
                                s.processes > 1 ? "es" : "", s.threads, s.threads > 1 ? "s" : ""));
  if (s.file.empty()) return;
  if (s.part.complete || s.part_files.empty())
    line("file", s.file);
  else
    line("files", fmt::format("{}; {} is made of them when all are complete", s.part_files, s.file));
}

int finish(const RolloutRequest& request, const Part& part, const Processes& processes) {
  if (processes.rank() == 0) print_failures(part.tally);
  if (part.signal && !part.complete) {
    if (processes.rank() == 0)
      fmt::print(stderr, "graphsolve: {}: stopped by signal {}; the same command goes on from there\n", request.scene,
                 part.signal);
    return interrupted + part.signal;
  }
  return part.tally.failed() > 0 ? step_failed : all_solved;
}

}  // namespace cli
