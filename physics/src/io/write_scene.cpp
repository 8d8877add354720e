#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <vector>

#include "graphsolve/io/output_file.hpp"
#include "io/write.hpp"
#include "physics/scene_io.hpp"

namespace physics {

namespace io {  // by name: TrajectoryWriter::Impl has members of these

class OutputFile : public graphsolve::io::OutputFile {
 public:
  explicit OutputFile(const std::string& path) : graphsolve::io::OutputFile(path, refuse) {}

 private:
  static void refuse(const std::string& path, std::string_view reason) {
    throw DescriptionError(fmt::format("cannot write '{}': {}", path, reason));
  }
};

enum class Format { json, csv };

Format format_of(const std::string& path) {
  if (path.ends_with(".json")) return Format::json;
  if (path.ends_with(".csv")) return Format::csv;
  throw DescriptionError(fmt::format("cannot write '{}': a trajectory file ends in .json or .csv", path));
}

/// Gives out the pieces of a trajectory in either format.
class Pieces {
 public:
  Pieces(Format format, const Mechanism& mechanism) : format_(format), mechanism_(mechanism) {}
  [[nodiscard]] std::string begin() const {
    return format_ == Format::json ? io::json_header(mechanism_) : io::csv_header(mechanism_);
  }
  [[nodiscard]] std::string next(const StepRecord& record) {
    if (format_ == Format::csv) return io::csv_row(record, mechanism_);
    return (first_ ? (first_ = false, "") : io::json_step_separator) + io::json_step(record);
  }
  [[nodiscard]] std::string end(const std::optional<FailureRecord>& failure) const {
    return format_ == Format::json ? io::json_end(failure) : io::csv_end(failure, mechanism_);
  }

 private:
  Format format_;
  const Mechanism& mechanism_;
  bool first_ = true;
};

}  // namespace io

namespace {

using io::Format;
using io::Pieces;

void write(Format format, const Trajectory& trajectory, std::ostream& out) {
  Pieces pieces(format, trajectory.mechanism);
  std::string text = pieces.begin();  // all of it, before the first word is out
  for (const StepRecord& record : trajectory.steps) text += pieces.next(record);
  out << text << pieces.end(trajectory.failure);
}

void write(Format format, const Trajectory& trajectory, const std::string& path) {
  io::OutputFile file(path);
  Pieces pieces(format, trajectory.mechanism);
  file.write(pieces.begin());
  for (const StepRecord& record : trajectory.steps) file.write(pieces.next(record));
  file.write(pieces.end(trajectory.failure));
  file.commit();
}

}  // namespace

void write_scene_json(const Mechanism& mechanism, std::ostream& out) { out << io::json_scene(mechanism); }
void write_scene_json(const Mechanism& mechanism, const std::string& path) {
  write_text_file(io::json_scene(mechanism), path);
}
void write_trajectory_json(const Trajectory& trajectory, std::ostream& out) { write(Format::json, trajectory, out); }
void write_trajectory_json(const Trajectory& trajectory, const std::string& path) {
  write(Format::json, trajectory, path);
}
void write_trajectory_csv(const Trajectory& trajectory, std::ostream& out) { write(Format::csv, trajectory, out); }
void write_trajectory_csv(const Trajectory& trajectory, const std::string& path) {
  write(Format::csv, trajectory, path);
}

void write_text_file(std::string_view text, const std::string& path) {
  io::OutputFile file(path);
  file.write(text);
  file.commit();
}

void check_writable(const std::string& path) { io::OutputFile file(path); }

struct TrajectoryWriter::Impl {
  struct Record {
    int step;
    std::int64_t end;  ///< bytes up to there
  };
  Mechanism mechanism;
  io::OutputFile file;
  Pieces pieces;
  std::int64_t bytes = 0;
  std::vector<Record> records;  ///< for a disk that fills up
  Impl(const std::string& path, const Mechanism& scene)
      : mechanism(scene), file(path), pieces(io::format_of(path), mechanism) {}
  void write(const std::string& text) {
    file.write(text);
    bytes += std::ssize(text);
  }
};

TrajectoryWriter::TrajectoryWriter(const std::string& path, const Mechanism& mechanism)
    : impl_(std::make_unique<Impl>(path, mechanism)) {
  impl_->write(impl_->pieces.begin());
}
TrajectoryWriter::~TrajectoryWriter() = default;
TrajectoryWriter::TrajectoryWriter(TrajectoryWriter&&) noexcept = default;
TrajectoryWriter& TrajectoryWriter::operator=(TrajectoryWriter&&) noexcept = default;

void TrajectoryWriter::add(const StepRecord& record) {
  impl_->write(impl_->pieces.next(record));
  impl_->records.push_back({record.step, impl_->bytes});
}

void TrajectoryWriter::commit(const std::optional<FailureRecord>& failure) {
  impl_->file.write(impl_->pieces.end(failure));
  impl_->file.commit();
}

std::optional<int> TrajectoryWriter::commit_what_is_there() {
  const std::string end = impl_->pieces.end({});
  const std::int64_t room = impl_->file.bytes_there() - std::ssize(end);  // what is cut off makes room for the end
  const auto& records = impl_->records;
  const auto behind = std::ranges::upper_bound(records, room, {}, &Impl::Record::end);
  if (behind == records.begin()) return {};
  const Impl::Record& last = *std::prev(behind);
  impl_->file.go_on_behind(last.end);
  impl_->file.write(end);
  impl_->file.commit();
  return last.step;
}

}  // namespace physics
