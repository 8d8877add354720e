#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "physics/trajectory.hpp"

/// Scene and trajectory files, format `graphsolve-scene` version 1: JSON, or TOML for people.
///
/// Reading checks the schema only: keys, kinds of values, names of bodies. What the values must satisfy is checked
/// by `validate`, which the Simulator calls, so that a reader may still change them (a shorter time step, say); its
/// errors have a place, whose line `line_in_scene` finds.
///
/// Errors are DescriptionErrors that say where: "scene.json:14:9: syntax error ..." or
/// "scene.json:14: bodies[2].mass: is a string, expected a number".
///
/// Numbers are written in the fewest digits, at most 17, that read back as the same bits. What JSON cannot say, a
/// number that is not finite or a name that is not UTF-8, is a DescriptionError before anything is written.
namespace physics {

/// Reads a scene or a trajectory; a plain scene gives no steps. The ending tells the spelling: .json or .toml.
Trajectory read_scene(const std::string& path);

/// The same from text; `file_name` is what errors call it.
Trajectory parse_scene_json(std::string_view text, std::string_view file_name = "scene.json");
Trajectory parse_scene_toml(std::string_view text, std::string_view file_name = "scene.toml");

/// Line, from 1, of the value at a place, "bodies[2].mass" (DescriptionError::place), in a scene file, which is read
/// again; of what would hold it where the file leaves it out. Throws as read_scene does.
std::int64_t line_in_scene(const std::string& path, std::string_view place);

void write_scene_json(const Mechanism& mechanism, std::ostream& out);
void write_trajectory_json(const Trajectory& trajectory, std::ostream& out);
/// One row per record, one column per number, for spreadsheets and plots; the scene itself is not in it.
void write_trajectory_csv(const Trajectory& trajectory, std::ostream& out);

// To a file: written beside it under another name and renamed when complete, so that the file is never half
// written. Throw DescriptionError: "cannot write 'x/y.json': No such directory".
void write_scene_json(const Mechanism& mechanism, const std::string& path);
void write_trajectory_json(const Trajectory& trajectory, const std::string& path);
void write_trajectory_csv(const Trajectory& trajectory, const std::string& path);
/// Any text, in the same safe way.
void write_text_file(std::string_view text, const std::string& path);

/// Throws what writing to this path would throw, and leaves nothing behind. Ask before a long computation.
void check_writable(const std::string& path);

/// Writes a trajectory while it is computed, so that it need not be held in memory.
class TrajectoryWriter {
 public:
  /// The ending tells the format: .json or .csv. Throws DescriptionError when the file cannot be written.
  TrajectoryWriter(const std::string& path, const Mechanism& mechanism);
  /// Without `commit` nothing remains, and a file that was there before is untouched.
  ~TrajectoryWriter();
  TrajectoryWriter(TrajectoryWriter&&) noexcept;
  TrajectoryWriter& operator=(TrajectoryWriter&&) noexcept;

  void add(const StepRecord& record);
  /// Completes the file, says in it why the run failed if it did, and gives it its name. Throws DescriptionError, on a
  /// full disk for example.
  void commit(const std::optional<FailureRecord>& failure = {});
  /// After `add` or `commit` has thrown: completes the file with the records that got into it, and returns the step of the
  /// last. Empty where there is none, or no ordinary file; then nothing remains.
  std::optional<int> commit_what_is_there();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace physics
