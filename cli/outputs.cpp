#include "outputs.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "physics/scene_io.hpp"

namespace cli {

namespace fs = std::filesystem;

namespace {

/// However it is spelled. Devices can be written to twice.
bool same_file(const std::string& a, const std::string& b) {
  if (a.starts_with("/dev/")) return false;
  std::error_code error;
  return a == b || fs::weakly_canonical(fs::absolute(a), error) == fs::weakly_canonical(fs::absolute(b), error);
}

/// Under another name too, such as a link.
bool overwrites(const std::string& output, const std::string& input) {
  std::error_code error;
  return !input.empty() && (same_file(output, input) || (fs::is_regular_file(input, error) && fs::equivalent(output, input, error)));
}

}  // namespace

void check_outputs(const std::vector<Output>& outputs, const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const auto& [option, path] = outputs[i];
    if (path.empty()) continue;
    for (std::size_t j = 0; j < i; ++j)
      if (!outputs[j].path.empty() && same_file(outputs[j].path, path))
        throw physics::DescriptionError(fmt::format("{} and {} are the same file '{}'", outputs[j].option, option, path));
    for (const std::string& input : inputs)
      if (overwrites(path, input)) throw physics::DescriptionError(fmt::format("{} would overwrite the input '{}'", option, input));
    physics::check_writable(path);
  }
}

void write_and_print(const std::vector<FileText>& files, const std::string& report) {
  try {
    for (const auto& [path, text] : files)
      if (!path.empty()) physics::write_text_file(text, path);
  } catch (const physics::DescriptionError&) {
    fmt::print("{}", report);
    throw;
  }
  fmt::print("{}", report);
}

}  // namespace cli
