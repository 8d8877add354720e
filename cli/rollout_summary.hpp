#pragma once

#include <string>

#include "rollout_file.hpp"
#include "rollout_mpi.hpp"

/// What the processes of a rollout did, and what is printed of it.
namespace cli {

struct Part {
  Tally tally;                  ///< of the shard, with what the file held before
  long long steps_now = 0;      ///< made in this run
  long long copies_before = 0;  ///< that the file held
  bool complete = false;
  int signal = 0;               ///< that ended it, or 0
};

/// Of all processes, which all have to call this: sums, and the signal that one of them got. The first failures of all are
/// known to the first process only.
void sum(const Processes& processes, Part& part);

/// On the standard error: the first failures, how many more there are, and each cause once with what would help.
void print_failures(const Tally& tally);

/// "17 solved, 3 stalled"
std::string statuses_text(const Tally& tally);

/// Where copies begin inside a plane: how many, and the first; else empty.
std::string inside_text(const Tally& tally);

struct Summary {
  const RolloutRequest& request;
  const Part& part;
  Shard shard;             ///< by --shard; all of it under mpirun
  int processes = 1;
  long long threads = 1;
  double wall = 0;         ///< [s]
  std::string file;        ///< empty: none was asked for
  std::string part_files;  ///< that hold the records as long as not all are complete; empty where there is one file
};
void print_summary(const Summary& summary);

/// Says on the standard error why it is not all solved. Returns the exit code.
int finish(const RolloutRequest& request, const Part& part, const Processes& processes);

}  // namespace cli
