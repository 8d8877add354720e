#pragma once

#include <string>
#include <vector>

namespace cli {

/// A file that a command is to write; an empty path: it was not asked for.
struct Output {
  std::string option, path;
};

/// Before the work begins: throws DescriptionError when one of them cannot be written, or would overwrite another or one
/// of the files that the command reads (`inputs`; empty paths: there are none).
void check_outputs(const std::vector<Output>& outputs, const std::vector<std::string>& inputs);

/// Writes the files that were asked for, then prints `report`; that is printed too when a file cannot be written, which
/// then throws DescriptionError. So neither a full disk nor a reader that has gone (`| head -1`) costs the other.
struct FileText {
  std::string path, text;
};
void write_and_print(const std::vector<FileText>& files, const std::string& report);

}  // namespace cli
