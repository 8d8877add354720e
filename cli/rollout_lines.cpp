#include "rollout_lines.hpp"

#include "physics/mechanism.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

constexpr int deepest = 16;  ///< levels of nesting, more than lines have; copying and comparing recurse

}  // namespace

Json parse(const std::string& line, const std::string& where) {
  const auto shallow = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth > deepest) throw DescriptionError(fmt::format("{}: is not a line of a rollout", where));
    return true;
  };
  Json json = Json::parse(line, shallow, false);
  if (!json.is_object()) throw DescriptionError(fmt::format("{}: is not a line of a rollout", where));
  return json;
}

void compare(const std::string& found, const std::string& wanted, const std::string& path,
             const char* advice) {
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

long long read_records(Lines& lines, long long first, const std::string& path, Tally& tally) {
  std::string line;
  for (long long copy = first;; ++copy) {
    if (!lines.next(line)) return copy;
    if (!line.starts_with(fmt::format("{{\"copy\":{},", copy)))
      throw DescriptionError(fmt::format("{}:{}: is not the record of copy {}", path, copy - first + 2, copy));
    const std::string where = fmt::format("{}:{}", path, copy - first + 2);
    const Json record = parse(line, where);
    std::string start_inside;
    if (const auto inside = record.find("start_inside"); inside != record.end())
      start_inside = start_inside_text(get<std::string>(*inside, "body", where), get<std::string>(*inside, "contact", where),
                                       get<double>(*inside, "depth_m", where));
    tally.add({copy, get<int>(record, "steps", where), get<std::string>(record, "status", where),
               record.contains("place") ? get<std::string>(record, "place", where) : "",
               get<double>(record, "start_correction_m_per_s", where), start_inside});
  }
}

}  // namespace cli
