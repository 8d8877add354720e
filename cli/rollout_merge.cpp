#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>

#include "graphsolve/io/output_file.hpp"
#include "physics/mechanism.hpp"
#include "rollout_lines.hpp"

namespace cli {

using physics::DescriptionError;

namespace {

struct Part {
  std::string path;
  Shard shard;
};

/// The headers of all parts, which agree but for their shards, as that of a file of all copies.
Json read_headers(const std::vector<std::string>& paths, std::vector<Part>& found) {
  Json common;
  for (const std::string& path : paths) {
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
  return common;
}

/// Sorts them; they have to be the shards of one number, each once.
void check_shards(std::vector<Part>& found) {
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
}

/// What is there already has to be the beginning of the same, or nothing.
void check_target(const std::string& out, const Json& header) {
  std::error_code error;
  if (std::filesystem::file_size(out, error) == 0) return;
  Lines lines(out);
  std::string line;
  const bool same = lines.next(line) && line == header.dump();
  if (!same)
    throw DescriptionError(fmt::format("'{}' is there already and not a file of this rollout: give --out another name, or "
                                       "remove it",
                                       out));
}

/// All of them are looked at before any is written: what is no ordinary file, such as a pipe, could not take them back.
void check_records(const Part& part, long long copies, Tally& tally) {
  Lines lines(part.path);
  std::string line;
  lines.next(line);
  const long long due = read_records(lines, part.shard.first(copies), part.path, tally);
  if (due != part.shard.last(copies))
    throw DescriptionError(fmt::format("{}: is not complete: copy {} is due", part.path, due));
}

/// One line at a time: together they may be more than the memory.
void copy_records(const Part& part, long long copies, graphsolve::io::OutputFile& file) {
  Lines lines(part.path);
  std::string line;
  lines.next(line);
  for (long long copy = part.shard.first(copies); copy < part.shard.last(copies); ++copy) {
    if (!lines.next(line)) throw DescriptionError(fmt::format("{}: has changed while it was read", part.path));
    file.write(line += '\n');
  }
}

}  // namespace

Tally merge_rollouts(const std::vector<std::string>& parts, const std::string& out) {
  std::vector<Part> found;
  const Json common = read_headers(parts, found);
  check_shards(found);
  std::optional<FileLock> lock;
  if (std::error_code error; !out.starts_with("/dev/") && std::filesystem::is_regular_file(out, error)) {
    lock.emplace(out);
    check_target(out, common);
  }
  const auto copies = get<long long>(common, "copies", found.front().path + ":1");
  Tally tally;
  for (const Part& part : found) check_records(part, copies, tally);
  graphsolve::io::OutputFile file(out, [](const std::string& path, std::string_view reason) {
    throw DescriptionError(fmt::format("cannot write '{}': {}", path, reason));
  });
  file.write(common.dump() + '\n');
  for (const Part& part : found) copy_records(part, copies, file);
  file.commit();
  return tally;
}

}  // namespace cli
