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
#include <type_traits>

#include "graphsolve/simd/lanes.hpp"
#include "physics/scene_io.hpp"

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

Json parse(const std::string& line, const std::string& where) {
  Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) throw DescriptionError(fmt::format("{}: is not a line of a rollout", where));
  return json;
}

/// The value of a key that has to be there and of this type.
template <class Value>
Value get(const Json& json, const char* key, const std::string& where) {
  const auto found = json.find(key);
  const bool fits = found != json.end() && (std::is_same_v<Value, std::string> ? found->is_string() : found->is_number_integer());
  if (!fits) throw DescriptionError(fmt::format("{}: is not a line of a rollout (its key '{}')", where, key));
  return found->get<Value>();
}

/// What goes on with a file; a shard among others has another way out.
constexpr const char* go_on = "GRAPHSOLVE_SIMD={} goes on with it where the processor can, another file begins anew";

/// Two headers that should be equal. advice: where the instruction sets differ; {} is the one that was found.
void compare(const std::string& found, const std::string& wanted, const std::string& path, const char* advice = go_on) {
  if (found == wanted) return;
  const Json have = parse(found, path + ":1"), want = Json::parse(wanted);
  for (const auto& [key, value] : want.items()) {
    const Json other = have.value(key, Json());
    if (other == value) continue;
    if (key == "format") throw DescriptionError(fmt::format("{}: is not a file of a rollout", path));
    if (key == "instruction_set" && other.is_string())
      throw DescriptionError(fmt::format("{}: was computed by the instruction set {}, not {}, and last digits differ: {}", path,
                                         other.get<std::string>(), value.get<std::string>(),
                                         fmt::format(fmt::runtime(advice), other.get<std::string>())));
    throw DescriptionError(fmt::format("{}: holds a rollout with {} {}, not {}", path, key, other.dump(), value.dump()));
  }
  throw DescriptionError(fmt::format("{}: its header says more than this program writes", path));
}

/// Reads complete lines only; `size` is where the last of them ends.
struct Lines {
  explicit Lines(const std::string& path) : in(path, std::ios::binary) {}
  bool next(std::string& line) {
    if (!std::getline(in, line) || in.eof()) return false;
    size += line.size() + 1;
    return true;
  }
  std::ifstream in;
  std::uintmax_t size = 0;
};

/// Counts the records of a shard's file, which must be the copies in order. Returns the copy that is due.
long long read_records(Lines& lines, long long first, const std::string& path, Tally& tally) {
  std::string line;
  for (long long copy = first;; ++copy) {
    if (!lines.next(line)) return copy;
    if (!line.starts_with(fmt::format("{{\"copy\":{},", copy)))
      throw DescriptionError(fmt::format("{}:{}: is not the record of copy {}", path, copy - first + 2, copy));
    const std::string where = fmt::format("{}:{}", path, copy - first + 2);
    const Json record = parse(line, where);
    tally.add({copy, get<int>(record, "steps", where), get<std::string>(record, "status", where),
               record.contains("place") ? get<std::string>(record, "place", where) : ""});
  }
}

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

void Tally::add(const Outcome& outcome) {
  ++copies;
  steps += outcome.steps;
  ++statuses[outcome.status];
  if (outcome.status != "solved" && failures.size() < most_failures_named)
    failures.push_back(fmt::format("copy {}: step {} failed, {} at {}", outcome.copy, outcome.steps + 1, outcome.status,
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

Tally merge_rollouts(const std::vector<std::string>& parts, const std::string& out) {
  struct Part {
    std::string path;
    Shard shard;
  };
  std::vector<Part> found;
  Json common;
  for (const std::string& path : parts) {
    Lines lines(path);
    std::string line;
    if (!lines.in) throw DescriptionError(fmt::format("{}: cannot be read: {}", path, std::generic_category().message(errno)));
    if (!lines.next(line)) throw DescriptionError(fmt::format("{}: is not a file of a rollout", path));
    Json header = parse(line, path + ":1");
    Shard shard;
    if (std::sscanf(get<std::string>(header, "shard", path + ":1").c_str(), "%d/%d", &shard.index, &shard.count) != 2 || shard.index < 0 ||
        shard.index >= shard.count)
      throw DescriptionError(fmt::format("{}: is not a file of a rollout", path));
    (void)get<std::string>(header, "instruction_set", path + ":1");
    header["shard"] = "0/1";
    if (found.empty()) common = header;
    compare(header.dump(), common.dump(), path, "compute all shards by one, such as GRAPHSOLVE_SIMD=plain everywhere");
    found.push_back({path, shard});
  }
  std::stable_sort(found.begin(), found.end(), [](const Part& a, const Part& b) { return a.shard.index < b.shard.index; });
  const int count = found.empty() ? 0 : found.front().shard.count;
  for (const Part& part : found)
    if (part.shard.count != count)
      throw DescriptionError(fmt::format("{}: is shard {}/{}, and {} is {}/{}", part.path, part.shard.index, part.shard.count,
                                         found.front().path, found.front().shard.index, count));
  for (std::size_t i = 1; i < found.size(); ++i)
    if (found[i].shard.index == found[i - 1].shard.index)
      throw DescriptionError(fmt::format("shard {}/{} is there twice: {} and {}", found[i].shard.index, count, found[i - 1].path,
                                         found[i].path));
  for (int i = 0; i < count; ++i)
    if (i >= static_cast<int>(found.size()) || found[i].shard.index != i)
      throw DescriptionError(fmt::format("shard {}/{} is missing", i, count));

  const auto copies = get<long long>(common, "copies", found.front().path + ":1");
  Tally tally;
  std::ostringstream text;
  text << common.dump() << '\n';
  for (const Part& part : found) {
    Lines lines(part.path);
    std::string line;
    lines.next(line);
    const long long due = read_records(lines, part.shard.first(copies), part.path, tally);
    if (due != part.shard.last(copies))
      throw DescriptionError(fmt::format("{}: is not complete: copy {} is due", part.path, due));
    Lines again(part.path);
    again.next(line);
    while (again.next(line)) text << line << '\n';
  }
  physics::write_text_file(text.str(), out);
  return tally;
}

}  // namespace cli
