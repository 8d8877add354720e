#pragma once

#include <optional>
#include <string>
#include <vector>

#include "physics/batch_run.hpp"
#include "rollout_file.hpp"
#include "rollout_mpi.hpp"

/// From the command line to what a process is to do.
namespace cli {

/// Of the command line.
struct RolloutOptions {
  std::string scene, out, shard;
  std::vector<std::string> vary, merge;
  std::vector<std::string> given;  ///< names of the options that were
  std::optional<long long> copies;
  std::optional<int> steps;
  int threads = 1, lanes = physics::BatchRun{}.lanes;
  std::uint64_t seed = 0;
  double tolerance = physics::SimulatorSettings{}.tolerance;
};

/// What is known before the work.
struct RolloutPlan {
  RolloutRequest request;
  Shard shard;
  bool in_parts = false;          ///< processes write files of their own
  std::optional<Tally> finished;  ///< of the file of all processes, where an earlier run has completed it
};

/// Where a process of an MPI run keeps its records.
std::string part_file(const RolloutOptions& options, int rank, int count);

/// All processes begin, or none: one that waited for a sum with another that has ended would wait for ever. Empty, after
/// a sentence, where one of several cannot; throws DescriptionError where there is only one.
std::optional<RolloutPlan> agree_on_plan(const RolloutOptions& options, const Processes& processes);

}  // namespace cli
