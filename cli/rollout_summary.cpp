#include "rollout_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <csignal>
#include <cstdio>
#include <vector>

#include "commands.hpp"

namespace cli {

void sum(const Processes& processes, Part& part) {
  const std::vector<std::string> names{"solved", "max_iterations", "stalled", "singular", "not_finite", "step_bound"};
  std::vector<long long> values{part.tally.copies,  part.tally.steps, part.steps_now,
                                part.copies_before, part.complete,    part.signal == SIGINT,
                                part.signal == SIGTERM};
  const std::size_t counted = values.size();
  for (const std::string& name : names) values.push_back(part.tally.statuses[name]);
  processes.sum(values);
  part.tally.copies = values[0];
  part.tally.steps = values[1];
  part.steps_now = values[2];
  part.copies_before = values[3];
  part.complete = values[4] == processes.count();
  part.signal = values[6] > 0 ? SIGTERM : values[5] > 0 ? SIGINT : 0;
  for (std::size_t i = 0; i < names.size(); ++i) part.tally.statuses[names[i]] = values[counted + i];
}

std::string statuses_text(const Tally& tally) {
  std::vector<std::string> parts;
  for (const auto& [status, count] : tally.statuses)
    if (count > 0) parts.push_back(fmt::format("{} {}", count, status));
  return parts.empty() ? "none" : fmt::format("{}", fmt::join(parts, ", "));
}

void print_summary(const Summary& s) {
  const auto line = [](const char* name, const std::string& text) { fmt::print("{:<22} {}\n", name, text); };
  line("rollout", fmt::format("{}: {} copies of {} steps{}", s.request.scene, s.request.copies, s.request.steps,
                              s.shard.count > 1 ? fmt::format(", shard {}/{}", s.shard.index, s.shard.count) : ""));
  line("outcomes", statuses_text(s.part.tally));
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
  for (const std::string& failure : part.tally.failures) fmt::print(stderr, "graphsolve: {}\n", failure);
  if (part.signal && !part.complete) {
    if (processes.rank() == 0)
      fmt::print(stderr, "graphsolve: {}: stopped by signal {}; the same command goes on from there\n", request.scene,
                 part.signal);
    return interrupted + part.signal;
  }
  return part.tally.failed() > 0 ? step_failed : all_solved;
}

}  // namespace cli
