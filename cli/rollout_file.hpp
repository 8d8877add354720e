#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "file_lock.hpp"
#include "physics/batch_run.hpp"
#include "physics/batch_variation.hpp"

/// Files of rollouts: JSON lines, a header that says what was asked for, then one record per copy, in order.
namespace cli {

/// Copies first .. last - 1 of all, split evenly in order.
struct Shard {
  int index = 0, count = 1;
  [[nodiscard]] long long first(long long copies) const { return copies * index / count; }
  [[nodiscard]] long long last(long long copies) const { return copies * (index + 1) / count; }
};

/// All that the numbers in a file depend on.
struct RolloutRequest {
  std::string scene;               ///< as named on the command line
  physics::Mechanism mechanism;
  long long copies = 0;
  int steps = 0;
  double tolerance = 0;
  std::uint64_t seed = 0;
  std::vector<physics::Variation> variations;
};

/// What was counted in a file or a run.
struct Tally {
  struct Outcome {  ///< of one copy
    long long copy;
    int steps;
    std::string status, place;
    double start_correction;  ///< [m/s]
    std::string start_inside;  ///< what begins inside a plane, and how deep; empty: nothing
  };
  void add(const Outcome& outcome);
  [[nodiscard]] long long failed() const;

  long long copies = 0, steps = 0;
  double start_correction = 0;  ///< largest [m/s]
  long long inside = 0;         ///< copies that begin inside a plane
  std::string first_inside;     ///< the first of them
  std::map<std::string, long long> statuses;  ///< of the last step of each copy
  std::vector<std::string> failures;          ///< sentences, the first few
};
inline constexpr std::size_t most_failures_named = 10;

/// The header line without its end.
std::string rollout_header(const RolloutRequest& request, const Shard& shard);
/// What a copy that begins inside a plane is told by.
std::string start_inside_text(const std::string& body, const std::string& contact, double depth);
std::string start_inside_text(const physics::Mechanism& scene, const physics::CopyResult& result);  ///< empty: it does not
/// A record's line without its end.
std::string rollout_record(const RolloutRequest& request, const physics::CopyResult& result);

/// A file that is continued when it holds the beginning of the same rollout.
class RolloutFile {
 public:
  /// Reads what is there, drops a last line that is not complete. Throws DescriptionError when the file is another
  /// rollout's, or something else: "many.jsonl: holds a rollout with seed 1, not 2".
  RolloutFile(const std::string& path, const RolloutRequest& request, const Shard& shard);
  [[nodiscard]] long long next() const { return next_; }  ///< copy that is due
  [[nodiscard]] const Tally& tally() const { return tally_; }  ///< of the records that were there
  /// The record of the copy that is due. Throws DescriptionError on a full disk, for example.
  void add(const std::string& record);
  void flush();
  /// After wrong input: removes the file when it was made here and has no record yet.
  void abandon();

 private:
  std::string path_;
  std::optional<FileLock> lock_;
  std::ofstream out_;
  long long next_;
  Tally tally_;
  int unflushed_ = 0;
  bool is_new_ = false;
};

/// Of a file that an earlier run has completed; empty where there is none, or an empty one. Throws DescriptionError when
/// it is another rollout's, or not complete.
std::optional<Tally> finished_rollout(const std::string& path, const RolloutRequest& request);

/// Files "out.0-of-3" beside `out` that processes of another number than `count` left, one of each number.
std::map<int, std::string> other_parts(const std::string& out, int count);

/// Puts the files of all shards, in any order, into one with the bytes that a run without shards writes. Throws
/// DescriptionError that names the file that is missing, double, incomplete or of another rollout, and when `out` is there
/// and anything but a file of this rollout.
Tally merge_rollouts(const std::vector<std::string>& parts, const std::string& out);

}  // namespace cli
