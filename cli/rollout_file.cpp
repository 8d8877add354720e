#include "rollout_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <system_error>

#include "graphsolve/simd/lanes.hpp"
#include "physics/scene_io.hpp"
#include "rollout_lines.hpp"

namespace cli {

using Json = nlohmann::ordered_json;
using physics::DescriptionError;

namespace {

constexpr int flush_after = 64;  ///< records

std::string hash(const std::string& text) {
  std::uint64_t value = 14695981039346656037u;  // FNV-1a
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return fmt::format("{:016x}", value);
}

Json to_json(const physics::Vec3& v) { return {v.x(), v.y(), v.z()}; }
/// JSON has no infinity.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace

long long Tally::failed() const {
  const auto solved = statuses.find("solved");
  return copies - (solved == statuses.end() ? 0 : solved->second);
}

std::string rollout_header(const RolloutRequest& request, const Shard& shard) {
  std::ostringstream scene;
  physics::write_scene_json(request.mechanism, scene);
  Json vary = Json::array();
  for (const physics::Variation& v : request.variations) vary.push_back({{"key", v.key}, {"low", v.low}, {"high", v.high}});
  return Json{{"format", "graphsolve-rollout"},
              {"version", 1},
              {"program", "graphsolve " GRAPHSOLVE_VERSION},
              {"instruction_set", graphsolve::simd::name(graphsolve::simd::instruction_set())},
              {"scene", request.scene},
              {"scene_hash", hash(scene.str())},
              {"copies", request.copies},
              {"steps", request.steps},
              {"time_step_s", request.mechanism.time_step},
              {"tolerance_m_per_s", request.tolerance},
              {"seed", request.seed},
              {"vary", vary},
              {"shard", fmt::format("{}/{}", shard.index, shard.count)}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);  // names of files are bytes
}

std::string rollout_record(const RolloutRequest& request, const physics::CopyResult& r) {
  Json json{{"copy", r.copy}};
  const std::vector<double> values = physics::draw(request.variations, request.seed, r.copy);
  Json vary = Json::object();
  for (std::size_t i = 0; i < values.size(); ++i) vary[request.variations[i].key] = values[i];
  json["vary"] = vary;
  json["status"] = graphsolve::name(r.last.status);
  json["steps"] = r.steps;
  if (!r.ok()) json["place"] = r.place;
  json["start_correction_m_per_s"] = r.start_correction;
  if (r.start_contact >= 0) {
    const physics::Contact& contact = request.mechanism.contacts[r.start_contact];
    json["start_inside"] = {{"body", request.mechanism.bodies[contact.body.index].name},
                            {"contact", contact.name},
                            {"depth_m", r.start_depth}};
  }
  json["iterations"] = r.iterations;
  json["most_iterations"] = r.most_iterations;
  json["substepped_steps"] = r.substepped_steps;
  json["restarted_steps"] = r.restarted_steps;
  json["new_force_direction_steps"] = r.turned_steps;
  json["largest_residual_m_per_s"] = finite(r.residual);
  json["smallest_distance_m"] = finite(r.smallest_distance);
  json["joint_error"] = finite(r.joint_error);
  json["energy_J"] = {{"start", finite(r.energy_start)}, {"end", finite(r.energy_end)}};
  Json bodies = Json::array();
  for (const physics::BodyRecord& body : r.bodies) {
    const physics::Quat& q = body.orientation;
    bodies.push_back({{"position", to_json(body.position)},
                      {"orientation", {q.w(), q.x(), q.y(), q.z()}},
                      {"velocity", to_json(body.velocity)},
                      {"angular_velocity", to_json(body.angular_velocity)}});
  }
  json["bodies"] = bodies;
  return json.dump();
}

std::string start_inside_text(const std::string& body, const std::string& contact, double depth) {
  return fmt::format("body '{}' by {:.3g} m at contact '{}'", body, depth, contact);
}

std::string start_inside_text(const physics::Mechanism& scene, const physics::CopyResult& result) {
  if (result.start_contact < 0) return {};
  const physics::Contact& contact = scene.contacts[result.start_contact];
  return start_inside_text(scene.bodies[contact.body.index].name, contact.name, result.start_depth);
}

void Tally::add(const Outcome& outcome) {
  ++copies;
  steps += outcome.steps;
  start_correction = std::max(start_correction, outcome.start_correction);
  if (!outcome.start_inside.empty() && inside++ == 0)
    first_inside = fmt::format("copy {}: {}", outcome.copy, outcome.start_inside);
  ++statuses[outcome.status];
  if (outcome.status != "solved" && failures.size() < most_failures_named)
    failures.push_back(fmt::format("copy {}: step {} failed, {} at {}", outcome.copy, outcome.steps + 1LL, outcome.status,
                                   outcome.place));
}

RolloutFile::RolloutFile(const std::string& path, const RolloutRequest& request, const Shard& shard)
    : path_(path), next_(shard.first(request.copies)) {
  const std::string header = rollout_header(request, shard);
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_directory(path, error) &&
      !std::filesystem::is_regular_file(path, error))
    throw DescriptionError(fmt::format("cannot write '{}': only an ordinary file can be continued", path));
  lock_.emplace(path);
  Lines lines(path);
  std::string line;
  const bool begun = lines.in && lines.next(line);
  if (begun) {
    compare(line, header, path);
    next_ = read_records(lines, next_, path, tally_);
    if (next_ > shard.last(request.copies)) throw DescriptionError(path + ": holds more records than its header says");
  } else if (!line.empty() && !header.starts_with(line)) {
    throw DescriptionError(fmt::format("{}: is not a file of a rollout", path));
  }
  lines.in.close();
  if (begun) {
    if (std::filesystem::file_size(path) != lines.size) std::filesystem::resize_file(path, lines.size, error);
    if (error) throw DescriptionError(fmt::format("cannot write '{}': {}", path, error.message()));
  } else {
    physics::check_writable(path);
  }
  out_.open(path, std::ios::binary | (begun ? std::ios::app : std::ios::trunc));
  if (!out_) throw DescriptionError(fmt::format("cannot write '{}': {}", path, std::generic_category().message(errno)));
  is_new_ = !begun;
  if (!begun) out_ << header << '\n';
  flush();
}

void RolloutFile::abandon() {
  std::error_code error;
  if (is_new_) std::filesystem::remove(path_, error);
}

void RolloutFile::add(const std::string& record) {
  out_ << record << '\n';
  is_new_ = false;
  ++next_;
  if (++unflushed_ >= flush_after) flush();
}

void RolloutFile::flush() {
  unflushed_ = 0;
  if (!out_.flush()) throw DescriptionError(fmt::format("cannot write '{}': {}", path_, std::generic_category().message(errno)));
}

std::optional<Tally> finished_rollout(const std::string& path, const RolloutRequest& request) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return {};
  if (!std::filesystem::is_regular_file(path, error))
    throw DescriptionError(fmt::format("cannot write '{}': it is there and no ordinary file", path));
  Lines lines(path);
  std::string line;
  if (!lines.next(line)) {
    if (line.empty()) return {};
    throw DescriptionError(fmt::format("{}: is not a file of a rollout", path));
  }
  compare(line, rollout_header(request, {}), path);
  Tally tally;
  const long long due = read_records(lines, 0, path, tally);
  if (due != request.copies)
    throw DescriptionError(fmt::format("{}: holds {} of {} copies, of a run without mpirun: go on without it, or give --out "
                                       "another name",
                                       path, due, request.copies));
  return tally;
}

std::map<int, std::string> other_parts(const std::string& out, int count) {
  const std::filesystem::path path(out);
  const std::string begin = path.filename().string() + ".";
  std::map<int, std::string> found;
  std::error_code error;
  std::filesystem::directory_iterator entries(path.has_parent_path() ? path.parent_path() : ".", error), end;
  for (; !error && entries != end; entries.increment(error)) {
    const std::string name = entries->path().filename().string();
    if (!name.starts_with(begin)) continue;
    Shard shard;
    char rest = 0;
    const bool read = std::sscanf(name.c_str() + begin.size(), "%d-of-%d%c", &shard.index, &shard.count, &rest) == 2;
    if (!read || shard.count == count) continue;
    std::string& first = found[shard.count];
    const std::string file = (path.parent_path() / name).string();
    if (first.empty() || file < first) first = file;
  }
  return found;
}

}  // namespace cli
